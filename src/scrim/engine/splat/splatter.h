// SPDX-License-Identifier: Apache-2.0
// Feeds one field to the sheets: active voxels only, block by block in a fixed order, constant tiles as blocks
// that are never allocated (algorithm, "Feeding the splatter").
#pragma once

#include <scrim/base/simd.h>
#include <scrim/engine/splat/footprint.h>
#include <scrim/engine/splat/lattice_order.h>
#include <scrim/engine/splat/plane_stack.h>
#include <scrim/volume/sparse_field.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace scrim {

struct SplatWork {
    std::uint64_t voxels = 0;      ///< voxels of value > 0 in the field (fed once each)
    std::uint64_t footprints = 0;  ///< voxel and sheet pairs that were added

    SplatWork& operator+=(const SplatWork& other) {
        voxels += other.voxels;
        footprints += other.footprints;
        return *this;
    }
};

/// Says of a closed box of tiles (x0, y0, x1, y1) that nobody sees what is splatted there: ZC02 Fig. 5's occlusion map.
using TileCull = std::function<bool(int, int, int, int)>;

class FieldSplatter {
  public:
    /// `field` must outlive this. `tsFromIs` takes its index space to texel space; voxel values are multiplied
    /// by `scale`, and count as `most` above it; positions are quantised to `stepsPerVoxel`.
    FieldSplatter(const SparseField& field, const Mat4& tsFromIs, Kernel kernel, int stepsPerVoxel, float scale,
                  FootprintLookup lookup = FootprintLookup::sloped, float most = std::numeric_limits<float>::max(),
                  Simd simd = {});

    const FootprintTable& table() const { return m_table; }

    /// Adds the field to sheets [firstSheet, lastSheet): the mean over each sheet's thickness of the
    /// reconstructed field times scale, at texel centres, goes to planes firstPlane + [0, lastSheet -
    /// firstSheet), on which `begin` was called. Safe to call at once for different planes.
    /// Footprints that do not lie on the planes as a whole are left out, and so are blocks that `cull` does without.
    SplatWork splat(int firstSheet, int lastSheet, PlaneStack& planes, int firstPlane, const TileCull& cull = {}) const;

  private:
    struct Target;
    void splatOneBlock(const Vec3& tsOrigin, const float* values, Target& target) const;
    void splatTile(const Int3& origin, int edge, const float* values, Target& target) const;

    const SparseField& m_field;
    Mat4 m_tsFromIs;
    float m_scale, m_most;
    Simd m_simd;
    FootprintTable m_table;
    LatticeOrder m_order;
    Vec3 m_blockLower, m_blockUpper;            // offsets of a block's voxels in texel space, footprints included
    std::vector<std::uint32_t> m_byFirstSheet;  // blocks, ascending in the first sheet they touch, then in order
    std::vector<std::int32_t> m_firstSheets;    // the same order
    int m_sheetSpan = 0;                        // sheets a block can touch at most
};

}  // namespace scrim
