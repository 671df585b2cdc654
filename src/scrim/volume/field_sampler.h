// SPDX-License-Identifier: Apache-2.0
// The value of a field at a point: that of a voxel, or between voxels as a kernel reconstructs it. All code that
// examines fields point by point asks here; the splatter, which streams whole fields, does not.
#pragma once

#include <scrim/volume/block_index.h>
#include <scrim/volume/kernel.h>

namespace scrim {

/// All positions are in index space. Safe to use from many threads at once.
class FieldSampler {
  public:
    /// `field` must outlive this object.
    explicit FieldSampler(const SparseField& field, Kernel kernel = Kernel::linear);

    Kernel kernel() const { return m_kernel; }
    const BlockIndex& index() const { return m_index; }

    /// Value of voxel `is`; 0 where it is not active.
    double voxel(const Int3& is) const { return m_index.voxel(is); }
    /// Value of the voxel whose cell contains `is`.
    double nearest(const Vec3& is) const;
    /// The reconstructed field: the sum of all voxels' kernels.
    double value(const Vec3& is) const;
    /// Central differences of the reconstructed field along the three axes, over one voxel to either side: twice the
    /// gradient, per voxel.
    Vec3 difference(const Vec3& is) const;

    /// True only if no voxel is active within the kernel's reach of the ball of `radius` voxels around `is`, so that
    /// the field is 0 there.
    bool emptyAround(const Vec3& is, double radius) const;
    /// How far a point can go from `is` along `direction`, in multiples of `direction`, while the linearly
    /// reconstructed field is known to be constant within `radius` voxels of it along each axis. Below 0 where it is
    /// not known to be constant at `is` itself.
    double evenAlong(const Vec3& is, const Vec3& direction, double radius) const;

  private:
    double linear(const Vec3& is) const;

    BlockIndex m_index;
    Kernel m_kernel;
    Bounds m_reached;  // outside of it the field is 0
};

/// A copy of the voxels in a small box, for many look-ups close together, in about a third of FieldSampler's time. For
/// one thread.
class FieldBrick {
  public:
    /// Copies what look-ups within the box `is`, and up to one voxel outside of it, need. Returns false, and copies
    /// nothing, if the box is too large, or if the field is not interpolated linearly: ask `field` then.
    bool fill(const FieldSampler& field, const Bounds& is);
    float value(const Vec3& is) const;
    /// As FieldSampler::difference.
    Vec3 difference(const Vec3& is) const;

  private:
    Int3 m_lower{0}, m_size{0};
    std::vector<float> m_values;  // (x * m_size.y + y) * m_size.z + z, from m_lower
};

}  // namespace scrim
