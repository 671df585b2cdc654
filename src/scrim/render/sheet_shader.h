// SPDX-License-Identifier: Apache-2.0
// Stage 4 of a batch: brings together what one tile of samples needs (extinction, surfaces, lights, shadows) and
// shades it, at texels or at the points where pixels' rays meet the sheet.
#pragma once

#include <scrim/render/batch_fields.h>
#include <scrim/render/batch_lights.h>
#include <scrim/render/eye_view.h>

#include <vector>

namespace scrim {

class SheetShader {
  public:
    SheetShader(const ViewScene& scene, const GroupPlan& group, const BatchFields& fields, const BatchLights& lights,
                const EyeView& eye);

    /// Shades the texels of tile (tx, ty) of plane p, which is sheet `sheet`: 256 x (S, -alpha).
    void shadeTexels(int p, int sheet, int tx, int ty, float* out) const;

    /// Texels a sheet times this is a slope, du/dw.
    double slopeScale() const { return m_group.sheets.texel / m_group.sheets.thickness; }

    /// Shades arbitrary positions on plane p; `samples` are filled in by the caller.
    void shadePoints(int p, const SampleTile& samples, float* out) const;

    /// Shades the cells of tile (tx, ty) of the eye's own raster (per-view splatting); `samples` say where on the plane
    /// they are.
    void shadeCells(int p, const SampleTile& samples, int tx, int ty, float* out) const;

  private:
    struct Gathered;
    void copyTile(const PlaneStack& planes, int p, int tx, int ty, float* to) const;
    void lookUpShadows(int p, const SampleTile& samples, Gathered& rows) const;
    bool classify(int p, const SampleTile& at, int tx, int ty, Gathered& rows) const;
    void shade(int p, const SampleTile& samples, const Gathered& rows, float* out) const;

    const GroupPlan& m_group;
    const BatchFields& m_fields;
    const BatchLights& m_lights;
    const EyeView& m_eye;
    float m_ambient[3];
    // Of each kind of volume: which it is, and what it looks like, without what differs from sample to sample.
    std::vector<int> m_mediumVolumes, m_surfaceVolumes;
    std::vector<SheetMedium> m_media;
    std::vector<SheetSurface> m_surfaces;
};

}  // namespace scrim
