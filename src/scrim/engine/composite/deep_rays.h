// SPDX-License-Identifier: Apache-2.0
// Records, for deep pictures, the samples of every ray of a sweep, sheet by sheet, beside the sums of compositing. The
// order of the sheets does not matter: after the sweep, a ray's samples are turned into a curve from front to back.
// This is separate from the compositor, which has a null pointer to it if there is no deep picture.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/composite/composite_tile.h>
#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/engine/model/plan.h>
#include <scrim/image/deep_image.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scrim {

/// Different threads may add to different tiles at once.
class DeepRays {
  public:
    /// For a sweep over `tiles`, which must outlive this object. `tolerance` is that of the deep picture; a part of it
    /// is spent on merging samples of neighbouring sheets during the sweep, at places that do not depend on the number
    /// of sheets in a batch. `mostBytes`: limit on the samples' memory; 0: none.
    DeepRays(const PixelTiles& tiles, bool frontToBack, double tolerance, std::size_t mostBytes);
    ~DeepRays();

    /// The sheets of one level of a sweep, in sheets of the first level: where sheet 0 begins, and how thick each is.
    struct Level {
        int number = 0;
        double first = 0, thickness = 1;
    };
    /// Adds the samples of sheet `sheet` to a tile; their layout is that of the tiles. The middle
    /// of a sample's visible part lies `samples.at` - `step` behind the middle of the sheet, in the
    /// level's sheets along N. Throws Error(memory).
    void add(int tile, const Level& level, int sheet, const SheetSamples& samples, Real step);

    /// Averages the n x n rays of each pixel, by depth along the viewing axis. All rays of a pixel are treated as if
    /// they crossed the sheets where the pixel's centre does, so a depth is wrong by at most half of its change across
    /// the pixel. Removes the samples. `eye` is that of the raster, on the sheets of the first level.
    DeepImage resolve(const EyeView& eye, int n);

    /// Bytes of all samples.
    std::size_t bytes() const { return m_bytes; }
    /// Number of samples that were added, including merged ones.
    std::uint64_t added() const { return m_added; }

    /// Size of the sample that is kept for each ray and sheet with any contents, before merging.
    static constexpr std::size_t kSampleBytes = 36;

  private:
    struct Tile;
    void compact(Tile& tile) const;
    void count(std::size_t before, std::size_t after);

    const PixelTiles& m_pixels;
    bool m_frontToBack;
    double m_tolerance;
    std::size_t m_mostBytes;
    std::vector<Tile> m_tiles;
    std::atomic<std::size_t> m_bytes{0};
    std::atomic<std::uint64_t> m_added{0};
};

/// The deep picture of all sweeps; `groups` holds the results of the plan's groups. Its curves end
/// with the flat picture's pixels, up to rounding.
DeepImage combined(const ViewScene& scene, const Plan& plan, const std::vector<DeepImage>& groups);

}  // namespace scrim
