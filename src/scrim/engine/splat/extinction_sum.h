// SPDX-License-Identifier: Apache-2.0
// Stages 1 and 2 of a batch: every volume's fields into their own sheets, and the sum of what is extinct there, which
// eye and lights pass through.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/engine/splat/surface.h>
#include <scrim/engine/splat/field_planes.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <memory>
#include <vector>

namespace scrim {

class ExtinctionSum {
  public:
    /// Who looks at the sheets: lights need extinction only, the eye what scatters, too, and one of its sweeps
    /// emission.
    enum class For { light, eye, primaryEye };
    static For eyeOf(const GroupPlan& group) { return group.primary > 0 ? For::primaryEye : For::eye; }

    /// On the cells of `lattice`. `scene`, `plan`, `sheets` and `lattice` must outlive this.
    ExtinctionSum(const ViewScene& scene, const Plan& plan, const Sheets& sheets, const Lattice& lattice,
                  int batchSheets, For who);

    /// Splats and classifies sheets [firstSheet, firstSheet + count) into planes [0, count). Returns the footprints
    /// that were added. See FieldPlanes::splat.
    std::uint64_t splat(int firstSheet, int count, const NeededTiles* needed = nullptr, const TileCull& cull = {});

    /// An extinction channel of all volumes together, per world unit. Where there is one volume these are its own
    /// planes.
    const PlaneStack& total(int channel) const {
        return m_totals.empty() ? m_volumes.front().extinction() : m_totals[channel];
    }
    /// The planes whose active tiles are all those where anything is.
    const PlaneStack& covered() const { return total(0); }

    /// A volume that has extinction, or several that look alike.
    struct Volume {
        int sceneVolume = 0;                    ///< its place among the scene's, or the first one's
        std::unique_ptr<Surface> surface = {};  ///< of a classified volume
        const PlaneStack* density = nullptr;    ///< of a medium: its extinction
        std::array<const PlaneStack*, 3> scatter =
            {};                                      ///< where the albedo is a grid: what each colour scatters; or null
        std::array<const PlaneStack*, 3> flow = {};  ///< VolumeMotion::flow, where the layer `motion` looks at it

        const PlaneStack& extinction() const { return density ? *density : surface->extinction(); }
    };
    const std::vector<Volume>& volumes() const { return m_volumes; }

    /// Radiance per world unit = planes times colour.
    struct Emission {
        const PlaneStack* planes;
        Rgb color;
        int sceneVolume;
    };
    const std::vector<Emission>& emissions() const { return m_emissions; }

    std::uint64_t voxels() const { return m_voxels; }
    std::size_t bytes() const;
    /// An upper estimate beforehand.
    static std::size_t bytes(const ViewScene& scene, const Plan& plan, const Sheets& sheets, const Lattice& lattice,
                             int batchSheets, For who);

  private:
    void addUp(int plane);

    const ExtinctionChannels& m_channels;
    std::vector<Volume> m_volumes;
    std::vector<Emission> m_emissions;
    std::vector<std::unique_ptr<FieldPlanes>> m_own;  // all fields but those of surfaces
    std::vector<FieldPlanes*> m_fields;               // all of them
    std::vector<PlaneStack> m_totals;                 // one a channel, only where extinction is not that of one volume
    std::uint64_t m_voxels = 0;
};

}  // namespace scrim
