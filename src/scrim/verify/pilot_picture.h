// SPDX-License-Identifier: Apache-2.0
// Small pictures that tell how a scene's error falls with a dial: two of them at different settings
// differ by about the error of the coarser one.
#pragma once

#include <scrim/image/image.h>
#include <scrim/scene/view_scene.h>
#include <scrim/verify/verify.h>

namespace scrim {

/// `view`, whatever its crop, as a whole picture whose longer edge has at most `edge` pixels, without layers and light
/// that scatters more than once. Details of soft lights are left out, since they cost more than they tell.
ViewScene pilotView(ViewScene view, int edge);

/// How far `coarse` is from `fine`, as if that were true.
Verification differenceOf(const Image& coarse, const Image& fine);

}  // namespace scrim
