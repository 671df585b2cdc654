// SPDX-License-Identifier: Apache-2.0
// Stage 5 of a batch: follows every pixel's ray through the batch's sheets, front to back or back to front.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/balls/ball_sheets.h>
#include <scrim/engine/composite/composite_tile.h>
#include <scrim/engine/composite/deep_rays.h>
#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/shade/sheet_shader.h>
#include <scrim/engine/splat/plane_stack.h>

#include <cstdint>
#include <optional>

namespace scrim {

/// The tiles of the picture that walk the sheets of a level: those in `own` but not in `finer`,
/// which walk finer ones. Null: all are in `own`, or none in `finer`.
struct WalkingTiles {
    const std::uint8_t* own = nullptr;
    const std::uint8_t* finer = nullptr;

    bool walks(int tile) const { return (own == nullptr || own[tile] != 0) && (finer == nullptr || finer[tile] == 0); }
};

class Compositor {
  public:
    /// `ends`: objects that hide parts of rays; null: none. `deep`: also records the samples of every ray; may be null.
    /// `level`: that of the sheets; its number is below kMostLevels. `balls`: those of the batch; null: there are none.
    static constexpr int kMostLevels = 32;
    Compositor(const EyeView& eye, PixelTiles& tiles, bool frontToBack, Real cutoff, const EyeEnds* ends = nullptr,
               DeepRays* deep = nullptr, const DeepRays::Level& level = {}, const BallSheets* balls = nullptr)
        : m_eye(eye),
          m_tiles(tiles),
          m_frontToBack(frontToBack),
          m_cutoff(cutoff),
          m_ends(ends),
          m_deep(deep),
          m_level(level),
          m_balls(balls) {}

    /// Composites planes [0, count) of shaded texels, which are sheets firstSheet + p. This and the
    /// next function return the pixel and sheet pairs, and the work of shading on the way.
    RenderWork throughTexels(int firstSheet, int count, const PlaneStack& shaded);

    /// Shades where the pixels' rays meet the sheets, and composites that. `covered`: the active tiles of the sheets.
    RenderWork throughPixels(int firstSheet, int count, const PlaneStack& covered, const SheetShader& shader);

    /// The same with per-view splatting. `covered`: the active tiles of the eye's own lattice,
    /// which has `guardTiles` tiles around the picture's.
    RenderWork throughCells(int firstSheet, int count, const PlaneStack& covered, int guardTiles,
                            const SheetShader& shader);

    /// The same for the sheets of a level, which the tiles `walking` walk.
    RenderWork throughLevel(int firstSheet, int count, const PlaneStack& covered, const SheetShader& shader,
                            const WalkingTiles& walking);

    /// True if all pixels are opaque; only possible front to back.
    bool allOpaque() const;

  private:
    struct TileWalk;
    struct Range;
    struct SeeingTiles;
    struct Cut;
    void addCut(int tile, const TileWalk& walk, const Cut& cut, Real* samples);
    void holdOut(int tile, const TileWalk& walk, const Real* part, const Real* at, Real* samples) const;
    TileWalk enter(int tile, const Range& range, const PlaneStack& planes, const SheetShader* shader = nullptr) const;
    RenderWork compositeTexels(int tile, const Range& range, const PlaneStack& shaded);
    bool hasBalls(int tile, int sheet) const { return m_balls != nullptr && m_balls->touches(sheet, tile); }
    void addBalls(int tile, const TileWalk& walk, int step, Real* samples) const;
    void keepDeep(int tile, const TileWalk& walk, const SheetList& sheets);
    const std::uint8_t* closedIn(int tile, const TileWalk& walk);
    template <class Shade>
    RenderWork shadeAlong(const TileWalk& walk, int tile, const SheetShader& shader, const Shade& shade);
    RenderWork shadePoints(const TileWalk& walk, int tile, const SheetShader& shader);
    TileWalk enterCells(int tile, const Range& range, const PlaneStack& planes, const Int2& cells) const;
    template <class TilesOf, class Walk>
    RenderWork forOpenTiles(int firstSheet, int count, const TilesOf& tilesOf, const Walk& walk);
    SeeingTiles all() const;
    SeeingTiles tilesThatSee(const Range& range, const PlaneStack& planes) const;
    SeeingTiles withBalls(const Range& range, const SeeingTiles& seeing) const;
    void markSeeing(const Range& range, const PlaneStack& planes, SeeingTiles& seeing) const;
    void setRays(int tile, TileWalk& walk) const;
    void markIfOpaque(int tile, int blockEnd);
    PixelTiles::FirstDepth* firstDepth(int tile);

    const EyeView& m_eye;
    PixelTiles& m_tiles;
    bool m_frontToBack;
    Real m_cutoff;
    const EyeEnds* m_ends;
    DeepRays* m_deep;
    DeepRays::Level m_level;
    const BallSheets* m_balls;
};

}  // namespace scrim
