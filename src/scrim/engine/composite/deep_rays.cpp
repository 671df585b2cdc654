// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/composite/deep_rays.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace scrim {
namespace {

// Number of sheets whose samples are merged during the sweep, and the fraction of the tolerance
// spent on that; the rest is for merging the means over rays.
constexpr int kStage = 32;
constexpr double kStageShare = 0.25;

struct Sample {
    float begin, end;  // in sheets of the first level from the eye's side: N front to back, else -N
    float rgb[3];
    float hides[3];
    std::uint32_t ray : 8;    // index within the tile
    std::uint32_t held : 24;  // see setHeld
};
static_assert(sizeof(Sample) == DeepRays::kSampleBytes);

using Channels = std::array<double, 3>;
using Firsts = std::array<std::uint32_t, kTileSize + 1>;  // of each ray's samples; and one more

constexpr double kHeldUnits = (1 << 24) - 1, kHeldByte = (1 << 8) - 1;

// Removes pieces that show nothing, because they are held out.
void dropUnseen(DeepCurve& curve) {
    std::array<float, 4> before{};
    std::erase_if(curve, [&](const DeepPiece& piece) {
        const bool same = piece.shown == before;
        before = piece.shown;
        return same;
    });
}

float unit(Real value) {
    return static_cast<float>(std::min(std::max(Real(0), value), Real(1)));  // NaN becomes 0
}

// Stores the fraction of what the sample hides that is held out and adds no alpha: one number of 24 bits for all
// colours, or, with coloured extinction, 8 bits for each, which is as precise as the half floats of a deep alpha.
void setHeld(bool coloured, const Channels& seen, const Channels& hidden, Sample& sample) {
    const auto part = [](double shows, double hides, double units) {
        const double held = hides > 0 ? 1 - shows / hides : 0;
        return static_cast<std::uint32_t>(std::lround(std::clamp(held, 0.0, 1.0) * units));
    };
    if (!coloured)
        sample.held = part(seen[0], hidden[0], kHeldUnits);
    else
        sample.held = part(seen[0], hidden[0], kHeldByte) | part(seen[1], hidden[1], kHeldByte) << 8 |
                      part(seen[2], hidden[2], kHeldByte) << 16;
}

double seenShare(bool coloured, const Sample& sample, std::size_t channel) {
    if (!coloured) return 1 - sample.held / kHeldUnits;
    return 1 - (sample.held >> (8 * channel) & 0xff) / kHeldByte;
}

DeepCurve curveOf(bool coloured, const Sample* first, const Sample* last) {
    DeepCurve curve;
    Channels shown{}, left{1, 1, 1}, hidden{};
    for (; first != last; ++first) {
        for (std::size_t c = 0; c < 3; ++c) {
            shown[c] += left[c] * first->rgb[c];
            // Sums opacity instead of transmittance, because 1 - T would lose it where a volume is thin.
            hidden[c] += left[c] * seenShare(coloured, *first, c) * first->hides[c];
            left[c] *= 1 - double(first->hides[c]);
        }
        curve.push_back({first->begin,
                         first->end,
                         {static_cast<float>(shown[0]), static_cast<float>(shown[1]), static_cast<float>(shown[2]),
                          static_cast<float>((hidden[0] + hidden[1] + hidden[2]) / 3)}});
    }
    return curve;
}

// Merges the samples that a merged piece replaces into one.
Sample compositeOf(bool coloured, const Sample*& sample, const DeepPiece& piece) {
    Sample sum{piece.begin, piece.end, {}, {}, sample->ray, 0};
    Channels shown{}, left{1, 1, 1}, hidden{}, seen{};
    for (bool more = true; more; ++sample) {
        for (std::size_t c = 0; c < 3; ++c) {
            shown[c] += left[c] * sample->rgb[c];
            hidden[c] += left[c] * sample->hides[c];
            seen[c] += left[c] * seenShare(coloured, *sample, c) * sample->hides[c];
            left[c] *= 1 - double(sample->hides[c]);
        }
        more = sample->end < piece.end;
    }
    for (std::size_t c = 0; c < 3; ++c) {
        sum.rgb[c] = static_cast<float>(shown[c]);
        sum.hides[c] = unit(static_cast<Real>(hidden[c]));
    }
    setHeld(coloured, seen, hidden, sum);
    return sum;
}

// Sorts samples from `from` on by ray, and those of a ray from front to back. They were added in
// the order of the sweep, or stage by stage in that order.
Firsts byRay(std::vector<Sample>& samples, std::size_t from, bool frontToBack) {
    Firsts firsts{};
    for (std::size_t i = from; i < samples.size(); ++i) ++firsts[samples[i].ray + 1];
    for (std::size_t k = 0; k < kTileSize; ++k) firsts[k + 1] += firsts[k];
    thread_local std::vector<Sample> sorted;
    sorted.resize(samples.size() - from);
    Firsts next = firsts;
    for (std::size_t i = from; i < samples.size(); ++i) sorted[next[samples[i].ray]++] = samples[i];
    const auto nearer = [](const Sample& a, const Sample& b) { return a.begin < b.begin; };
    for (std::size_t k = 0; k < kTileSize; ++k) {
        const auto first = sorted.begin() + firsts[k], last = sorted.begin() + firsts[k + 1];
        if (!frontToBack) std::reverse(first, last);
        if (!std::is_sorted(first, last, nearer)) std::sort(first, last, nearer);
    }
    std::copy(sorted.begin(), sorted.end(), samples.begin() + static_cast<std::ptrdiff_t>(from));
    return firsts;
}

}  // namespace

