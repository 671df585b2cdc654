// SPDX-License-Identifier: Apache-2.0
// Stages 1 and 2 of a batch: every volume's fields into their own sheets, and the sum of their extinctions, which eye
// and lights pass through.
#pragma once

#include <scrim/engine/splat/extinction_rows.h>
#include <scrim/engine/splat/field_planes.h>

#include <array>
#include <memory>
#include <vector>

namespace scrim {

/// Who looks at the sheets: lights need extinction only, the eye what scatters, too, and one of its sweeps emission.
enum class SheetsFor { light, eye, primaryEye };
inline SheetsFor sheetsForEye(const GroupPlan& group) {
    return group.primary > 0 ? SheetsFor::primaryEye : SheetsFor::eye;
}

class BatchFields {
  public:
    /// Into the raster of `raster`, which may be the sheets' own or a view's. `scene`, `rows` and `sheets` must outlive
    /// this.
    BatchFields(const ViewScene& scene, const ExtinctionRows& rows, const Sheets& sheets, const ViewRaster& raster,
                int batchSheets, double voxel, SheetsFor who);

    /// Splats and classifies sheets [firstSheet, firstSheet + count) into planes [0, count).
    /// See VolumePlanes::splat.
    SplatWork splat(int firstSheet, int count, const NeededTiles* needed = nullptr, const TileCull& cull = {});

    /// A row of total extinction, per world unit. Where there is one volume these are its own planes.
    const PlaneStack& extinction(int row) const {
        return m_totals.empty() ? m_volumes.front().density->extinction() : m_totals[static_cast<std::size_t>(row)];
    }
    /// The planes whose active tiles are all those where anything is.
    const PlaneStack& covered() const { return extinction(0); }

    /// The volumes that have extinction.
    int volumeCount() const { return static_cast<int>(m_volumes.size()); }
    const VolumePlanes& volume(int i) const { return *m_volumes[static_cast<std::size_t>(i)].density; }
    /// Their place among the scene's.
    int sceneVolume(int i) const { return m_volumes[static_cast<std::size_t>(i)].sceneVolume; }
    /// Of a volume whose albedo is a grid: what it scatters of channel c, before its tint. Null otherwise.
    const VolumePlanes* scatter(int i, int c) const {
        return m_volumes[static_cast<std::size_t>(i)].scatter[static_cast<std::size_t>(c)].get();
    }

    int emissionCount() const { return static_cast<int>(m_emissions.size()); }
    const VolumePlanes& emission(int e) const { return *m_emissions[static_cast<std::size_t>(e)].planes; }
    const Rgb& emissionColor(int e) const { return m_emissions[static_cast<std::size_t>(e)].color; }

    std::uint64_t voxels() const { return m_voxels; }
    std::size_t bytes() const;

    /// An upper estimate of what the sheets will take.
    static std::size_t bytes(const ViewScene& scene, const ExtinctionRows& rows, const Sheets& sheets,
                             const ViewRaster& raster, int batchSheets, SheetsFor who);

  private:
    struct Volume {
        int sceneVolume = 0;
        std::unique_ptr<VolumePlanes> density;
        std::array<std::unique_ptr<VolumePlanes>, 3> scatter = {};
    };
    struct Emission {
        std::unique_ptr<VolumePlanes> planes;
        Rgb color;
    };
    void addUp(int plane);

    const ExtinctionRows& m_rows;
    // Fields that are not a volume's own density, as volumes of their own.
    std::vector<std::unique_ptr<const ViewVolume>> m_further;
    std::vector<Volume> m_volumes;
    std::vector<Emission> m_emissions;
    std::vector<VolumePlanes*> m_all;
    std::vector<PlaneStack> m_totals;  // one a row, only where extinction is not that of one volume
    std::uint64_t m_voxels = 0;
};

}  // namespace scrim
