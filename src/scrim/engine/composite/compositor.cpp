// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/composite/compositor.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace scrim {
namespace {

// Positions on rays are floats relative to a plane every kBlock sheets, and rays end at those
// planes, so that results do not depend on the number of sheets in a batch.
constexpr int kBlock = 8;

int blockBegin(int sheet) {
    return sheet / kBlock * kBlock;
}

// Memory for a tile's samples, one for each thread.
Real* sampleScratch(const OutputLayout& layout) {
    struct alignas(64) Line {
        Real values[16];
    };
    thread_local std::vector<Line> scratch;
    const auto lines = std::size_t(layout.floats() * kTileSize / 16);
    if (scratch.size() < lines) scratch.resize(lines);
    return scratch.front().values;
}

enum class Seen { all, part, none };

}  // namespace

// Planes of a batch within one block of sheets.
struct Compositor::Range {
    int sheet;                  // sheet of plane `firstPlane`
    int firstPlane, lastPlane;  // [firstPlane, lastPlane)
};

// What is seen of a sheet of the block: the fraction (null: all), and the middle of that.
struct Compositor::Cut {
    int step;
    const Real *part, *at;
};

// Tiles of the picture that may see something of a range.
struct Compositor::SeeingTiles {
    Box2<int> box;
    std::vector<std::uint8_t> marked{};  // for each tile of the box; empty: all of them may

    std::size_t indexOf(int tx, int ty) const { return std::size_t((ty - box.y0) * box.width() + tx - box.x0); }
    bool anyIn(int ty) const {
        if (box.empty() || ty < box.y0 || ty >= box.y1) return false;
        return marked.empty() ||
               std::memchr(marked.data() + indexOf(box.x0, ty), 1, std::size_t(box.width())) != nullptr;
    }
    bool contains(int tx, int ty) const {
        return box.contains(tx, ty) && (marked.empty() || marked[indexOf(tx, ty)] != 0);
    }
};

// A tile's rays, and the planes that they meet in a batch.
struct Compositor::TileWalk {
    RayTile rays;
    alignas(64) Real ends[kTileSize];  // N at which they end, relative as rays.startN; if `ended`
    bool ended = false;
    const double* thinFrom = nullptr;  // depths at which something begins that hides in part; null: none
    Real thinFirst = 0;                // N of the first of them in the eye's order
    Real startLeast, startMost;        // extremes of rays.startN
    Real endLeast, endMost;            // extremes of `ends`
    int block;                         // the block's first sheet
    int firstStep;                     // index of plane 0 among the block's sheets
    std::array<int, kBlock> planes;    // planes with active texels under the tile
    int planeCount = 0;

    // Whether the slab of the block's sheet `step`, [step - 1/2, step + 1/2], lies between the starts and ends of the
    // rays. A slab behind something that hides in part counts as partly visible.
    Seen seen(bool frontToBack, int step) const {
        const Real near = static_cast<Real>(step) - Real(0.5), far = near + 1;
        const Real lowerLeast = frontToBack ? startLeast : endLeast, lowerMost = frontToBack ? startMost : endMost;
        const Real upperLeast = frontToBack ? endLeast : startLeast, upperMost = frontToBack ? endMost : startMost;
        if (lowerLeast >= far || upperMost <= near) return Seen::none;
        const bool open = thinFrom == nullptr || (frontToBack ? thinFirst >= far : thinFirst <= near);
        return open && lowerMost <= near && upperLeast >= far ? Seen::all : Seen::part;
    }

    // The visible fraction of a slab in which rays begin or end, and the middle of that fraction.
    void cutSlab(bool frontToBack, int step, Real* part, Real* at) const {
        for (int k = 0; k < kTileSize; ++k) {
            Real near = static_cast<Real>(step) - Real(0.5), far = near + 1;
            const Real lower = frontToBack ? rays.startN[k] : ended ? ends[k] : near;
            const Real upper = !frontToBack ? rays.startN[k] : ended ? ends[k] : far;
            near = std::clamp(lower, near, far);
            far = std::clamp(upper, near, far);
            part[k] = far - near;
            at[k] = Real(0.5) * (near + far);
        }
    }
};

