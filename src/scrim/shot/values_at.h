// SPDX-License-Identifier: Apache-2.0
// The values of one field at the voxels of another.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/volume/field_sampler.h>

#include <cmath>

#include <glm/matrix.hpp>

namespace scrim {

/// True if `map` leads from the voxels of a lattice to those of another that has the same axes, so
/// that the lattices differ by a shift at most.
inline bool keepsAxes(const Mat4& map) {
    constexpr double kRounding = 1e-9;
    for (int axis = 0; axis < 3; ++axis)
        for (int row = 0; row < 3; ++row)
            if (!(std::abs(map[axis][row] - (axis == row ? 1 : 0)) < kRounding)) return false;
    return true;
}

/// It refers to `other`, which must outlive it.
class ValuesAt {
  public:
    ValuesAt(const SparseField& field, const SparseField& other)
        : m_sampler(other), m_toOther(glm::inverse(other.wsFromIs) * field.wsFromIs), m_aligned(keepsAxes(m_toOther)) {
        constexpr double kRounding = 1e-9;
        for (int row = 0; row < 3; ++row) m_aligned = m_aligned && std::abs(m_toOther[3][row]) < kRounding;
    }
    /// The value at the centre of a voxel of the field.
    double at(const Int3& voxel) const {
        return m_aligned ? m_sampler.voxel(voxel) : m_sampler.value(transformPoint(m_toOther, Vec3(voxel)));
    }

  private:
    FieldSampler m_sampler;
    Mat4 m_toOther;
    bool m_aligned;
};

}  // namespace scrim
