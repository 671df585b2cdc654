// SPDX-License-Identifier: Apache-2.0
// Stage 4 of a batch: brings together what one tile of samples needs (extinction, surfaces, lights, shadows) and
// shades it, at texels or at the points where pixels' rays meet the sheet.
#pragma once

#include <scrim/engine/splat/extinction_sum.h>
#include <scrim/engine/light/light_sweep.h>
#include <scrim/engine/composite/eye_rays.h>

#include <vector>

namespace scrim {

class SheetShader {
  public:
    SheetShader(const ViewScene& scene, const Plan& plan, const GroupPlan& group, const BatchFields& fields,
                const BatchLights& lights, const EyeView& eye);

    /// Shades the texels of tile (tx, ty) of plane p, which is sheet `sheet`, in the group's layout.
    ShadeWork shadeTexels(int p, int sheet, int tx, int ty, float* out) const;

    /// Texels a sheet times this is a slope, du/dw.
    double slopeScale() const { return m_group.sheets.texel / m_group.sheets.thickness; }

    /// Shades arbitrary positions on plane p; `samples` are filled in by the caller.
    ShadeWork shadePoints(int p, const SampleTile& samples, float* out) const;

    /// Shades the cells of tile (tx, ty) of the eye's own raster (per-view splatting); `samples` say where on the plane
    /// they are.
    ShadeWork shadeCells(int p, const SampleTile& samples, int tx, int ty, float* out) const;

  private:
    struct Medium {
        int volume;  // of m_fields
        bool grid;   // its albedo is one
        SheetMedium look;
    };
    struct Surface {
        int volume;
        SheetSurface look;
    };
    struct Rows;
    template <class Read>
    void gather(const Read& read, Rows& rows) const;
    void lookUpShadows(int p, const SampleTile& samples, Rows& rows) const;
    bool classify(int p, const SampleTile& at, int tx, int ty, Rows& rows, ShadeWork& work) const;
    ShadeWork shadeGathered(int p, const SampleTile& samples, const SampleTile& at, int tx, int ty, Rows& rows,
                            float* out) const;
    ShadeWork shade(int p, const SampleTile& samples, Rows& rows, float* out) const;

    const Plan& m_plan;
    const GroupPlan& m_group;
    const BatchFields& m_fields;
    const BatchLights& m_lights;
    const EyeView& m_eye;
    bool m_alone;  // one medium has all the extinction there is
    float m_ambient[3];
    float m_emitting;  // the group's share of emission
    // What volumes look like, without what differs from sample to sample.
    std::vector<Medium> m_media;
    std::vector<Surface> m_surfaces;
};

}  // namespace scrim