void Compositor::setRays(int tile, TileWalk& walk) const {
    const int x0 = m_tiles.cornerX(tile), y0 = m_tiles.cornerY(tile);
    const double reference = walk.block + 0.5;
    walk.rays = m_eye.rays(x0, y0, reference);
    walk.startLeast = *std::min_element(walk.rays.startN, walk.rays.startN + kTileSize);
    walk.startMost = *std::max_element(walk.rays.startN, walk.rays.startN + kTileSize);
    walk.endLeast = walk.endMost = (m_frontToBack ? 1 : -1) * std::numeric_limits<Real>::infinity();
    if (m_ends == nullptr) return;
    walk.thinFrom = m_ends->thinFrom(tile);
    if (walk.thinFrom != nullptr) {
        m_eye.planesAt(x0, y0, walk.thinFrom, reference, walk.ends);
        const auto [least, most] = std::minmax_element(walk.ends, walk.ends + kTileSize);
        walk.thinFirst = m_frontToBack ? *least : *most;
    }
    const double* depths = m_ends->depths(tile);
    if (depths == nullptr) return;
    walk.ended = true;
    m_eye.planesAt(x0, y0, depths, reference, walk.ends);
    walk.endLeast = *std::min_element(walk.ends, walk.ends + kTileSize);
    walk.endMost = *std::max_element(walk.ends, walk.ends + kTileSize);
}

// Sets up the rays of a tile, and finds the planes whose active texels they may meet, or, on a
// shader's levels, those of coarser ones.
Compositor::TileWalk Compositor::enter(int tile, const Range& range, const PlaneStack& planes,
                                       const SheetShader* shader) const {
    TileWalk walk;
    walk.block = blockBegin(range.sheet);
    walk.firstStep = range.sheet - walk.block - range.firstPlane;
    const double reference = blockBegin(range.sheet) + 0.5;
    const int x0 = m_tiles.cornerX(tile), y0 = m_tiles.cornerY(tile);

    // The four corners are tested first, since a batch that misses the tile must cost next to nothing. They stay within
    // the picture, outside of which rays of a wide eye may diverge from the planes.
    const PixelWindow seen = intersection({x0, y0, x0 + kTileEdge, y0 + kTileEdge}, m_tiles.region());
    EyeView::Ray corners[4];
    for (int i = 0; i < 4; ++i) corners[i] = m_eye.ray(i & 1 ? seen.x1 : seen.x0, i & 2 ? seen.y1 : seen.y0, reference);
    for (int p = range.firstPlane; p < range.lastPlane; ++p) {
        const int step = p + walk.firstStep;
        auto texels = Box2<double>::nothing();
        for (const EyeView::Ray& ray : corners) texels.include(ray.u + step * ray.slopeU, ray.v + step * ray.slopeV);
        if (anyActiveNear(planes, p, texels) || (shader != nullptr && shader->anyCoarser(texels)) ||
            hasBalls(tile, walk.block + step))
            walk.planes[walk.planeCount++] = p;
    }
    if (walk.planeCount > 0) setRays(tile, walk);
    return walk;
}

// The same on the eye's own lattice, where a tile meets the same tile, `cells`, on every plane.
Compositor::TileWalk Compositor::enterCells(int tile, const Range& range, const PlaneStack& planes,
                                            const Int2& cells) const {
    TileWalk walk;
    walk.block = blockBegin(range.sheet);
    walk.firstStep = range.sheet - walk.block - range.firstPlane;
    for (int p = range.firstPlane; p < range.lastPlane; ++p)
        if (planes.active(p, cells.x, cells.y)) walk.planes[walk.planeCount++] = p;
    if (walk.planeCount > 0) setRays(tile, walk);
    return walk;
}

