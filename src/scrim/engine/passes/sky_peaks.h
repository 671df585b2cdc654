// SPDX-License-Identifier: Apache-2.0
// The light of a sky in the peaks of a phase function that were cut off for its directions. It
// comes from where the eye looks, or from behind it, and rays find it in the sky.
#pragma once

#include <scrim/engine/cells/cell_field.h>
#include <scrim/engine/cells/cell_walk.h>
#include <scrim/engine/passes/sources.h>

#include <functional>
#include <vector>

namespace scrim {

/// Adds it to `field`, which has one colour if the sources have. `wide`: widePhases of `octave`'s phase function for
/// `sources`. `media`: what attenuates the light. `checkpoint` is called before the work; it throws to stop.
void addPeaks(const ViewScene& scene, const Sources& sources, const std::vector<WidePhase>& wide, const Octave& octave,
              const MediaTogether& media, CellField& field, const std::function<void()>& checkpoint);

}  // namespace scrim