struct DeepRays::Tile {
    std::vector<Sample> samples;
    std::size_t done = 0;               // number of samples that are merged already
    std::pair<int, int> stage{-1, -1};  // the level, and the sheet in units of kStage
};

DeepRays::DeepRays(const PixelTiles& tiles, bool frontToBack, double tolerance, std::size_t mostBytes)
    : m_pixels(tiles),
      m_frontToBack(frontToBack),
      m_tolerance(kStageShare * tolerance),
      m_mostBytes(mostBytes),
      m_tiles(std::size_t(tiles.count())) {}

DeepRays::~DeepRays() = default;

void DeepRays::count(std::size_t before, std::size_t after) {
    const std::size_t bytes = m_bytes += (after - before) * sizeof(Sample);
    if (m_mostBytes > 0 && bytes > m_mostBytes)
        throw Error(ErrorKind::memory,
                    fmt::format("the deep picture's samples need more than the {} that the memory limit leaves; raise "
                                "deep_tolerance, or render a crop or a smaller picture",
                                bytesText(m_mostBytes)));
}

void DeepRays::add(int index, const Level& level, int number, const SheetSamples& from, Real step) {
    Tile& tile = m_tiles[std::size_t(index)];
    const std::size_t before = tile.samples.capacity();
    if (const std::pair stage(level.number, number / kStage); stage != tile.stage) {
        compact(tile);
        tile.stage = stage;
    }
    const OutputLayout& layout = m_pixels.layout();
    const int floats = layout.floats(), opacities = floats - 4;
    const int beauties = layout.beauty ? 1 : layout.quadOf(layout.beautyParts);
    const PixelWindow& region = m_pixels.region();
    const auto sheet = static_cast<float>(level.first + number * level.thickness);
    const auto thickness = static_cast<float>(level.thickness);
    const std::size_t samples = tile.samples.size();
    for (int k = 0; k < kTileSize; ++k) {
        if (!region.contains(m_pixels.cornerX(index) + k % kTileEdge, m_pixels.cornerY(index) + k / kTileEdge) ||
            (from.closed && from.closed[k]))
            continue;
        const Real* values = from.samples + floats * k;
        Sample sample{m_frontToBack ? sheet : -sheet - thickness,
                      m_frontToBack ? sheet + thickness : -sheet,
                      {},
                      {},
                      static_cast<std::uint32_t>(k),
                      0};
        std::array<Real, 4 * 256> seen;
        if (from.part && from.part[k] < 1) {
            keepSeenPart(layout, from.part[k], values, seen.data());
            values = seen.data();
            const auto middle = thickness * static_cast<float>(from.at[k] - step) + sheet + 0.5f * thickness;
            const auto half = 0.5f * thickness * static_cast<float>(from.part[k]);
            sample.begin = (m_frontToBack ? middle : -middle) - half;
            sample.end = sample.begin + 2 * half;
        }
        float most = 0;
        Channels shows{}, hides{};
        for (int c = 0; c < 3; ++c) {
            sample.hides[c] = unit(-values[opacities + (layout.coloured ? c : 3)]);
            for (int q = 0; q < beauties; ++q) sample.rgb[c] += static_cast<float>(values[4 * q + c]);
            sample.rgb[c] = std::max(0.0f, sample.rgb[c]);
            hides[c] = sample.hides[c];
            if (layout.seen) shows[c] = values[4 * layout.quadOf(*layout.seen) + c];
            most = std::max({most, sample.hides[c], sample.rgb[c]});
        }
        if (layout.seen) setHeld(layout.coloured, shows, hides, sample);
        if (most > 0 && sample.end > sample.begin) tile.samples.push_back(sample);
    }
    m_added += tile.samples.size() - samples;
    count(before, tile.samples.capacity());
}

