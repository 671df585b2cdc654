// SPDX-License-Identifier: Apache-2.0
// Which tiles of the picture must walk finer sheets than those of a level: the ones that see
// volumes of finer levels in a sheet, or points that such volumes shadow there.
#pragma once

#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/model/plan.h>
#include <scrim/scene/view_scene.h>

#include <cstdint>
#include <vector>

namespace scrim {

class FinerTiles {
  public:
    /// `level`: the sheets, which `eye` looks at. `finer`: the volumes of all finer levels.
    FinerTiles(const ViewScene& scene, const GroupPlan& level, const std::vector<bool>& finer, const EyeView& eye,
               const PixelTiles& tiles);

    /// True if there is anything finer in a sheet.
    bool any(int sheet) const { return !m_sheets[std::size_t(sheet)].empty(); }
    /// For each tile whether it must walk finer sheets; only of sheets that have any.
    const std::vector<std::uint8_t>& at(int sheet) const { return m_sheets[std::size_t(sheet)]; }

  private:
    struct Slopes;
    void include(const Bounds& ts, const Slopes& slopes, const GroupPlan& level, const EyeView& eye,
                 const PixelTiles& tiles);

    std::vector<std::vector<std::uint8_t>> m_sheets;
};

}  // namespace scrim
