// SPDX-License-Identifier: Apache-2.0
// Light that reaches cells from lights straight, where it scatters for the first time: the source of all light that
// scatters again. It has sharp shadows, so it is followed along its own rays and not along ordinates.
#pragma once

#include <scrim/engine/light/slide_map.h>
#include <scrim/engine/transport/cell_media.h>
#include <scrim/scene/view_scene.h>

#include <cstddef>
#include <optional>
#include <vector>

namespace scrim {

/// Light at a point: irradiance on a surface that faces it, and the way it travels.
struct Arriving {
    Rgb irradiance{0};      ///< light that scattered straight on is part of it
    Rgb straightDepth{0};   ///< optical depth of that scattering, up to here
    Vec3 travel{0, 0, -1};  ///< unit
    double distance = 0;    ///< to the light; infinity where it is distant
};

/// Rays from cells to one light that is not extended, through extinction that is constant in each cell.
class FirstCollisions {
  public:
    /// `media`, `light` and the scene's solids must outlive this. A light's slide must be loaded.
    FirstCollisions(const ViewScene& scene, const CellMedia& media, const Light& light);

    /// What reaches cell `cell`: the mean over its depth along the ray through its middle.
    Arriving at(std::size_t cell) const;

  private:
    Arriving unattenuated(const Vec3& ws) const;
    struct Depths {
        Rgb tau{0}, straight{0};  // without what scatters straight on, and of that
    };
    Depths opticalDepths(const Vec3& ws, const Vec3& direction, double distance) const;

    const ViewScene& m_scene;
    const CellMedia& m_media;
    const Light& m_light;
    std::optional<SlideMap> m_slide;
};

}  // namespace scrim
