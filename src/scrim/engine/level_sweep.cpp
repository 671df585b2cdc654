// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/level_sweep.h>

#include <scrim/engine/balls/ball_sheets.h>
#include <scrim/engine/composite/compositor.h>
#include <scrim/engine/composite/finer_tiles.h>
#include <scrim/engine/shade/level_sheets.h>
#include <scrim/engine/shade/sheet_shader.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>

namespace scrim {
namespace {

struct Level {
    Level(const ViewScene& scene, const Plan& plan, const GroupPlan& group)
        : sheets(scene, plan, group), eye(supersampled(scene.camera, scene.dials.antialias), group.sheets, plan.simd) {}

    LevelSheets sheets;
    EyeView eye;
    std::optional<FinerTiles> finer;  // none: this is the finest level
    std::optional<SheetShader> shader;
    std::optional<BallSheets> balls;
    std::optional<Compositor> compositor;
    std::vector<std::uint8_t> walking;  // the tiles that walk this level's sheets, or finer ones; empty: all
};

class LevelSweep {
  public:
    LevelSweep(const ViewScene& scene, const Plan& plan, const GroupPlan& group,
               const std::vector<CellLight>& cellLight, const SweptRays& rays,
               const std::function<void(double)>& progress)
        : m_group(group), m_tiles(rays.tiles), m_progress(progress) {
        group.forLevels([&](const GroupPlan& level) { m_levels.emplace_back(scene, plan, level); });
        const auto cutoff = static_cast<Real>(scene.dials.opacityCutoff);
        for (std::size_t i = 0; i < m_levels.size(); ++i) {
            Level& level = m_levels[i];
            OtherLevels others;
            std::vector<bool> finer(scene.volumes.size(), false);
            for (std::size_t o = 0; o < m_levels.size(); ++o) {
                if (o < i) others.coarser.push_back(&m_levels[o].sheets);
                if (o > i) others.finer.push_back(&m_levels[o].sheets);
                for (std::size_t v = 0; v < finer.size(); ++v)
                    finer[v] = finer[v] || (o > i && m_levels[o].sheets.group.volumes[v]);
            }
            if (i + 1 < m_levels.size()) level.finer.emplace(scene, level.sheets.group, finer, level.eye, m_tiles);
            if (seesBalls(scene, plan))
                level.balls.emplace(scene, plan, level.sheets, level.eye, m_tiles.region(), cellLight, others);
            level.shader.emplace(scene, plan, level.sheets, level.eye, cellLight, std::move(others));
            const LevelMap map(level.sheets.group.sheets, group.sheets);
            level.compositor.emplace(level.eye, m_tiles, group.sameSide, cutoff, rays.ends, rays.deep,
                                     DeepRays::Level{static_cast<int>(i), map.n(0), map.sheets},
                                     level.balls ? &*level.balls : nullptr);
            m_work.voxelsFed += level.sheets.extinction.voxels();
        }
    }

    RenderWork run() {
        const NeededTiles& needed = m_group.needed;
        sweep(0, needed.first, needed.last);
        m_work.bytes.picture = m_tiles.bytes();
        for (const Level& level : m_levels) {
            m_work.bytes.fields += level.sheets.extinction.bytes();
            m_work.bytes.shadows += level.sheets.lights.bytes();
            m_work.bytes.picture += level.balls ? level.balls->bytes() : 0;
        }
        return m_work;
    }

  private:
    // Sweeps the sheets [first, last) of a level.
    void sweep(std::size_t number, int first, int last) {
        Level& level = m_levels[number];
        const int batch = level.sheets.group.batchSheets;
        for (int sheet = first; sheet < last && !ended();) {
            int count = 0;
            while (count < batch && sheet + count < last && !(level.finer && level.finer->any(sheet + count))) ++count;
            if (count > 0) {
                count = enter(level, sheet, count);
                composite(level, sheet, count, nullptr);
            } else {
                divide(number, sheet);
            }
            sheet += std::max(count, 1);
            if (number == 0) m_progress(double(sheet - first) / (last - first));
        }
    }

    // Sweeps a sheet in which there is something finer.
    void divide(std::size_t number, int sheet) {
        Level &level = m_levels[number], &next = m_levels[number + 1];
        enter(level, sheet, 1);
        const std::vector<std::uint8_t>& finer = level.finer->at(sheet);
        next.walking = finer;
        for (std::size_t t = 0; t < level.walking.size(); ++t) next.walking[t] &= level.walking[t];
        const LevelMap map(level.sheets.group.sheets, next.sheets.group.sheets);
        const NeededTiles& needed = next.sheets.group.needed;
        const auto at = [&](int n) { return static_cast<int>(std::lround(map.n(n))); };
        sweep(number + 1, std::max(at(sheet), needed.first), std::min(at(sheet + 1), needed.last));
        composite(level, sheet, 1, finer.data());
    }

    // Splats the sheets, and carries the lights through them. Returns how many, at most `count`.
    int enter(Level& level, int sheet, int count) {
        const NeededTiles& needed = level.sheets.group.needed;
        level.sheets.sheet = sheet;
        count = level.sheets.extinction.take(sheet, count, needed.last, needed, m_work.footprints);
        m_work.sheets += static_cast<std::uint64_t>(count);
        m_work += level.sheets.lights.attenuate(sheet, count, level.sheets.extinction);
        if (level.balls) m_work.shade += level.balls->enter(sheet, count);
        return count;
    }

    void composite(Level& level, int sheet, int count, const std::uint8_t* finer) {
        const WalkingTiles walking{level.walking.empty() ? nullptr : level.walking.data(), finer};
        const auto seen =
            level.compositor->throughLevel(sheet, count, level.sheets.extinction.seen(0), *level.shader, walking);
        m_work += seen;
        m_work.layerSamples += seen.pixelSheets * static_cast<std::uint64_t>(m_group.outputs.layout.quads() - 1);
    }

    bool ended() const { return m_group.sameSide && m_levels.front().compositor->allOpaque(); }

    const GroupPlan& m_group;
    PixelTiles& m_tiles;
    const std::function<void(double)>& m_progress;
    std::deque<Level> m_levels;
    RenderWork m_work;
};

}  // namespace

RenderWork sweepLevels(const ViewScene& scene, const Plan& plan, const GroupPlan& group,
                       const std::vector<CellLight>& cellLight, const SweptRays& rays,
                       const std::function<void(double)>& progress) {
    return LevelSweep(scene, plan, group, cellLight, rays, progress).run();
}

}  // namespace scrim
