// SPDX-License-Identifier: Apache-2.0
// Stages 1 and 2 of a batch: every volume's field into its own sheets, and the sum of their extinctions, which eye
// and lights pass through.
#pragma once

#include <scrim/render/volume_planes.h>

#include <memory>
#include <vector>

namespace scrim {

class BatchFields {
  public:
    /// Into the raster of `raster`, which may be the sheets' own or a view's. `sheets` must outlive this.
    BatchFields(const ViewScene& scene, const Sheets& sheets, const ViewRaster& raster, int batchSheets, double voxel);

    /// Splats and classifies sheets [firstSheet, firstSheet + count) into planes [0, count).
    SplatWork splat(int firstSheet, int count, const TileCull& cull = {});

    /// Total extinction per world unit. Where there is one volume these are its own planes.
    const PlaneStack& extinction() const { return m_total ? *m_total : m_volumes.front()->extinction(); }

    int volumeCount() const { return static_cast<int>(m_volumes.size()); }
    const VolumePlanes& volume(int i) const { return *m_volumes[static_cast<std::size_t>(i)]; }
    std::uint64_t voxels() const { return m_voxels; }
    std::size_t bytes() const;

  private:
    void add(int plane);

    std::vector<std::unique_ptr<VolumePlanes>> m_volumes;
    std::unique_ptr<PlaneStack> m_total;  // only where there are several volumes
    std::uint64_t m_voxels = 0;
};

}  // namespace scrim
