// SPDX-License-Identifier: Apache-2.0
// Stage 4 of a batch: collects what a tile of samples needs (extinction, surfaces, lights, shadows)
// and shades it, at texels or at the points where pixels' rays meet the sheet.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/light/light_sweep.h>
#include <scrim/engine/shade/level_sheets.h>
#include <scrim/engine/shade/screen_motion.h>
#include <scrim/engine/shade/sample_rows.h>
#include <scrim/engine/shade/shade_tile.h>
#include <scrim/engine/splat/extinction_sum.h>
#include <scrim/engine/lamps/cell_light.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace scrim {

class SheetShader {
  public:
    /// Shades what is in the sheets of `level`, with what coarser levels have there, in the light that passes all.
    SheetShader(const ViewScene& scene, const Plan& plan, const LevelSheets& level, const EyeView& eye,
                const std::vector<CellLight>& cellLight, OtherLevels others = {});
    /// Shades the balls of a volume (ViewVolume::balls), whose rows are given.
    SheetShader(const ViewScene& scene, const Plan& plan, const LevelSheets& level, const EyeView& eye,
                const std::vector<CellLight>& cellLight, OtherLevels others, std::size_t ofBalls);

    /// What is at 256 samples that lie at places of their own in a sheet.
    struct GivenRows {
        struct alignas(64) Row {
            Real values[kTileSize];
        };
        alignas(64) Real extinction[kTileSize];
        Real behind[kTileSize];     ///< how far behind the sheet's first face they are, sheets
        std::vector<Row> scatter;   ///< three where the albedo is a grid, else none
        std::vector<Row> emission;  ///< one for each of ViewBalls::emission
        std::vector<Row> velocity;  ///< three where the layer `motion` needs them, else none
        void resize(std::size_t scatters, std::size_t emissions, std::size_t axes) {
            scatter.resize(scatters);
            emission.resize(emissions);
            velocity.resize(axes);
        }
    };
    /// Shades balls. The light that arrives at each has passed what is in the sheet before it.
    void shadeGiven(int p, const SampleTile& samples, const GivenRows& given, Real* out, ShadeWork& work) const;

    /// Shades the texels of tile (tx, ty) of plane p, which is sheet `sheet`, in the layout of the group's outputs.
    ShadeWork shadeTexels(int p, int sheet, int tx, int ty, Real* out) const;

    /// Shades points of plane p where pixels' rays meet it. `open`: see Surface::classify. `onward`: the rays are those
    /// of this thread's call before. Returns false, and leaves `out` empty, if nothing is visible.
    bool shadePoints(int p, const SampleTile& samples, const std::uint8_t* open, bool onward, Real* out,
                     ShadeWork& work) const;
    /// The same with per-view splatting; the points are those of tile `cells` of the eye's own lattice.
    bool shadeCells(int p, const SampleTile& samples, const Int2& cells, const std::uint8_t* open, bool onward,
                    Real* out, ShadeWork& work) const;

    /// True if a coarser level has anything near these texels in its sheet.
    bool anyCoarser(const Box2<double>& texels) const;

    /// Factor that converts texels per sheet to a slope du/dw.
    double slopeScale() const { return m_group.sheets.texel / m_group.sheets.thickness; }

  private:
    struct Rows;
    /// A volume in the sheets of this level, or of a coarser one.
    struct Seen {
        int level;  ///< 0: this one; otherwise one more than the index into OtherLevels::coarser
        const ExtinctionSum::Volume* volume;
        bool held;  ///< it is held out
        bool grid;  ///< its albedo is a grid
    };
    const ExtinctionSum& extinctionOf(int level) const {
        return level == 0 ? m_extinction : m_others.coarser[std::size_t(level - 1)]->extinction;
    }
    int levels() const { return static_cast<int>(m_others.coarser.size()) + 1; }
    void addVolumes(const ViewScene& scene, const Plan& plan, int level);
    // Without volumes.
    SheetShader(const ViewScene& scene, const Plan& plan, const LevelSheets& level, const EyeView& eye,
                OtherLevels others);
    void addMedium(const ViewScene& scene, const Plan& plan, const Seen& seen);
    void finishVolumes(const ViewScene& scene, const std::vector<CellLight>& cellLight);
    void addWithinSheet(int p, const SampleTile& samples, const GivenRows& given, Rows& rows) const;
    Rows& rowsFor(std::size_t lights) const;
    std::optional<int> outputOf(int sceneVolume) const;
    template <class Read>
    void gather(const Read& read, Rows& rows) const;
    void gatherPoints(int p, const SampleTile& samples, Rows& rows) const;
    void addCoarserShadows(int p, const SampleTile& samples, Rows& rows) const;
    void addFinerShadows(int p, const SampleTile& samples, Rows& rows) const;
    void addSeen(const Seen& volume, const Real* extinction, Rows& rows) const;
    bool surfacesAlone() const;
    void classify(int p, const SampleTile& at, const std::uint8_t* open, bool onward, Rows& rows,
                  ShadeWork& work) const;
    bool shadeGathered(int p, const SampleTile& samples, Rows& rows, Real* out, ShadeWork& work) const;
    void addLit(const Rows& rows, SampleRows& lit) const;
    bool glows(const Rows& rows) const;
    void chooseScattered(const std::vector<CellLight>& cellLight);
    void lookUpScattered(int sheet, const SampleTile& samples, Rows& rows) const;
    void fillMotion(int p, const SampleTile& samples, Rows& rows) const;
    void fillOpacities(Rows& rows) const;
    ShadeInput inputOf(int p, const SampleTile& samples, Rows& rows) const;

    const Plan& m_plan;
    const GroupPlan& m_group;
    const ExtinctionSum& m_extinction;
    const LightSweep& m_lights;
    const EyeView& m_eye;
    bool m_alone;               // one medium has all of the extinction
    bool m_opacities = false;   // those of volumes are wanted
    bool m_holdouts = false;    // some volumes are held out
    std::vector<bool> m_unlit;  // for each light, whether it lights none of the media
    Real m_ambient[3];
    Real m_emitting;  // the group's share of emission
    const OtherLevels m_others;
    std::vector<LevelMap> m_toCoarser, m_toFiner;
    // The constant part of volumes' looks, and these volumes.
    std::vector<SheetMedium> m_media;
    std::vector<Rgb> m_tints;  // of the media's extinction
    std::vector<SheetSurface> m_surfaces;
    std::vector<Seen> m_mediumVolumes, m_surfaceVolumes;
    std::vector<std::pair<int, const ExtinctionSum::Emission*>> m_emissions;  // with their levels
    bool m_ofBalls = false;
    bool m_ballsFlow = false;            // they have velocities, and the layer `motion` needs them
    ExtinctionSum::Volume m_ballVolume;  // only of balls
    std::vector<ExtinctionSum::Emission> m_ballEmissions;
    // The light on cells that the group shows, and where it is looked up.
    std::vector<SheetScattered> m_scatteredParts;
    std::vector<std::shared_ptr<const VolumeLight>> m_scatteredFields;
    std::optional<ScreenMotion> m_motion;  // only if a layer needs it
};

}  // namespace scrim
