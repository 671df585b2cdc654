// SPDX-License-Identifier: Apache-2.0
// The innermost loop of Scrim: the voxels of one block into some consecutive sheets. Vectorised, and compiled
// once for every instruction set that the processor may have.
#pragma once

#include <scrim/base/simd.h>
#include <scrim/engine/splat/footprint.h>
#include <scrim/engine/splat/splatter.h>

#include <cstddef>
#include <cstdint>

namespace scrim {

struct BlockSplat {
    const LatticeOrder* order;
    const FootprintTable* table;
    float* planes;               ///< plane of sheet `firstSheet`
    std::ptrdiff_t planeStride;  ///< floats from one sheet's plane to the next
    std::int32_t rowStride;      ///< floats from one row of texels to the next
    std::int32_t firstSheet;     ///< sheets [firstSheet, lastSheet) are written
    std::int32_t lastSheet;
    float scale;                 ///< factor on every value
    float most;                  ///< scaled values above it count as it
    std::int32_t width, height;  ///< of the planes, texels
    bool clipped;                ///< footprints may leave the planes; those that do are left out
    Simd simd = {};
};

/// Where a block lies in texel space: its first voxel at whole + fraction on each axis. Split so that floats
/// only ever hold offsets within a block, however large the raster is.
struct BlockPlace {
    std::int32_t wholeU, wholeV, wholeN;
    float fractionU, fractionV, fractionN;
};

/// Adds the footprints of the voxels [first, second) of the lattice order, with `values` (512 floats in `blockOffset`
/// order) times scale, at most `most`, to the sheets. Voxels of value 0 are skipped. Returns the number of footprints
/// (voxel and sheet pairs) that were added.
std::uint64_t splatBlock(const BlockSplat& splat, const BlockPlace& place, const float* values, int first, int second);

}  // namespace scrim
