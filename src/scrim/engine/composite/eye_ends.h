// SPDX-License-Identifier: Apache-2.0
// Objects that hide parts of pixels' rays: solids and depth pictures, at which rays end, and samples of deep pictures,
// which hide in part.
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
    /// True if anything hides a part of the scene's rays.
    static bool any(const ViewScene& scene);

    /// Traces the rays through the centres of all pixels of `tiles`, those of the scene's antialiasing raster.
    EyeEnds(const ViewScene& scene, const PixelTiles& tiles);

    /// Depths along the viewing axis, for a tile's 256 pixels, from which on nothing is visible; infinity where nothing
    /// hides. Null: nothing hides in the whole tile.
    const double* depths(int tile) const { return orNull(m_depths[std::size_t(tile)]); }

    /// The same for depths at which something begins that hides in part.
    const double* thinFrom(int tile) const { return orNull(m_thin[std::size_t(tile)]); }

    /// The fraction of the opacity of a homogeneous segment that is visible past objects that hide in part. The segment
    /// lies on the ray at raster position (x, y) and has the optical depth `tau` over depths [near, far].
    double seenShare(double x, double y, double near, double far, double tau) const;

    std::size_t bytes() const;
    /// Number of rays traced to solids.
    std::uint64_t rays() const { return m_rays; }

  private:
    static const double* orNull(const std::vector<double>& own) { return own.empty() ? nullptr : own.data(); }
    DepthPicture::Pieces piecesAt(double x, double y) const;
    double unitAt(double x, double y) const;

    std::shared_ptr<const DepthPicture> m_picture;
    RayFamily m_rayFamily;
    int m_antialias;
    std::uint64_t m_rays = 0;
    std::vector<std::vector<double>> m_depths, m_thin;  // one for each tile
};

}  // namespace scrim
