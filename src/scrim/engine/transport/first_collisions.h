// SPDX-License-Identifier: Apache-2.0
// Light that reaches cells directly from lights and scatters there for the first time, which is the source of all
// further scattering. It has sharp shadows, so it is followed along its own rays and not along ordinates.
#pragma once

#include <scrim/engine/transport/cell_media.h>
#include <scrim/scene/light_at.h>
#include <scrim/scene/view_scene.h>

#include <cstddef>

namespace scrim {

/// The light of a light that arrives in a cell; light that scattered straight on is part of the irradiance.
struct ArrivingInCell : Arriving {
    Rgb straightDepth{0};  ///< optical depth of scattering straight on, up to this cell
};

/// Rays from cells to one light that is not extended, through extinction that is constant in each cell.
class FirstCollisions {
  public:
    /// `media`, `light` and the scene's solids must outlive this object. A light's slide must be loaded.
    FirstCollisions(const ViewScene& scene, const CellMedia& media, const Light& light);

    /// The light in cell `cell`: the mean along the ray through its centre.
    ArrivingInCell at(std::size_t cell) const;

  private:
    const ViewScene& m_scene;
    const CellMedia& m_media;
    const Light& m_light;
    LightAt m_unattenuated;
};

}  // namespace scrim