// Reduces a sheet's samples to what is visible past objects that hide in part. Only the radiance is
// reduced, not the opacity that hides. `part` and `at` are as in cutSlab.
void Compositor::holdOut(int tile, const TileWalk& walk, const Real* part, const Real* at, Real* samples) const {
    if (walk.thinFrom == nullptr) return;
    const OutputLayout& layout = m_tiles.layout();
    const int floats = layout.floats(), opacities = floats - 4;
    const int shown = layout.coloured ? opacities : floats;  // quads that hold only opacities stay unchanged
    for (int k = 0; k < kTileSize; ++k) {
        const double x = m_tiles.cornerX(tile) + k % kTileEdge + 0.5, y = m_tiles.cornerY(tile) + k / kTileEdge + 0.5;
        const EyeView::Ray ray = m_eye.ray(x, y, 0);
        const double middle = ray.depth + (walk.block + 0.5 + double(at[k])) * ray.stepDepth;
        const double half = 0.5 * double(part[k]) * std::abs(ray.stepDepth);
        if (middle + half <= walk.thinFrom[k]) continue;
        Real* const sample = samples + floats * k;
        if (std::all_of(sample, sample + floats, [](Real v) { return v == 0; })) continue;
        Real share = 1;
        for (int c = 0; c < 3; ++c) {
            if (c == 0 || layout.coloured) {
                constexpr double kOpaque = 1 - 1e-12;
                const double alpha = -double(sample[opacities + (layout.coloured ? c : 3)]);
                const double tau = -std::log1p(-std::clamp(alpha, 0.0, kOpaque)) * double(part[k]);
                share = static_cast<Real>(m_ends->seenShare(x, y, middle - half, middle + half, tau));
            }
            for (int q = 0; q < shown; q += 4) sample[q + c] *= share;
        }
    }
}

// The pixels of a tile that receive nothing of the walk's block; null: back to front, all do.
const std::uint8_t* Compositor::closedIn(int tile, const TileWalk& walk) {
    const int block = walk.block / kBlock * kMostLevels + m_level.number;
    return m_frontToBack ? m_tiles.closed(tile, block, m_cutoff) : nullptr;
}

RenderWork Compositor::compositeTexels(int tile, const Range& range, const PlaneStack& shaded) {
    const TileWalk walk = enter(tile, range, shaded);
    Real* states = m_tiles.states(tile);
    const OutputLayout& layout = m_tiles.layout();
    PixelTiles::FirstDepth* const first = firstDepth(tile);
    std::array<const Real*, kBlock> planes;
    std::array<Real, kBlock> steps{};
    int listed = 0;
    std::uint64_t walked = 0;
    const std::uint8_t* const closed = closedIn(tile, walk);
    const auto flush = [&] {
        if (listed == 0) return;
        const SheetList sheets{planes.data(),   steps.data(), listed,       shaded.width(),
                               shaded.height(), layout,       m_eye.simd(), closed};
        if (m_deep) keepDeep(tile, walk, sheets);
        compositeTile(walk.rays, sheets, m_frontToBack, states, first);
        walked += static_cast<std::uint64_t>(listed) * kTileSize;
        listed = 0;
    };
    for (int i = 0; i < walk.planeCount; ++i) {
        const int p = walk.planes[i];
        const int step = p + walk.firstStep;
        switch (walk.seen(m_frontToBack, step)) {
            case Seen::none:
                break;
            case Seen::all:
                if (!hasBalls(tile, walk.block + step)) {
                    planes[listed] = shaded.plane(p);
                    steps[listed++] = static_cast<Real>(step);
                    break;
                }
                [[fallthrough]];
            case Seen::part: {
                flush();
                alignas(64) Real part[kTileSize], at[kTileSize];
                Real* samples = sampleScratch(layout);
                walk.cutSlab(m_frontToBack, step, part, at);
                samplePlane(walk.rays, at, {shaded.plane(p), shaded.width(), shaded.height(), layout}, samples,
                            m_eye.simd());
                addCut(tile, walk, {step, part, at}, samples);
                walked += kTileSize;
            }
        }
    }
    flush();
    RenderWork work;
    work.pixelSheets = walked;
    return work;
}

// Records the samples that compositeTile is about to add for the same rays. They are sampled once
// more, so that the flat picture's own loop is not affected.
void Compositor::keepDeep(int tile, const TileWalk& walk, const SheetList& sheets) {
    Real* samples = sampleScratch(sheets.layout);
    alignas(64) Real at[kTileSize];
    for (int s = 0; s < sheets.count; ++s) {
        std::fill(at, at + kTileSize, sheets.steps[s]);
        samplePlane(walk.rays, at, {sheets.planes[s], sheets.width, sheets.height, sheets.layout}, samples,
                    sheets.simd);
        const SheetSamples whole{samples, nullptr, nullptr, sheets.layout, sheets.simd, sheets.closed};
        m_deep->add(tile, m_level, walk.block + static_cast<int>(sheets.steps[s]), whole, 0);
    }
}

