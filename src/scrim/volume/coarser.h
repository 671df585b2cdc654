// SPDX-License-Identifier: Apache-2.0
// A field at half the resolution, for views in which voxels are much smaller than pixels. Flat voxels, as slices of
// scans and ground fog have them, are halved along their short edges until they are cubes.
#pragma once

#include <scrim/volume/sparse_field.h>

#include <array>
#include <map>
#include <memory>
#include <mutex>

namespace scrim {

/// Whether the resolution is halved along x, y and z of the grid.
using HalvedAxes = std::array<bool, 3>;

inline constexpr HalvedAxes kAllAxes{true, true, true};

/// The lengths of a voxel's edges, world units.
Vec3 voxelEdges(const Mat4& wsFromIs);

/// Those axes along which voxels are shortest; edges of less than 1.5 times the shortest count as equal to it.
HalvedAxes shortAxes(const Mat4& wsFromIs);

/// Every coarse voxel begins as the mean of the 2, 4 or 8 fine voxels it covers, empty ones counting as 0; its centre
/// is their centre. Coarse voxel c covers the fine voxels 2c and 2c + 1 on each halved axis, also for negative c. Then
/// neighbours on these axes exchange what linear interpolation between them would blur. The optical depth through the
/// whole field is preserved. The counts of cleaned values are copied.
SparseField coarser(const SparseField& fine, const HalvedAxes& halved = kAllAxes);

/// The coarser levels of fields, each made once, for as long as the field itself is kept. Safe to
/// use from many threads.
class CoarserLevels {
  public:
    /// coarser(*fine, halved).
    std::shared_ptr<const SparseField> below(const std::shared_ptr<const SparseField>& fine,
                                             const HalvedAxes& halved = kAllAxes);

  private:
    using Fine = std::weak_ptr<const SparseField>;
    std::mutex m_mutex;
    std::map<Fine, std::map<HalvedAxes, std::shared_ptr<const SparseField>>, std::owner_less<Fine>> m_below;
};

}  // namespace scrim