void DeepRays::compact(Tile& tile) const {
    if (m_tolerance <= 0 || tile.done == tile.samples.size()) return;
    byRay(tile.samples, tile.done, m_frontToBack);
    const bool coloured = m_pixels.layout().coloured;
    const Sample* const end = tile.samples.data() + tile.samples.size();
    Sample* out = tile.samples.data() + tile.done;
    for (const Sample* first = out; first != end;) {
        const Sample* last = first;
        while (last != end && last->ray == first->ray) ++last;
        // Pieces are merged as if nothing lay in front of them, since whatever hides them hides their error, too.
        const DeepCurve pieces = merged(curveOf(coloured, first, last), m_tolerance);
        for (const DeepPiece& piece : pieces) *out++ = compositeOf(coloured, first, piece);
    }
    tile.samples.resize(static_cast<std::size_t>(out - tile.samples.data()));
    tile.done = tile.samples.size();
}

DeepImage DeepRays::resolve(const EyeView& eye, int n) {
    std::vector<Firsts> firsts(m_tiles.size());
    parallelFor(m_tiles.size(), [&](std::size_t i) {
        Tile& tile = m_tiles[i];
        compact(tile);
        firsts[i] = byRay(tile.samples, 0, m_frontToBack);
    });
    const PixelWindow& raster = m_pixels.region();
    const auto curveAt = [&](int x, int y) {
        const std::size_t tile = m_pixels.indexOf(x, y) / kTileSize, ray = m_pixels.indexOf(x, y) % kTileSize;
        const Sample* const samples = m_tiles[tile].samples.data();
        return curveOf(m_pixels.layout().coloured, samples + firsts[tile][ray], samples + firsts[tile][ray + 1]);
    };
    const PixelWindow window{raster.x0 / n, raster.y0 / n, raster.x1 / n, raster.y1 / n};
    DeepImage image = deepImage(window, [&](int x, int y) {
        std::vector<DeepCurve> curves(std::size_t(n) * std::size_t(n));
        std::vector<DeepTerm> terms(curves.size());
        for (std::size_t i = 0; i < curves.size(); ++i) {
            curves[i] = curveAt(x * n + static_cast<int>(i) % n, y * n + static_cast<int>(i) / n);
            terms[i] = {curves[i], 1.0 / (n * n), 1.0 / (n * n)};
        }
        DeepCurve mean = n == 1 ? std::move(curves.front()) : sumOf(terms);
        const EyeView::Ray ray = eye.ray((x + 0.5) * n, (y + 0.5) * n, 0);
        const auto depthOf = [&](float sheets) {
            const double sheet = m_frontToBack ? double(sheets) : -double(sheets);
            return static_cast<float>(std::max(eye.near(), ray.depth + sheet * ray.stepDepth));
        };
        for (DeepPiece& piece : mean) piece = {depthOf(piece.begin), depthOf(piece.end), piece.shown};
        return mean;
    });
    m_tiles.clear();
    return image;
}

DeepImage combined(const ViewScene& scene, const Plan& plan, const std::vector<DeepImage>& groups) {
    const bool holds = holdsOut(scene);
    const double tolerance = (1 - kStageShare) * (scene.deep ? scene.deep->tolerance : 0);
    return deepImage(scene.region, [&](int x, int y) {
        std::vector<DeepTerm> terms;
        for (std::size_t g = 0; g < groups.size(); ++g) {
            if (!groups[g].window.contains(x, y)) continue;
            const double weight = plan.eyeParts[plan.groups[g].eyePart].weight(x + 0.5, y + 0.5);
            terms.push_back({groups[g].curve(x, y), weight, weight * plan.groups[g].primary});
        }
        DeepCurve curve = tidied(merged(sumOf(terms), tolerance));
        if (holds) dropUnseen(curve);
        return curve;
    });
}

}  // namespace scrim
