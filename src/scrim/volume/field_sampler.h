// SPDX-License-Identifier: Apache-2.0
// Asks a field for its value at a place: of one voxel, or between voxels as a kernel reconstructs it. All that looks at
// fields point by point asks here; the splatter, which streams whole fields, does not.
#pragma once

#include <scrim/volume/block_index.h>
#include <scrim/volume/kernel.h>

namespace scrim {

/// All positions are index space. Safe to use from many threads.
class FieldSampler {
  public:
    /// `field` must outlive this.
    explicit FieldSampler(const SparseField& field, Kernel kernel = Kernel::linear);

    Kernel kernel() const { return m_kernel; }
    const BlockIndex& index() const { return m_index; }

    /// Value of voxel `is`; 0 where it is not active.
    double voxel(const Int3& is) const { return m_index.voxel(is); }
    /// Value of the voxel whose cell holds `is`.
    double nearest(const Vec3& is) const;
    /// The reconstructed field: the sum of all voxels' kernels.
    double value(const Vec3& is) const;

    /// True only where no voxel within the kernel's reach of the ball of `radius` voxels around `is` is active: the
    /// field is 0 there.
    bool emptyAround(const Vec3& is, double radius) const;
    /// How far `is` can go along `direction`, in multiples of it, while the linearly reconstructed field is known to be
    /// constant within `radius` voxels along each axis. Below 0 where it is not known to be constant at `is` itself.
    double evenAlong(const Vec3& is, const Vec3& direction, double radius) const;

  private:
    double linear(const Vec3& is) const;

    BlockIndex m_index;
    Kernel m_kernel;
    Bounds m_reached;  // outside of it the field is 0
};

}  // namespace scrim
