// SPDX-License-Identifier: Apache-2.0
// The value of a field at a point: that of a voxel, or between voxels as a kernel reconstructs it. All code that
// examines fields point by point asks here; the splatter, which streams whole fields, does not.
#pragma once

#include <scrim/volume/block_index.h>
#include <scrim/volume/kernel.h>

#include <array>
#include <cstddef>
#include <vector>

#include <glm/common.hpp>

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
    /// Central differences of the reconstructed field along the three axes, over one voxel to
    /// either side: twice the gradient, per voxel.
    Vec3 difference(const Vec3& is) const;

    /// True only if no voxel is active within the kernel's reach of the ball of `radius` voxels
    /// around `is`, so that the field is 0 there.
    bool emptyAround(const Vec3& is, double radius) const;
    /// How far a point can go from `is` along `direction`, in multiples of `direction`, while the
    /// linearly reconstructed field is known to be constant within `radius` voxels of it along each
    /// axis. Below 0 where it is not known to be constant at `is` itself.
    double evenAlong(const Vec3& is, const Vec3& direction, double radius) const;

  private:
    double linear(const Vec3& is) const;
    double linearAcross(const Vec3& is, const BlockIndex::Place& first) const;

    BlockIndex m_index;
    Kernel m_kernel;
    Bounds m_reached;  // outside of it the field is 0
};

/// Between the eight voxels from `first` on, whose next ones along x and y are `x` and `y` values
/// away and along z the next; `f` in [0, 1) from the first of them.
inline double trilinear(const float* first, std::ptrdiff_t x, std::ptrdiff_t y, const Vec3& f) {
    const auto between = [](double a, double b, double t) { return a + t * (b - a); };
    const auto along = [&](const float* at) { return between(double(at[0]), double(at[1]), f.z); };
    const auto across = [&](const float* at) { return between(along(at), along(at + y), f.y); };
    return between(across(first), across(first + x), f.x);
}

/// A copy of the voxels in a small box, 0 where none is active, for many look-ups close together: they take about a
/// third of FieldSampler's time, and give the same values as its linear kernel. For one thread.
class FieldBrick {
  public:
    /// Copies the voxels `lower` to `upper`.
    void fill(const BlockIndex& index, const Int3& lower, const Int3& upper);
    /// Copies the voxels that look-ups within `is` need. Returns false, and copies nothing, if they
    /// are too many, or if the field is not interpolated linearly: ask `field` then.
    bool fill(const FieldSampler& field, const Bounds& is);

    /// Interpolates linearly; the eight voxels around `is` must be in the box.
    double value(const Vec3& is) const {
        const Vec3 floor = glm::floor(is);
        return value(Int3(floor), is - floor);
    }
    /// The same for voxel `base` and `f` in [0, 1) beyond it.
    double value(const Int3& base, const Vec3& f) const {
        return trilinear(m_values.data() + offset(base), std::ptrdiff_t(m_size.y) * m_size.z, m_size.z, f);
    }
    /// As FieldSampler::difference.
    Vec3 difference(const Vec3& is) const;

    /// In single precision: the values at `count` points with these coordinates, which are not
    /// negative and count from the first voxel of the box.
    void values(const std::array<const float*, 3>& from, int count, float* values) const;
    /// In single precision: adds `sign` times the values at the points i + f, for all i of a block in blockOffset order
    /// and one f in [0, 1). Points count from the first voxel of the box, which must be 9 voxels wide.
    void addBlock(const Vec3& f, float sign, float* values) const;

  private:
    std::ptrdiff_t offset(const Int3& is) const {
        const Int3 at = is - m_lower;
        return (std::ptrdiff_t(at.x) * m_size.y + at.y) * m_size.z + at.z;
    }
    void copy(const BlockIndex::Place& place, const Int3& cube);

    Int3 m_lower{0}, m_size{0};
    std::vector<float> m_values;
};

}  // namespace scrim
