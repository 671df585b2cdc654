// SPDX-License-Identifier: Apache-2.0
// Extended lights on cells. What comes from many directions, or from a surface, varies slowly from place to place: each
// cell keeps how much of it arrives through the volumes and is scattered towards the eye, and shading looks that up.
// The same sum of sub-lights as by shadow buffers thus costs one pass over the cells for each sub-light, instead of a
// sweep of its own. Surfaces keep what they reflect of each sub-light, by how their cells face. Errors fall with the
// edge of the cells to the power of about 1.6, and have no noise.
#pragma once

#include <scrim/base/simd.h>
#include <scrim/engine/cells/cell_levels.h>
#include <scrim/engine/lamps/cell_light.h>
#include <scrim/scene/view_scene.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace scrim {

/// What it takes to keep light on cells.
struct CellLightWork {
    std::size_t bytes = 0;         ///< the peak of the memory, summed over levels
    std::uint64_t directions = 0;  ///< pairs of cells and points or directions that light passed from
};

/// The light of these lights of the scene on cells of `edge` world units, for the volumes of a level. Slides must be
/// loaded. Adds to `work`. `checkpoint` is called between passes; it throws to stop.
std::vector<CellLight> lightOnCells(const LevelScene& level, const std::vector<int>& lights, double edge, Simd simd,
                                    const std::function<void()>& checkpoint, CellLightWork& work);

}  // namespace scrim
