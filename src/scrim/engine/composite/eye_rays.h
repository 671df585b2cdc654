// SPDX-License-Identifier: Apache-2.0
// The eye as one sweep sees it: where pixels' rays cross the sheets, and which pixels see a texel.
#pragma once

#include <scrim/geometry/camera.h>
#include <scrim/geometry/sheets.h>
#include <scrim/geometry/view_raster.h>
#include <scrim/image/image.h>
#include <scrim/engine/composite/composite_tile.h>
#include <scrim/engine/shade/shade_tile.h>

#include <optional>

namespace scrim {

/// One pixel's ray in texel space: (U, V) = position + slope * (N - reference).
struct PixelRay {
    double u, v;
    double slopeU, slopeV;  ///< texels a sheet
    double startN;          ///< N where the ray begins (the eye, or the near plane)
};

class EyeView {
  public:
    EyeView(const Camera& camera, const Sheets& sheets, Simd simd = {});

    Simd simd() const { return m_simd; }

    /// The ray through raster position (x, y), located at the plane N = `reference`.
    PixelRay ray(double x, double y, double reference) const;

    /// The rays of the 16 x 16 pixels from (x0, y0), through their centres, for a batch whose first plane is at
    /// N = `reference`.
    RayTile rays(int x0, int y0, double reference) const;

    /// The raster of the pixels of tiles of `region`, with `guardTiles` tiles more on each side: what per-view
    /// splatting fills. Pixel (x0, y0) of the region is the first of tile (guardTiles, guardTiles).
    ViewRaster raster(const PixelWindow& region, int guardTiles) const;

    /// Slopes of eye rays at texels, for shading.
    const EyeSlopes& slopes() const { return m_slopes; }

    /// How far apart pixels are on the plane N = `middle`, by the position of a sample there.
    SampleSpacing pixelSpacing(double middle) const;

    /// Writes to `samples` how deep positions on the plane N = `middle` lie.
    void setDepth(double middle, SampleTile& samples) const;

    /// The pixels whose rays may pass through texels [u0, u1] x [v0, v1] of the plane N = `middle`: a closed
    /// box of raster positions, or nothing where no bound is known (next to the eye and behind it).
    struct Box {
        double x0, y0, x1, y1;
    };
    std::optional<Box> seenBy(double u0, double v0, double u1, double v1, double middle) const;

  private:
    bool m_orthographic;
    Simd m_simd;
    RayFamily m_ts;           // origins and directions in texel space
    Mat3 m_rasterFromOffset;  // inverse of the ray family's linear part
    EyeSlopes m_slopes;
};

}  // namespace scrim
