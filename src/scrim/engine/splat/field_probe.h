// SPDX-License-Identifier: Apache-2.0
// The reconstructed field at any point: the sum of all voxels' kernels, by definition. Slow and plain; the truth
// that footprints, tables and sheets are measured against.
#pragma once

#include <scrim/engine/splat/kernel.h>
#include <scrim/volume/sparse_field.h>

#include <cstdint>
#include <unordered_map>

namespace scrim {

class FieldProbe {
  public:
    /// `field` must outlive this.
    FieldProbe(const SparseField& field, Kernel kernel);

    /// Value of voxel `is`; 0 where it is not active.
    double voxel(const Int3& is) const;

    /// The reconstructed field at `is` (index space).
    double value(const Vec3& is) const;

    /// True where no voxel within the kernel's reach of the ball of `radius` voxels around `is` can be active:
    /// the field is 0 there.
    bool emptyAround(const Vec3& is, double radius) const;

    Kernel kernel() const { return m_kernel; }

  private:
    static std::uint64_t key(const Int3& block);
    const float* block(const Int3& coordinate) const;

    const SparseField& m_field;
    Kernel m_kernel;
    std::unordered_map<std::uint64_t, const float*> m_blocks;
};

}  // namespace scrim
