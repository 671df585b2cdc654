// SPDX-License-Identifier: Apache-2.0
// The scenes of the effects' tests: a plain one, and every effect put into it.
#pragma once

#include "support/fields.h"

#include <array>
#include <functional>
#include <string>
#include <vector>

namespace scrim::test {

/// Smoke with a shadowed key light from the side and a fill behind it: what every scene has.
ViewScene plainScene();

/// A box of 80 x 80 x 20 voxels that scatters all that it takes, seen from in front. Faces of its voxels lie anywhere
/// in a sheet.
ViewScene haze(double sigma);

/// The same field with other values: flames in the middle of the smoke, or colours that change from place to place.
ViewField flameField();
std::vector<ViewField> colouredScatter(const ViewVolume& volume);

/// Of the light that scattered twice or more, which is what a render with scattering has beyond one without, as means
/// over blocks of 8 x 8 pixels: RMS over the blocks of what they differ from the path tracer's by, relative to the mean
/// of all light. The tracer's own noise is taken out.
struct BlockError {
    double error = 0, noise = 0, share = 0;
};
BlockError blockError(const ViewScene& scene, int paths);

/// An effect: what puts it into the plain scene.
struct EffectCase {
    std::string name;
    std::function<void(ViewScene&)> add;
};
const std::vector<EffectCase>& effectCases();

/// The plain scene with one of them.
ViewScene sceneWith(const std::string& effect);

}  // namespace scrim::test
