// SPDX-License-Identifier: Apache-2.0
// The light that a light without extent sends to a place, before anything attenuates it: decay,
// cone, luminaire and slide. All code that follows single rays asks here; shading computes the same
// for all samples of a sheet at once (engine/light, engine/shade).
#pragma once

#include <scrim/scene/light.h>
#include <scrim/scene/slide_map.h>

#include <limits>
#include <optional>

namespace scrim {

/// Light that arrives at a place.
struct Arriving {
    Rgb irradiance{0};      ///< on a surface that faces the light
    Vec3 travel{0, 0, -1};  ///< direction of travel, unit
    /// To the light, world units; infinite for distant lights.
    double distance = std::numeric_limits<double>::infinity();
};

/// The cosines of two half angles of a spot's cone: `outer`, where it is dark, and `inner`, where it begins to fade. A
/// cone without a blend still fades over 0.006 degrees, because a step cannot be sampled.
struct SpotEdges {
    double outer, inner;
    explicit SpotEdges(const Light::Spot& spot);
    SpotEdges(double outerCosine, double innerCosine) : outer(outerCosine), inner(innerCosine) {}
    /// The fraction of the intensity, in [0, 1], in a direction whose cosine to the axis is `cosine`: a smoothstep.
    double part(double cosine) const;
};

class LightAt {
  public:
    /// `light` must outlive this object, must not be extended, and must have its slide and
    /// luminaire loaded. `leastRadius` is in world units: irradiance uses the larger of it and the
    /// light's own radius as its least distance.
    explicit LightAt(const Light& light, double leastRadius = 0);

    /// The irradiance is 0 at the exact place of a point light without a radius, where 1/r^2 has no value.
    Arriving at(const Vec3& ws) const;
    /// Null where the light has no slide.
    const SlideMap* slide() const { return m_slide ? &*m_slide : nullptr; }

  private:
    const Light& m_light;
    double m_radius2 = 0;
    std::optional<SpotEdges> m_edges;
    Spread m_spread{180};
    Mat3 m_frame{1.0};  // of a luminaire
    std::optional<SlideMap> m_slide;
};

}  // namespace scrim
