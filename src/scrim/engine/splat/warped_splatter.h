// SPDX-License-Identifier: Apache-2.0
// Splats one field into the raster of a perspective view: every footprint is warped by the Jacobian of the projection
// at its voxel (ZC02 section 6: "the footprints are individually warped").
//
// The footprint is tabulated once, finely, as the kernel's mean through the sheet along the view's middle ray, and
// looked up at every cell that it covers. What that leaves out is of second order: in the angle between a voxel's own
// ray and the middle one (times the sheet's thickness), and in the size of a voxel over its distance from the view.
// Parallel views need none of this: FieldSplatter does them exactly.
#pragma once

#include <scrim/geometry/view_raster.h>
#include <scrim/engine/splat/splatter.h>

namespace scrim {

class WarpedSplatter {
  public:
    /// `field` must outlive this. Voxel values are multiplied by `scale`, and count as `most` above it.
    WarpedSplatter(const SparseField& field, const Mat4& tsFromIs, const ViewRaster& raster, Kernel kernel,
                   int stepsPerVoxel, float scale, float most = std::numeric_limits<float>::max());

    /// As FieldSplatter::splat.
    SplatWork splat(int firstSheet, int lastSheet, PlaneStack& planes, int firstPlane, const TileCull& cull) const;

    const FootprintTable& table() const { return m_table; }

  private:
    struct Target;
    void splatOneBlock(const Int3& origin, const float* values, Target& target) const;
    void splatTile(const Int3& origin, int edge, const float* values, Target& target) const;
    void splatVoxel(const Vec3& ts, float value, Target& target) const;

    const SparseField& m_field;
    Mat4 m_tsFromIs;
    ViewRaster m_raster;
    float m_scale, m_most;
    double m_finer;          // table's columns a texel
    Vec2 m_slope;            // of the ray through the middle of the field, texels a sheet
    FootprintTable m_table;  // of the space in which the middle ray is upright
    Vec3 m_extent;           // half a footprint, in texels and sheets
    double m_first, m_last;  // offsets in N of the first and last voxel of a block
};

}  // namespace scrim