// Shades where the tile's rays meet each plane, by SheetShader::shadePoints or shadeCells: shade(p,
// points, open, onward, samples, work).
template <class Shade>
RenderWork Compositor::shadeAlong(const TileWalk& walk, int tile, const SheetShader& shader, const Shade& shade) {
    Real* states = m_tiles.states(tile);
    const OutputLayout& layout = m_tiles.layout();
    RenderWork work;
    SampleTile points;
    alignas(64) Real part[kTileSize], at[kTileSize];
    Real* samples = sampleScratch(layout);
    bool onward = false;  // the sheet before was crossed in its middle plane, too
    for (int i = 0; i < walk.planeCount; ++i) {
        const int p = walk.planes[i];
        const int step = p + walk.firstStep;
        const Seen seen = walk.seen(m_frontToBack, step);
        if (seen == Seen::none) continue;
        if (seen == Seen::part)
            walk.cutSlab(m_frontToBack, step, part, at);
        else
            std::fill(at, at + kTileSize, static_cast<Real>(step));
        points.rays = seen == Seen::all ? &walk.rays : nullptr;
        points.step = static_cast<Real>(step);
        points.part = seen == Seen::all ? nullptr : part;
        points.at = seen == Seen::all ? nullptr : at;
        points.spacing = m_eye.pixelSpacing(walk.block + step + 0.5);
        const auto toSlope = static_cast<Real>(shader.slopeScale());
        for (int k = 0; k < kTileSize; ++k) {
            points.u[k] = walk.rays.u[k] + at[k] * walk.rays.stepU[k];
            points.v[k] = walk.rays.v[k] + at[k] * walk.rays.stepV[k];
            points.eyeA[k] = walk.rays.stepU[k] * toSlope;
            points.eyeB[k] = walk.rays.stepV[k] * toSlope;
        }
        m_eye.setDepth(walk.block + step + 0.5, points);
        work.pixelSheets += kTileSize;
        // Surfaces behind opaque pixels are not shaded.
        std::uint8_t open[kTileSize];
        for (int k = 0; m_frontToBack && k < kTileSize; ++k)
            open[k] = 1 + states[layout.floats() * (k + 1) - 1] >= m_cutoff ? 1 : 0;
        const bool shows =
            shade(p, points, m_frontToBack ? open : nullptr, onward && seen == Seen::all, samples, work.shade);
        onward = seen == Seen::all;
        if (!shows) {
            if (!hasBalls(tile, walk.block + step)) continue;
            std::fill_n(samples, layout.floats() * kTileSize, Real(0));
        }
        addCut(tile, walk, {step, seen == Seen::part ? part : nullptr, at}, samples);
    }
    return work;
}

// Composites the samples of a sheet, with its balls.
void Compositor::addCut(int tile, const TileWalk& walk, const Cut& cut, Real* samples) {
    const OutputLayout& layout = m_tiles.layout();
    const Real* part = cut.part;
    if (part) holdOut(tile, walk, part, cut.at, samples);
    if (hasBalls(tile, walk.block + cut.step)) {
        const int floats = layout.floats();
        std::array<Real, 4 * 256> kept;
        for (int k = 0; part && k < kTileSize; ++k) {
            if (part[k] >= 1) continue;
            keepSeenPart(layout, part[k], samples + floats * k, kept.data());
            std::copy_n(kept.data(), floats, samples + floats * k);
        }
        part = nullptr;
        addBalls(tile, walk, cut.step, samples);
    }
    const SheetSamples shaded{samples, part, cut.at, layout, m_eye.simd(), closedIn(tile, walk)};
    if (m_deep) m_deep->add(tile, m_level, walk.block + cut.step, shaded, static_cast<Real>(cut.step));
    compositeSamples(walk.rays, shaded, m_frontToBack, m_tiles.states(tile), firstDepth(tile));
}

// A ball is seen as far as its centre is.
void Compositor::addBalls(int tile, const TileWalk& walk, int step, Real* samples) const {
    BallSheets::Limits limits{walk.block, walk.rays.startN, walk.ended ? walk.ends : nullptr, {}};
    if (walk.thinFrom != nullptr)
        limits.seen = [&](int k, Real n) {
            const double x = m_tiles.cornerX(tile) + k % kTileEdge + 0.5,
                         y = m_tiles.cornerY(tile) + k / kTileEdge + 0.5;
            const EyeView::Ray ray = m_eye.ray(x, y, 0);
            const double depth = ray.depth + (walk.block + 0.5 + double(n)) * ray.stepDepth;
            return depth <= walk.thinFrom[k] ? Real(1) : static_cast<Real>(m_ends->seenShare(x, y, depth, depth, 0));
        };
    m_balls->addTo(walk.block + step, tile, limits, samples);
}

