// SPDX-License-Identifier: Apache-2.0
// The innermost loop of Scrim: the voxels of one block into some consecutive sheets. Vectorised, and compiled
// once for every instruction set that the processor may have.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/splat/footprint.h>
#include <scrim/engine/splat/splatter.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace scrim {

/// How the blocks of a field are splatted.
struct BlockSplat {
    /// Where a block lies in texel space: its first voxel at whole + fraction on each axis. Split so that floats only ever
    /// hold offsets within a block, however large the raster is.
    struct Place {
        std::int32_t wholeU, wholeV, wholeN;
        Real fractionU, fractionV, fractionN;
    };

    const LatticeOrder* order;
    const FootprintTable* table;
    /// Of up to kMost fields that share their footprints: the plane of sheet `firstSheet`.
    static constexpr int kMost = 4;
    std::array<Real*, kMost> planes;
    int fields;
    std::ptrdiff_t planeStride;  ///< floats from one sheet's plane to the next
    std::int32_t rowStride;      ///< floats from one row of texels to the next
    std::int32_t firstSheet;     ///< sheets [firstSheet, lastSheet) are written
    std::int32_t lastSheet;
    Real scale;                  ///< factor on every value
    Real most;                   ///< scaled values above it count as it
    std::int32_t width, height;  ///< of the planes, texels
    bool clipped;                ///< footprints may leave the planes; those that do are left out
    Simd simd = {};
};

/// Adds the footprints of the voxels [first, second) of the lattice order to the sheets: of each field with `values` (512
/// floats in `blockOffset` order) times scale, at most `most`. Voxels of value 0 are skipped. Returns the number of
/// footprints (voxel and sheet pairs), which all fields share.
std::uint64_t splatBlock(const BlockSplat& splat, const BlockSplat::Place& place, const float* const* values, int first,
                         int second);

}  // namespace scrim
