// SPDX-License-Identifier: Apache-2.0
// Reconstruction kernels: how a voxel spreads into the space around it (ZC02 section 2). A field is the sum of all
// voxels' kernels; everything else in Scrim, and the reference it is checked against, follows from that.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/scene/dials.h>
#include <scrim/volume/sparse_field.h>

#include <cstdint>
#include <memory>
#include <unordered_map>

namespace scrim {

/// Half the extent, along the direction whose coordinate is the linear form `row` of index space offsets, of the
/// region where the kernel is not 0.
double kernelExtent(Kernel kernel, const Vec3& row);

/// The kernel at `offset` (index space, voxels) from a voxel's centre. Its integral over index space is 1.
double kernelValue(Kernel kernel, const Vec3& offset);

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
    const float* block(const Int3& coordinate) const;

    const SparseField& m_field;
    Kernel m_kernel;
    std::unordered_map<std::uint64_t, const float*> m_blocks;
};

/// A field between its voxels, as the linear kernel reconstructs it, for points that follow one another: remembers the
/// block that was asked for last, so that every thread takes a copy.
class LinearProbe {
  public:
    /// `field` must outlive this and all copies.
    explicit LinearProbe(const SparseField& field);

    /// The field at `is` (index space).
    double value(const Vec3& is) const;

  private:
    using Blocks = std::unordered_map<std::uint64_t, const float*>;
    const float* blockAt(int x, int y, int z) const;
    double voxel(int x, int y, int z) const;

    const SparseField* m_field;
    std::shared_ptr<const Blocks> m_blocks;           // the same for all copies
    mutable std::uint64_t m_key = ~std::uint64_t{0};  // of the block that was asked for last
    mutable const float* m_block = nullptr;
    mutable double m_constant = 0;  // where that is none: a tile's value, or 0
};

}  // namespace scrim