RenderWork Compositor::shadePoints(const TileWalk& walk, int tile, const SheetShader& shader) {
    return shadeAlong(walk, tile, shader, [&](int p, const SampleTile& points, auto&&... rest) {
        return shader.shadePoints(p, points, rest...);
    });
}

PixelTiles::FirstDepth* Compositor::firstDepth(int tile) {
    return m_tiles.keepsDepth() ? m_tiles.depths(tile) : nullptr;
}

// Marks a tile whose pixels show nothing from N = `blockEnd` on, since they are opaque or their rays have ended.
void Compositor::markIfOpaque(int tile, int blockEnd) {
    if (!m_frontToBack) return;
    const Real* states = m_tiles.states(tile);
    const int floats = m_tiles.layout().floats();  // the last float is the smallest opacity
    const double* depths = m_ends == nullptr ? nullptr : m_ends->depths(tile);
    alignas(64) Real ends[kTileSize];
    if (depths != nullptr) m_eye.planesAt(m_tiles.cornerX(tile), m_tiles.cornerY(tile), depths, blockEnd, ends);
    for (int k = 0; k < kTileSize; ++k)
        if (1 + states[floats * k + floats - 1] >= m_cutoff && (depths == nullptr || ends[k] > 0)) return;
    m_tiles.setOpaque(tile);
}

Compositor::SeeingTiles Compositor::all() const {
    return {m_tiles.all()};
}

// The tiles of the picture that may see an active texel of the range. Most tiles see none, and should cost nothing.
Compositor::SeeingTiles Compositor::tilesThatSee(const Range& range, const PlaneStack& planes) const {
    Box2<double> seen = Box2<double>::nothing();
    int active = 0;
    for (int p = range.firstPlane; p < range.lastPlane; ++p) {
        const Box2<int> bounds = planes.activeBounds(p);
        if (bounds.empty()) continue;
        const auto box = m_eye.seenBy(texelsAround(bounds), range.sheet + p - range.firstPlane + 0.5);
        if (!box) return all();
        seen.include(*box);
        active += planes.activeCount(p);
    }
    SeeingTiles seeing{seen.empty() ? Box2<int>{} : m_tiles.tilesIn(seen)};
    constexpr int kFewer = 8;  // finding who sees an active tile takes as long as entering a few that see none
    if (std::int64_t(active) * kFewer < std::int64_t(seeing.box.pixelCount())) markSeeing(range, planes, seeing);
    const bool balls =
        m_balls != nullptr && m_balls->anyIn(range.sheet, range.sheet + range.lastPlane - range.firstPlane);
    return balls ? withBalls(range, seeing) : seeing;
}

// These tiles, and those that see balls.
Compositor::SeeingTiles Compositor::withBalls(const Range& range, const SeeingTiles& seeing) const {
    SeeingTiles out{m_tiles.all()};
    out.marked.assign(std::size_t(m_tiles.count()), 0);
    for (int tile = 0; tile < m_tiles.count(); ++tile) {
        bool sees = seeing.contains(tile % m_tiles.tilesX(), tile / m_tiles.tilesX());
        for (int p = range.firstPlane; !sees && p < range.lastPlane; ++p)
            sees = m_balls->touches(range.sheet + p - range.firstPlane, tile);
        out.marked[std::size_t(tile)] = sees ? 1 : 0;
    }
    return out;
}

// Looks from each active tile.
void Compositor::markSeeing(const Range& range, const PlaneStack& planes, SeeingTiles& seeing) const {
    const Box2<int>& all = seeing.box;
    seeing.marked.assign(all.pixelCount(), 0);
    for (int p = range.firstPlane; p < range.lastPlane; ++p) {
        const double middle = range.sheet + p - range.firstPlane + 0.5;
        for (int ty = 0; ty < planes.tilesY(); ++ty)
            planes.forActive(p, ty, [&](int tx) {
                const auto seen = m_eye.seenBy(texelsAround({tx, ty, tx + 1, ty + 1}), middle);
                const Box2<int> by = seen ? intersection(m_tiles.tilesIn(*seen), all) : all;
                for (int y = by.y0; y < by.y1; ++y)
                    for (int x = by.x0; x < by.x1; ++x) seeing.marked[seeing.indexOf(x, y)] = 1;
            });
    }
}

