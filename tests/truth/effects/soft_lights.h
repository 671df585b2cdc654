// SPDX-License-Identifier: Apache-2.0
// Lights with an extent, for tests of light on cells.
#pragma once

#include <scrim/scene/light.h>

#include <glm/geometric.hpp>

namespace scrim::test {

inline Light domeLight(int samples) {
    Light light;
    light.name = "dome";
    light.kind = Light::Dome();
    light.intensity = Rgb(1);
    light.samples = samples;
    return light;
}

/// Shines from `from` to the origin; `size`: its radius, or half its width and height.
inline Light areaLight(AreaShape shape, const Vec3& from, double size, int samples, const Rgb& intensity) {
    Light light;
    light.name = "area";
    Light::Area area;
    area.shape = shape;
    area.width = area.height = 2 * size;
    area.radius = size;
    light.kind = area;
    light.wsPosition = from;
    light.wsDirection = glm::normalize(-from);
    light.intensity = intensity;
    light.samples = samples;
    return light;
}

}  // namespace scrim::test
