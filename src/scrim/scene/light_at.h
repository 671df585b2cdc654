// SPDX-License-Identifier: Apache-2.0
// What a light that is not extended sends to a place, before anything takes some of it: decay, cone, slide. All that
// follows single rays asks here; shading computes the same for the samples of a sheet at once (engine/light,
// engine/shade).
#pragma once

#include <scrim/scene/light.h>
#include <scrim/scene/slide_map.h>

#include <limits>
#include <optional>

namespace scrim {

/// Light at a place.
struct Arriving {
    Rgb irradiance{0};                                          ///< on a surface that faces it
    Vec3 travel{0, 0, -1};                                      ///< unit; the way it goes
    double distance = std::numeric_limits<double>::infinity();  ///< to the light, world units; infinite: distant light
};

/// Cosines of half the cone's angle, where a spot is dark, and of where it begins to fade. A cone without a blend has
/// an edge of 0.006 degrees.
struct SpotEdges {
    double outer, inner;
    explicit SpotEdges(const Light::Spot& spot);
    /// Part of the intensity in [0, 1] in a direction of this cosine to the axis: smoothstep.
    double part(double cosine) const;
};

class LightAt {
  public:
    /// `light` must outlive this; it is not extended, and its slide is loaded. `leastRadius`, world units: 1/r^2 is at
    /// most that of the larger of it and the light's own radius.
    explicit LightAt(const Light& light, double leastRadius = 0);

    /// No light at the very place where a point light stands, unless a radius says how much.
    Arriving at(const Vec3& ws) const;
    /// Null: it has none.
    const SlideMap* slide() const { return m_slide ? &*m_slide : nullptr; }

  private:
    const Light& m_light;
    double m_radius2 = 0;
    std::optional<SpotEdges> m_edges;
    std::optional<SlideMap> m_slide;
};

}  // namespace scrim