template <class TilesOf, class Walk>
RenderWork Compositor::forOpenTiles(int firstSheet, int count, const TilesOf& tilesOf, const Walk& walk) {
    struct Part {
        Range range;
        SeeingTiles tiles;
        bool endsBlock;
    };
    std::vector<Part> parts;
    for (int p = 0; p < count;) {
        const int sheet = firstSheet + p, blockEnd = blockBegin(sheet) + kBlock;
        const int last = std::min(count, p + blockEnd - sheet);
        const Range range{sheet, p, last};
        parts.push_back({range, tilesOf(range), firstSheet + last == blockEnd});
        p = last;
    }
    // Tiles of one row that a task walks: few, since some see much and most see nothing.
    constexpr int kTilesPerTask = 4;
    struct Task {
        int tx, ty;
    };
    std::vector<Task> tasks;
    for (int ty = 0; ty < m_tiles.tilesY(); ++ty)
        if (std::ranges::any_of(parts, [&](const Part& part) { return part.endsBlock || part.tiles.anyIn(ty); }))
            for (int tx = 0; tx < m_tiles.tilesX(); tx += kTilesPerTask) tasks.push_back({tx, ty});
    std::vector<RenderWork> walked(tasks.size());
    parallelFor(tasks.size(), [&](std::size_t i) {
        const auto [first, ty] = tasks[i];
        for (int tx = first; tx < std::min(first + kTilesPerTask, m_tiles.tilesX()); ++tx) {
            const int tile = ty * m_tiles.tilesX() + tx;
            for (const Part& part : parts) {
                if (m_tiles.opaque(tile)) break;
                if (part.tiles.contains(tx, ty)) walked[i] += walk(tile, part.range);
                if (part.endsBlock) markIfOpaque(tile, blockBegin(part.range.sheet) + kBlock);
            }
        }
    });
    RenderWork sum;
    for (const RenderWork& w : walked) sum += w;
    return sum;
}

RenderWork Compositor::throughTexels(int firstSheet, int count, const PlaneStack& shaded) {
    return forOpenTiles(
        firstSheet, count, [&](const Range& range) { return tilesThatSee(range, shaded); },
        [&](int tile, const Range& range) { return compositeTexels(tile, range, shaded); });
}

RenderWork Compositor::throughPixels(int firstSheet, int count, const PlaneStack& covered, const SheetShader& shader) {
    return forOpenTiles(
        firstSheet, count, [&](const Range& range) { return tilesThatSee(range, covered); },
        [&](int tile, const Range& range) { return shadePoints(enter(tile, range, covered), tile, shader); });
}

RenderWork Compositor::throughCells(int firstSheet, int count, const PlaneStack& covered, int guardTiles,
                                    const SheetShader& shader) {
    return forOpenTiles(
        firstSheet, count, [&](const Range&) { return all(); },
        [&](int tile, const Range& range) {
            const Int2 cells(tile % m_tiles.tilesX() + guardTiles, tile / m_tiles.tilesX() + guardTiles);
            return shadeAlong(enterCells(tile, range, covered, cells), tile, shader,
                              [&](int p, const SampleTile& points, auto&&... rest) {
                                  return shader.shadeCells(p, points, cells, rest...);
                              });
        });
}

RenderWork Compositor::throughLevel(int firstSheet, int count, const PlaneStack& covered, const SheetShader& shader,
                                    const WalkingTiles& walking) {
    return forOpenTiles(
        firstSheet, count,
        [&](const Range& range) { return walking.own == nullptr ? tilesThatSee(range, covered) : all(); },
        [&](int tile, const Range& range) {
            if (!walking.walks(tile)) return RenderWork{};
            return shadePoints(enter(tile, range, covered, &shader), tile, shader);
        });
}

bool Compositor::allOpaque() const {
    for (int tile = 0; tile < m_tiles.count(); ++tile)
        if (!m_tiles.opaque(tile)) return false;
    return true;
}

}  // namespace scrim
