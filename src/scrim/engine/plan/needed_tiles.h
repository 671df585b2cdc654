// SPDX-License-Identifier: Apache-2.0
// The part of a sweep's sheets that the picture needs: what its pixels see, and what light passes on its way there.
// Sheets and tiles keep their places; what is not needed is left out of the splat, so that a crop's pixels come out as
// in the whole picture.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/geometry/sheets.h>
#include <scrim/scene/view_scene.h>
#include <scrim/engine/splat/plane_stack.h>

#include <vector>

namespace scrim {

struct NeededTiles {
    /// For each sheet the closed box of needed tiles; x1 < x0 where there are none.
    std::vector<PlaneStack::TileBounds> sheets;
    int first = 0, last = 0;  ///< sheets [first, last) hold all that is needed

    /// The box around those of sheets [from, to), which may reach beyond the stack.
    PlaneStack::TileBounds over(int from, int to) const;
    /// Part of all tiles that are needed, in [0, 1].
    double share(const Sheets& s) const;
};

/// `window`: the pixels of the sweep. `lights`: of the sweep, those that throw shadows.
NeededTiles neededTiles(
    const ViewScene& scene, const PixelWindow& window, const Sheets& sheets, const std::vector<const Light*>& shadowed,
    const Checkpoint& checkpoint = [] {});

}  // namespace scrim
