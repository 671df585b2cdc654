// SPDX-License-Identifier: Apache-2.0
// Smoke in which light scatters any number of times, lit by a sun from above, for tests of what promises and verifies
// it.
#pragma once

#include "support/fields.h"

#include <glm/geometric.hpp>

namespace scrim::test {

/// The field of smokeField(radius), of extinction `sigma` a unit, seen in a square picture of so many pixels and
/// `height` world units.
inline ViewScene fullSmoke(int radius, double height, int resolution, double sigma, double g) {
    Medium medium;
    medium.densityScale = sigma;
    medium.albedo = Rgb(0.99);
    medium.phase.g = g;
    medium.scattering = Scattering::full;
    ViewScene scene = orthographicScene(smokeField(radius), medium, height, resolution);
    scene.lights = {distantLight(glm::normalize(Vec3(1, -1, -0.2)))};
    return scene;
}

}  // namespace scrim::test
