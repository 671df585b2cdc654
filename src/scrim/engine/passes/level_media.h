// SPDX-License-Identifier: Apache-2.0
// The media that hold back light on the cells of a level (cells/cell_levels.h).
#pragma once

#include <scrim/base/simd.h>
#include <scrim/engine/cells/cell_levels.h>
#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/cells/cell_walk.h>
#include <scrim/engine/passes/cell_slices.h>

#include <cstddef>
#include <vector>

namespace scrim {

/// Those of `volumes` that are no surfaces: for each volume of the scene.
std::vector<bool> mediaAmong(const ViewScene& scene, std::vector<bool> volumes);

/// What holds back the light of some lights: on the level's own cells, and on those of each coarser level.
struct Holding {
    std::vector<bool> casters;  ///< for each volume of the whole scene
    CellMedia own;
    std::vector<CellMedia> coarser;

    MediaTogether together() const;
    std::size_t bytes() const;
};

/// Makes the media of a level with cells of `edge`, which reach `margin` beyond the volumes, world units.
class LevelMedia {
  public:
    /// `level` must outlive this object.
    LevelMedia(const LevelScene& level, double edge, double margin, Simd simd);

    /// A corner of one of the level's own cells.
    const Vec3& corner() const { return m_corner; }
    /// The media of `casters`, volumes of the whole scene; the level's own cells are without its
    /// surfaces. `own`: the level's own grid if it is known, else null.
    Holding of(const std::vector<bool>& casters, const CellGrid* own) const;

  private:
    const LevelScene& m_level;
    double m_edge, m_margin;
    Vec3 m_corner;
    Simd m_simd;
};

/// The media of coarser levels as slices, with light wanted around all blocks of a level's own grid.
class CoarserSlices {
  public:
    /// `holding` has the grids of all that `along` will be asked for.
    explicit CoarserSlices(const Holding& holding);
    /// Along an axis of the world. `holding` must outlive them.
    std::vector<CellSlices> along(int axis, const Holding& holding, std::size_t colour) const;

  private:
    std::vector<CellGrid> m_shown;
};

}  // namespace scrim
