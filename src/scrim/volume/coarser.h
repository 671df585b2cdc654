// SPDX-License-Identifier: Apache-2.0
// A field at half the resolution, for views in which voxels are much smaller than pixels.
#pragma once

#include <scrim/volume/sparse_field.h>

#include <map>
#include <memory>
#include <mutex>

namespace scrim {

/// Every coarse voxel begins as the mean of the 2^3 fine voxels it covers, empty ones counting as 0; its centre is the
/// centre of the eight. Coarse voxel c covers the fine voxels 2c and 2c + 1 on each axis, also for negative c. Then
/// neighbours exchange what linear interpolation between them would blur. The optical depth through the whole field is
/// preserved. The counts of cleaned values are copied.
SparseField coarser(const SparseField& fine);

/// The coarser levels of fields, each made once, for as long as the field itself is kept. Safe to use from many
/// threads.
class CoarserLevels {
  public:
    /// coarser(*fine).
    std::shared_ptr<const SparseField> below(const std::shared_ptr<const SparseField>& fine);

  private:
    using Fine = std::weak_ptr<const SparseField>;
    std::mutex m_mutex;
    std::map<Fine, std::shared_ptr<const SparseField>, std::owner_less<Fine>> m_below;
};

}  // namespace scrim
