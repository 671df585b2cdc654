// SPDX-License-Identifier: Apache-2.0
// What every ray of a sweep meets, kept sheet by sheet beside the sums of compositing, for deep pictures. The order of
// the sheets does not matter: a ray's samples become a curve from front to back once the sweep is done. Apart from
// the compositor, which without a deep picture knows nothing of it but a null pointer.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/engine/model/plan.h>
#include <scrim/image/deep_image.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scrim {

/// Different tiles may be added to from different threads.
class DeepRays {
  public:
    /// For a sweep over `tiles`, which must outlive this. `tolerance`: of the deep picture; a part of it is spent on
    /// samples of neighbouring sheets that are merged while the sweep goes on, in places that do not depend on how many
    /// sheets a batch has. `mostBytes`: that samples may take; 0: any number.
    DeepRays(const PixelTiles& tiles, bool frontToBack, double tolerance, std::size_t mostBytes);

    /// 256 shaded samples in the layout of the tiles. `part`: how much of the sheet is seen, and null where all of it
    /// is; the middle of that part lies `at` - `step` behind the middle of the sheet, in sheets along N. `open`: the
    /// rays that see it, and null where all do.
    struct Crossing {
        int sheet;
        const Real* samples;
        const std::uint8_t* open = nullptr;
        const Real* part = nullptr;
        const Real* at = nullptr;
        Real step = 0;
    };
    /// Throws Error(memory).
    void add(int tile, const Crossing& crossing);

    /// Means over the n x n rays of each pixel, in depth along the viewing axis. All rays of a pixel count as if they
    /// crossed the sheets where its middle does, so a depth is wrong by at most half of what a sheet's depth changes
    /// by across the pixel. Takes the samples: afterwards there are none. `eye`: that of the raster.
    DeepImage resolve(const EyeView& eye, int n);

    /// Bytes of all samples.
    std::size_t bytes() const { return m_bytes; }
    /// Samples that were added, merged ones too.
    std::uint64_t added() const { return m_added; }

    /// A sample of this size is kept for a ray and a sheet that has anything for it, before merging.
    static constexpr std::size_t kSampleBytes = 36;

  private:
    struct Sample {
        float begin, end;  // sheets from the eye's side: N front to back, or else -N
        float rgb[3];
        float hides[3];
        std::uint32_t ray : 8;    // of the tile
        std::uint32_t held : 24;  // see setHeld
    };
    using Channels = std::array<double, 3>;
    void setHeld(const Channels& seen, const Channels& hidden, Sample& sample) const;
    double seenShare(const Sample& sample, std::size_t channel) const;
    static_assert(sizeof(Sample) == kSampleBytes);
    struct Tile {
        std::vector<Sample> samples;
        std::size_t done = 0;  // samples that are merged already
        int stage = -1;
    };
    using Firsts = std::array<std::uint32_t, kTileSize + 1>;  // of each ray's samples; and one more
    Firsts byRay(Tile& tile, std::size_t from) const;
    DeepCurve curveOf(const Sample* first, const Sample* last) const;
    Sample compositeOf(const Sample*& sample, const DeepPiece& piece) const;
    void compact(Tile& tile);
    void count(std::size_t before, std::size_t after);

    const PixelTiles& m_pixels;
    bool m_frontToBack;
    double m_tolerance;
    std::size_t m_mostBytes;
    std::vector<Tile> m_tiles;
    std::atomic<std::size_t> m_bytes{0};
    std::atomic<std::uint64_t> m_added{0};
};

/// The deep picture of all sweeps; `groups`: what each of the plan's left behind. Its curves end with the flat
/// picture's pixels, but for rounding.
DeepImage combined(const ViewScene& scene, const Plan& plan, const std::vector<DeepImage>& groups);

}  // namespace scrim
