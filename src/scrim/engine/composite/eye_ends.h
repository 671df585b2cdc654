// SPDX-License-Identifier: Apache-2.0
// What stands in the way of pixels' rays: solids and pictures' depths that hide what is behind them, where rays end,
// and samples of deep pictures that hide a part.
#pragma once

#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/geometry/camera.h>
#include <scrim/image/depth_picture.h>
#include <scrim/scene/view_scene.h>
#include <scrim/solid/solids.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace scrim {

class EyeEnds {
  public:
    /// Does anything stand in the way of the scene's rays?
    static bool any(const ViewScene& scene);

    /// Looks along the rays through the centres of all pixels of `tiles`, those of the scene's antialiasing raster.
    EyeEnds(const ViewScene& scene, const PixelTiles& tiles);

    /// Depths along the viewing axis of a tile's 256 pixels, from which on nothing is seen; infinity where nothing
    /// hides. Null: nothing does in all of the tile.
    const double* depths(int tile) const { return orNull(m_depths[std::size_t(tile)]); }

    /// The same of where something begins that hides a part.
    const double* thinFrom(int tile) const { return orNull(m_thin[std::size_t(tile)]); }

    /// What part is seen, past what hides a part, of the opacity of something even on the ray of raster position
    /// (x, y), of optical depth `tau` over depths [near, far].
    double seenShare(double x, double y, double near, double far, double tau) const;

    std::size_t bytes() const;
    /// That were traced to solids.
    std::uint64_t rays() const { return m_rays; }

  private:
    static const double* orNull(const std::vector<double>& own) { return own.empty() ? nullptr : own.data(); }
    DepthPicture::Pieces piecesAt(double x, double y) const;
    double unitAt(double x, double y) const;

    std::shared_ptr<const DepthPicture> m_picture;
    RayFamily m_rayFamily;
    int m_antialias;
    std::uint64_t m_rays = 0;
    std::vector<std::vector<double>> m_depths, m_thin;  // a tile each
};

}  // namespace scrim
