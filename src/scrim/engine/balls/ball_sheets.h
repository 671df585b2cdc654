// SPDX-License-Identifier: Apache-2.0
// Points that the eye sees as balls (ViewBalls), between the sheets of a sweep or of one level of it. Each ball is in
// the sheet that its centre is in, is lit there once, and is drawn on the picture's own raster: not on texels, which
// would have to be as fine as pixels, and would be shaded wherever there is one ball. So its place does not depend on
// the sheets, which are as thick as voxels need, and its time does not depend on how far balls are apart.
//
// A pixel sees a ball as a texel of one pixel is seen (bilinearly), in rings whose shares add up to the ball's
// (ball_profile.h). A ball smaller than a pixel is a share of its four nearest, whose mean place is its own.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/balls/ball_profile.h>
#include <scrim/engine/lamps/cell_light.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/shade/level_sheets.h>
#include <scrim/engine/shade/sheet_shader.h>
#include <scrim/scene/view_scene.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace scrim {

class BallSheets {
  public:
    /// All must outlive this object. `region`: the picture's pixels, whose tiles are numbered row
    /// by row (tilesAround). `others` are those of the level's shader.
    BallSheets(const ViewScene& scene, const Plan& plan, const LevelSheets& level, const EyeView& eye,
               const PixelWindow& region, const std::vector<CellLight>& cellLight, const OtherLevels& others = {});
    ~BallSheets();

    /// Lights the balls of sheets [firstSheet, firstSheet + count), the batch that the level's
    /// sheets and lights are in.
    ShadeWork enter(int firstSheet, int count);

    /// True if a ball of sheet `sheet` of the batch touches a tile of the picture; different threads may ask.
    bool touches(int sheet, int tile) const {
        return !m_touched.empty() &&
               m_touched[std::size_t(sheet - m_firstSheet) * tileCount() + std::size_t(tile)] != 0;
    }
    /// True if any of the sheets of the batch from `sheet` to before `end` has a ball in the picture.
    bool anyIn(int sheet, int end) const;

    /// The parts of a tile's rays that are seen, in sheets from the middle of sheet `block`, as RayTile has them.
    struct Limits {
        int block = 0;
        const Real* starts = nullptr;  ///< where each ray begins
        const Real* ends = nullptr;    ///< where each ends; null: nowhere
        /// The share of what lies at `n` on ray k that is seen past objects that hide in part; empty: all.
        std::function<Real(int k, Real n)> seen = {};
    };
    /// Adds the balls of a sheet to a tile's samples of what else is in it, as if that were mixed evenly: a ball is
    /// seen through the part of it that lies in front of the ball, and through the balls before it.
    void addTo(int sheet, int tile, const Limits& limits, Real* samples) const;

    std::uint64_t count() const;
    std::size_t bytes() const;
    /// Upper bound on the bytes, known beforehand.
    static std::size_t bytes(const ViewScene& scene, const Plan& plan, const OutputLayout& layout);

  private:
    struct Ball;
    struct Kind;
    struct Mixed;
    std::size_t tileCount() const { return std::size_t(m_tilesX) * std::size_t(m_tilesY); }
    Box2<int> tilesIn(const Box2<double>& positions) const;
    void place(const ViewScene& scene, const Sheets& sheets, int n, std::size_t kind, std::vector<Ball>& all) const;
    void sort(std::vector<Ball> all);
    ShadeWork shade(std::size_t first, std::size_t last, int plane);
    void listTiles(int count);
    template <class Add>
    void draw(const Ball& ball, int tile, const Add& add) const;
    void addBall(const Ball& ball, const Real* own, const Real* shares, const Real* rest, Mixed& mixed,
                 Real* sums) const;
    void mix(const Mixed& mixed, const Real* sums, Real* sample) const;

    const GroupPlan& m_group;
    const EyeView& m_eye;
    PixelWindow m_region, m_window;  // the picture's pixels, and those of its tiles
    int m_tilesX, m_tilesY;
    OutputLayout m_layout;
    bool m_frontToBack;
    double m_aspect = 1;                         // height of a ball on the raster over its width
    std::vector<std::unique_ptr<Kind>> m_kinds;  // one for each volume of balls
    std::vector<Ball> m_balls;                   // by sheet
    std::vector<std::size_t> m_firstOf;          // of each sheet, and of the end

    // The batch.
    int m_firstSheet = 0;
    std::size_t m_firstBall = 0;
    std::vector<Real> m_samples;          // of each ball: what it sends and hides where its profile is 1
    std::vector<std::uint8_t> m_touched;  // for each sheet and tile
    std::vector<std::pair<std::uint64_t, std::uint32_t>> m_entries;  // by sheet and tile: a ball of the batch
};

/// True if the eye sees balls.
bool seesBalls(const ViewScene& scene, const Plan& plan);

}  // namespace scrim
