// SPDX-License-Identifier: Apache-2.0
// The picture during a sweep: pixels in tiles of 16 x 16, so that the states of one task lie together in memory;
// what hides parts of their rays; and how the results become the frame: sums over sweeps, means over a pixel's rays.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/zeroed_array.h>
#include <scrim/geometry/sheets.h>
#include <scrim/image/image.h>
#include <scrim/engine/light/backdrop.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/model/plan.h>
#include <scrim/geometry/camera.h>
#include <scrim/image/depth_picture.h>
#include <scrim/scene/view_scene.h>
#include <scrim/solid/solids.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace scrim {

class PixelTiles {
  public:
    /// The first visible thing of a ray begins somewhere within a sheet. Its place is computed from the optical depths
    /// of the first three sheets. If the optical depth of a full sheet is tau, and the sheets before it have a
    /// together, it begins a / tau of a sheet before the full one (exact if it is homogeneous behind its surface). If
    /// only one sheet contains it, it is taken to be in the sheet's middle.
    struct FirstDepth {
        Real depth = 0;  ///< along the viewing axis; 0: nothing is visible
        Real next = 0;   ///< optical depths of the sheets behind the first one; front to back, of those walked so far
        Real after = 0;
        Real last = 0;  ///< depth of the sheet that was walked last; front to back, 0 once the result is known
    };

    /// `depth`: also keeps the depth of the first visible thing.
    explicit PixelTiles(const PixelWindow& region, const OutputLayout& layout = {}, bool depth = false)
        : m_region(region),
          m_layout(layout),
          m_keepsDepth(depth),
          m_window(tilesAround(region)),
          m_tilesX(m_window.width() / kTileEdge),
          m_tilesY(m_window.height() / kTileEdge) {
        reset();
    }

    /// Makes all pixels black and transparent.
    void reset() {
        m_states = ZeroedArray<Real>(std::size_t(count()) * tileFloats());
        m_depth = ZeroedArray<FirstDepth>(m_keepsDepth ? std::size_t(count()) * kTileSize : 0);
        m_opaque.assign(std::size_t(count()), 0);
        m_closed = ZeroedArray<std::uint8_t>(std::size_t(count()) * kTileSize);
        m_closedAt.assign(std::size_t(count()), -1);
    }

    const PixelWindow& region() const { return m_region; }
    int count() const { return m_tilesX * m_tilesY; }
    Box2<int> all() const { return {0, 0, m_tilesX, m_tilesY}; }
    int tilesX() const { return m_tilesX; }
    int tilesY() const { return m_tilesY; }
    /// Raster position of the tile's corner.
    int cornerX(int tile) const { return m_window.x0 + tile % m_tilesX * kTileEdge; }
    int cornerY(int tile) const { return m_window.y0 + tile / m_tilesX * kTileEdge; }
    const OutputLayout& layout() const { return m_layout; }
    /// States of the tile's 256 pixels: (C, -A) in the layout, see composite_tile.h.
    Real* states(int tile) { return m_states.data() + std::size_t(tile) * tileFloats(); }
    const Real* states(int tile) const { return m_states.data() + std::size_t(tile) * tileFloats(); }
    /// State of pixel (x, y) of the region.
    const Real* state(int x, int y) const { return m_states.data() + indexOf(x, y) * std::size_t(m_layout.floats()); }
    /// Depths of a tile's pixels; 0: nothing is visible. Only valid if depths are kept.
    bool keepsDepth() const { return m_keepsDepth; }
    FirstDepth* depths(int tile) { return m_depth.data() + std::size_t(tile) * kTileSize; }
    Real depth(int x, int y) const { return m_depth[indexOf(x, y)].depth; }
    /// The index of pixel (x, y) of the region: tile after tile, kTileSize pixels each.
    std::size_t indexOf(int x, int y) const {
        const int dx = x - m_window.x0, dy = y - m_window.y0;
        const int tile = dy / kTileEdge * m_tilesX + dx / kTileEdge;
        return std::size_t(tile) * kTileSize + std::size_t(dy % kTileEdge * kTileEdge + dx % kTileEdge);
    }
    std::size_t bytes() const {
        return m_states.size() * sizeof(Real) + m_depth.size() * sizeof(FirstDepth) + m_closed.size();
    }
    /// For each of a tile's pixels whether it was opaque (a transmittance below `cutoff`) where block `block` of sheets
    /// began: it then receives nothing of the block, whichever batches and tiles the block and the pixel are in.
    const std::uint8_t* closed(int tile, int block, Real cutoff);
    bool opaque(int tile) const { return m_opaque[tile] != 0; }
    void setOpaque(int tile) { m_opaque[tile] = 1; }

    /// The tiles that a box of raster positions touches.
    Box2<int> tilesIn(const Box2<double>& positions) const;

    /// True if one of the tiles is not opaque; tiles outside of the picture do not count.
    bool anyOpen(const Box2<int>& tiles) const;
    bool anyOpen(const Box2<double>& positions) const { return anyOpen(tilesIn(positions)); }

  private:
    std::size_t tileFloats() const { return std::size_t(kTileSize * m_layout.floats()); }

    PixelWindow m_region;
    OutputLayout m_layout;
    bool m_keepsDepth;
    PixelWindow m_window;  // of all tiles
    int m_tilesX, m_tilesY;
    ZeroedArray<Real> m_states;
    ZeroedArray<FirstDepth> m_depth;
    std::vector<std::uint8_t> m_opaque;
    ZeroedArray<std::uint8_t> m_closed;
    std::vector<int> m_closedAt;  // for each tile the block that m_closed is for
};

/// Objects that hide parts of pixels' rays: solids and depth pictures, at which rays end, and
/// samples of deep pictures, which hide in part.
class EyeEnds {
  public:
    /// True if anything hides a part of the scene's rays.
    static bool any(const ViewScene& scene);

    /// Traces the rays through the centres of all pixels of `tiles`, those of the scene's antialiasing raster.
    EyeEnds(const ViewScene& scene, const PixelTiles& tiles);

    /// Depths along the viewing axis, for a tile's 256 pixels, from which on nothing is visible;
    /// infinity where nothing hides. Null: nothing hides in the whole tile.
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

/// A black frame with all layers that the scene requests.
Frame emptyFrame(const ViewScene& scene);

/// Adds the result of the sweep of `group`, which is in `tiles`.
void resolve(const ViewScene& scene, const Plan& plan, const GroupPlan& group, const PixelTiles& tiles, Frame& frame);

/// Begins the layer `backdrop`, which the frame must have, as if there were no volumes. It has four
/// floats a pixel until finishBackdrop().
void beginBackdrop(const BackdropRays& backdrop, Frame& frame);

/// Takes from that layer what the volumes hide of it in a group's sweep.
void takeFromBackdrop(const Plan& plan, const GroupPlan& group, const PixelTiles& tiles, const BackdropRays& backdrop,
                      Frame& frame);

/// Adds that layer to the picture and its alpha.
void finishBackdrop(Frame& frame);

/// Completes the layers that depend on the sum of all sweeps.
void finishLayers(Frame& frame);

}  // namespace scrim
