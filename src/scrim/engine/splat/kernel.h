// SPDX-License-Identifier: Apache-2.0
// Reconstruction kernels: how a voxel spreads into the space around it (ZC02 section 2). A field is the sum of all
// voxels' kernels; everything else in Scrim, and the reference it is checked against, follows from that.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/scene/dials.h>
#include <scrim/volume/block_index.h>

#include <limits>
#include <memory>
#include <span>

namespace scrim {

/// Half the extent, along the direction whose coordinate is the linear form `row` of index space offsets, of the
/// region where the kernel is not 0.
double kernelExtent(Kernel kernel, const Vec3& row);

/// The kernel at `offset` (index space, voxels) from a voxel's centre. Its integral over index space is 1.
double kernelValue(Kernel kernel, const Vec3& offset);

/// The kernel of voxels twice as large is the sum of such kernels: their weights, by the distance along each axis from
/// its middle, in voxels. Empty where it is not (the Gaussian's).
std::span<const double> twoScaleWeights(Kernel kernel);

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
    BlockIndex m_index;
    Kernel m_kernel;
};

/// A field between its voxels, as the linear kernel reconstructs it, for points that follow one another: remembers the
/// cube that was asked for last, so that every thread takes a copy.
class LinearProbe {
  public:
    /// `field` must outlive this and all copies.
    explicit LinearProbe(const SparseField& field);

    /// The field at `is` (index space).
    double value(const Vec3& is) const;
    /// How far `is` can go along `direction`, in its length, with the field known to be the same within `radius` voxels
    /// along each axis; below 0 where it is not known to be here.
    double evenAlong(const Vec3& is, const Vec3& direction, double radius) const;

  private:
    bool evenHere(const Vec3& is, double radius) const;  // in what was asked for last
    const BlockIndex::Place& placeOf(const Int3& is) const;

    std::shared_ptr<const BlockIndex> m_index;             // the same for all copies
    mutable Int3 m_cube{std::numeric_limits<int>::min()};  // that was asked for last; at first no voxel's
    mutable BlockIndex::Place m_place;                     // what fills it
};

}  // namespace scrim
