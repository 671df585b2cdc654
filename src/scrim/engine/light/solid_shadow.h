// SPDX-License-Identifier: Apache-2.0
// Shadows between volumes and solids: those that solids cast onto volumes, and those that volumes cast onto solids
// which catch them. For the latter rays are marched from the solids to the lights, because the points on solids need
// not lie in any sheet, and there is only one for each pixel's ray.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/base/real.h>
#include <scrim/engine/light/solid_raster.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/model/plan.h>
#include <scrim/geometry/camera.h>
#include <scrim/geometry/sheets.h>
#include <scrim/scene/view_scene.h>
#include <scrim/solid/solids.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace scrim {

/// How finely shadows of solids are kept.
struct SolidDetail {
    int parts = 1;      ///< of a cell's edge where an edge of a shadow passes; see SolidRaster
    double margin = 2;  ///< sheets by which light reaches behind a visible lit surface, or ends before a dark one
};

/// Shadows of solids: for each ray of a light's raster, where it first meets a surface. In contrast
/// to optical depth, this is known before the sweep begins, and is a single number for each ray.
class SolidShadow {
  public:
    /// Traces the rays of `view`, a light of a sweep through `sheets`. `camera` tells which side of
    /// a surface is visible.
    SolidShadow(const Solids& solids, const LightView& view, const Sheets& sheets, const Camera& camera,
                const SolidDetail& detail, Simd simd);

    /// Multiplies `light` by the fraction, in [0, 1], that passes the solids to the eye's paths
    /// through sheet n at 256 samples: the mean over these paths.
    void multiply(int n, const SampleTile& samples, Real* light) const;

    /// The same to 256 texel positions in the middle of sheet n.
    void multiply(int n, const Real* u, const Real* v, Real* light) const;

    std::uint64_t rays() const { return m_raster.rays(); }
    std::size_t bytes() const { return m_raster.bytes(); }
    static std::size_t bytes(const LightView& view, const SolidDetail& detail) {
        return SolidRaster::bytes({view.width, view.height}, detail.parts);
    }

  private:
    LightView m_view;
    Simd m_simd;
    double m_toTexels;  // texels of a sheet's thickness
    // The last N that each ray lights; infinity: it lights all sheets.
    SolidRaster m_raster;
};

/// The point on the first solid of the ray at raster position (x, y), if that solid catches shadows.
std::optional<Vec3> caughtAt(const Solids& solids, const RayFamily& rays, double x, double y);

/// Fills the layers `shadow` of `frame`: for each light with shadows (an extended one by its sub-lights), the fraction
/// of red, green and blue that reaches the first solid of a pixel through all volumes, averaged over the pixel's rays.
/// It is 1 where that solid does not catch shadows, or there is none. Solids cast no shadows here; the renderer that
/// draws them does that. Returns the number of rays that were marched. Calls `checkpoint` now and then.
std::uint64_t catchShadows(const ViewScene& scene, Frame& frame, const Checkpoint& checkpoint);

}  // namespace scrim
