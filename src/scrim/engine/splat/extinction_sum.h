// SPDX-License-Identifier: Apache-2.0
// Stages 1 and 2 of a batch: splats every volume's fields into their own sheets, and sums their
// extinction, which eye and lights pass through.
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
    /// The user of the sheets. Lights need extinction only, the eye also scattering, and one of the
    /// eye's sweeps emission.
    enum class For { light, eye, primaryEye };
    static For eyeOf(const GroupPlan& group) { return group.primary > 0 ? For::primaryEye : For::eye; }

    /// On the cells of `lattice`, of the scene's volumes `among`; empty: of all. `scene`, `plan`,
    /// `sheets` and `lattice` must outlive this object.
    ExtinctionSum(const ViewScene& scene, const Plan& plan, const Sheets& sheets, const Lattice& lattice,
                  int batchSheets, For who, const std::vector<bool>& among = {});

    /// Splats and classifies sheets [firstSheet, firstSheet + count) into planes [0, count).
    /// Returns the footprints that were added. See FieldPlanes::splat.
    std::uint64_t splat(int firstSheet, int count, const NeededTiles* needed = nullptr, const TileCull& cull = {});

    /// For users who take few sheets at a time, one after the other: makes planes from 0 on those
    /// of the sheets from `sheet` on, and returns how many there are, at most `count`. It splats as
    /// many as a batch holds, up to `end`, and keeps them: voxels reach into several sheets, and a
    /// single one has little for threads to share. Adds to `footprints`.
    int take(int sheet, int count, int end, const NeededTiles& needed, std::uint64_t& footprints);

    /// An extinction channel summed over all volumes, per world unit. If there is one volume, these are its own planes.
    const PlaneStack& total(int channel) const {
        return m_totals.empty() ? m_volumes.front().extinction() : m_totals[channel];
    }
    /// Planes whose active tiles are all tiles with any contents.
    const PlaneStack& covered() const { return total(0); }
    /// The same of what the eye sees in the sheets: all but volumes whose points it sees as balls.
    const PlaneStack& seen(int channel) const { return m_seen.empty() ? total(channel) : m_seen[std::size_t(channel)]; }

    /// A volume with extinction, or several that look alike.
    struct Volume {
        int sceneVolume = 0;                    ///< index of the volume, or of the first one, in the scene
        std::unique_ptr<Surface> surface = {};  ///< only for a classified volume
        const PlaneStack* density = nullptr;    ///< only for a medium: its extinction
        /// Only if the albedo is a grid: the scattering of each colour; otherwise null.
        std::array<const PlaneStack*, 3> scatter = {};
        std::array<const PlaneStack*, 3> flow = {};  ///< VolumeMotion::flow, if the layer `motion` needs it

        const PlaneStack& extinction() const { return density ? *density : surface->extinction(); }
    };
    const std::vector<Volume>& volumes() const { return m_volumes; }
    /// The surfaces, if all extinction is theirs and grey; empty otherwise. Rays may then ask them
    /// for the extinction along their own course, instead of interpolating between that of texels.
    const std::vector<const Surface*>& surfacesAlone() const { return m_surfacesAlone; }
    /// Promises that nobody reads the values of `total`, but only which of its tiles are active, if surfaces are alone.
    void leaveOutTexels() { m_texelsWanted = m_surfacesAlone.empty(); }

    /// A source of emission: radiance per world unit is the planes times the colour.
    struct Emission {
        const PlaneStack* planes;
        Rgb color;
        int sceneVolume;
    };
    const std::vector<Emission>& emissions() const { return m_emissions; }

    std::uint64_t voxels() const { return m_voxels; }
    std::size_t bytes() const;
    /// Upper bound on the bytes, known beforehand.
    static std::size_t bytes(const ViewScene& scene, const Plan& plan, const Sheets& sheets, const Lattice& lattice,
                             int batchSheets, For who, const std::vector<bool>& among = {});

  private:
    void addSums(const ViewScene& scene, const Plan& plan, const Lattice& lattice, int batchSheets, For who,
                 bool totals);
    void addUp(int plane, bool all, std::vector<PlaneStack>& totals);
    void countFrom(int plane);

    const ExtinctionChannels& m_channels;
    std::vector<Volume> m_volumes;
    std::vector<const Surface*> m_surfacesAlone;
    std::vector<Emission> m_emissions;
    std::vector<std::unique_ptr<FieldPlanes>> m_own;  // all fields except those of surfaces
    std::vector<FieldPlanes*> m_fields;               // all fields
    std::vector<PlaneStack> m_seen;                   // one for each channel; only if some volumes are balls
    std::vector<bool> m_asBalls;                      // for each of m_volumes
    std::vector<PlaneStack> m_totals;  // one for each channel; only if extinction is not that of a single volume
    std::uint64_t m_voxels = 0;
    bool m_texelsWanted = true;
    int m_batchSheets;
    int m_firstKept = 0, m_endKept = 0;  // the sheets that `take` has splatted
};

}  // namespace scrim
