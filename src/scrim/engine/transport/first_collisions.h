// SPDX-License-Identifier: Apache-2.0
// Light that reaches cells from lights straight, where it scatters for the first time: the source of all light that
// scatters again. It has sharp shadows, so it is followed along its own rays and not along ordinates.
#pragma once

#include <scrim/engine/transport/cell_media.h>
#include <scrim/scene/light_at.h>
#include <scrim/scene/view_scene.h>

#include <cstddef>

namespace scrim {

/// What is left of a light's light in a cell; what scattered straight on is part of the irradiance.
struct ArrivingInCell : Arriving {
    Rgb straightDepth{0};  ///< optical depth of the scattering straight on, up to here
};

/// Rays from cells to one light that is not extended, through extinction that is constant in each cell.
class FirstCollisions {
  public:
    /// `media`, `light` and the scene's solids must outlive this. A light's slide must be loaded.
    FirstCollisions(const ViewScene& scene, const CellMedia& media, const Light& light);

    /// What reaches cell `cell`: the mean over its depth along the ray through its middle.
    ArrivingInCell at(std::size_t cell) const;

  private:
    const ViewScene& m_scene;
    const CellMedia& m_media;
    const Light& m_light;
    LightAt m_unattenuated;
};

}  // namespace scrim
