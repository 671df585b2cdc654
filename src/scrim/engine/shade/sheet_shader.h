// SPDX-License-Identifier: Apache-2.0
// Stage 4 of a batch: collects what a tile of samples needs (extinction, surfaces, lights, shadows) and shades it, at
// texels or at the points where pixels' rays meet the sheet.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/light/light_sweep.h>
#include <scrim/engine/shade/screen_motion.h>
#include <scrim/engine/shade/shade_tile.h>
#include <scrim/engine/splat/extinction_sum.h>
#include <scrim/engine/transport/cell_field.h>

#include <memory>
#include <optional>
#include <vector>

namespace scrim {

class SheetShader {
  public:
    SheetShader(const ViewScene& scene, const Plan& plan, const GroupPlan& group, const ExtinctionSum& extinction,
                const LightSweep& lights, const EyeView& eye, const std::vector<CellLight>& cellLight);

    /// Shades the texels of tile (tx, ty) of plane p, which is sheet `sheet`, in the layout of the group's outputs.
    ShadeWork shadeTexels(int p, int sheet, int tx, int ty, Real* out) const;

    /// Shades points of plane p where pixels' rays meet it. `cells`: with per-view splatting, the tile of the eye's own
    /// lattice whose cells they are. `open`: see Surface::classify. `onward`: the rays are those of this thread's call
    /// before. Returns false, and leaves `out` empty, if nothing is visible.
    bool shadePoints(int p, const SampleTile& samples, const std::optional<Int2>& cells, const std::uint8_t* open,
                     bool onward, Real* out, ShadeWork& work) const;

    /// Factor that converts texels per sheet to a slope du/dw.
    double slopeScale() const { return m_group.sheets.texel / m_group.sheets.thickness; }

  private:
    struct Rows;
    Rows& rowsFor(std::size_t lights) const;
    int outputOf(int sceneVolume) const;
    template <class Read>
    void gather(const Read& read, Rows& rows) const;
    void addSeen(std::size_t volume, const Real* extinction, Rows& rows) const;
    bool surfacesAlone() const;
    void passSolids(int p, const SampleTile& samples, Rows& rows) const;
    void classify(int p, const SampleTile& at, const std::uint8_t* open, Rows& rows, ShadeWork& work) const;
    bool shows(const Rows& rows) const;
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
    // The constant part of volumes' looks, and the indices of these volumes in m_extinction.
    std::vector<SheetMedium> m_media;
    std::vector<Rgb> m_tints;  // of the media's extinction
    std::vector<SheetSurface> m_surfaces;
    std::vector<int> m_mediumVolumes, m_surfaceVolumes;
    // The light on cells that the group shows, and where it is looked up.
    std::vector<SheetScattered> m_scatteredParts;
    std::vector<std::shared_ptr<const CellField>> m_scatteredFields;
    std::vector<bool> m_held;              // for each of m_extinction's volumes, whether it is held out
    std::optional<ScreenMotion> m_motion;  // only if a layer needs it
};

}  // namespace scrim
