// SPDX-License-Identifier: Apache-2.0
// Splats a field onto the cells of a perspective view, as the paper does: for per-view splatting alone.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/splat/footprint.h>
#include <scrim/engine/splat/plane_stack.h>
#include <scrim/engine/splat/splatter.h>
#include <scrim/geometry/lattice.h>
#include <scrim/geometry/spaces.h>
#include <scrim/volume/sparse_field.h>

#include <cstdint>
#include <limits>

namespace scrim {

/// Splats a field onto the cells of a perspective view. Every footprint is warped by the Jacobian
/// of the projection at its voxel (ZC02 section 6: "the footprints are individually warped").
///
/// The footprint is tabulated once, finely, as the kernel's mean through the sheet along the view's middle ray, and
/// looked up at every cell that it covers. The error is of second order in the angle between a voxel's own ray and the
/// middle ray (times the sheet's thickness), and in the size of a voxel relative to its distance from the view.
class WarpedSplatter {
  public:
    /// `field` must outlive this object. Voxel values are multiplied by `scale` and clamped to `most`.
    WarpedSplatter(const SparseField& field, const Mat4& tsFromIs, const Lattice& raster, Kernel kernel,
                   int stepsPerVoxel, Real scale, Real most = std::numeric_limits<float>::max());

    /// As FieldSplatter::splat.
    std::uint64_t splat(int firstSheet, int lastSheet, PlaneStack& planes, int firstPlane, const TileCull& cull) const;

    const FootprintTable& table() const { return m_table; }

  private:
    struct Target;
    void splatOneBlock(const Int3& origin, const float* values, Target& target) const;
    void splatTile(const Int3& origin, int edge, const float* values, Target& target) const;
    void splatVoxel(const Vec3& ts, Real value, Target& target) const;

    const SparseField& m_field;
    Mat4 m_tsFromIs;
    Lattice m_raster;
    Real m_scale, m_most;
    double m_finer;          // the table's columns per texel
    Vec2 m_slope;            // slope of the ray through the middle of the field, texels per sheet
    FootprintTable m_table;  // in the space in which the middle ray is upright
    Vec3 m_extent;           // half a footprint, in texels and sheets
    double m_first, m_last;  // offsets in N of the first and last voxel of a block
};

}  // namespace scrim
