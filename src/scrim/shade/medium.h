// SPDX-License-Identifier: Apache-2.0
// A participating medium, as VFX scenes state it: extinction is the field times a scale, a part of what is
// taken from a ray is scattered.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/shade/phase.h>

#include <algorithm>

namespace scrim {

/// The look of multiple scattering, after M. Wrenninge, "Oz: the great and volumetric" (2013): octave n adds single
/// scattering anew, with extinction towards the light times extinction^n, the whole times contribution^n, and a phase
/// function of which phase^n is left. As long as contribution <= extinction no octave scatters more than it would take away
/// from light that passed its own thinner medium; what all of them scatter together is bounded by the sum only.
struct Octaves {
    int count = 1;  ///< 1: single scattering
    double extinction = 0.5, contribution = 0.5, phase = 0.5;
};

struct Medium {
    double densityScale = 1;  ///< extinction per world unit = field value times this
    Rgb albedo{0.9};          ///< scattered part of extinction, each channel in [0, 1]
    Phase phase = {};
    Rgb extinctionTint{1};  ///< multiplies extinction, in each channel
    Octaves octaves = {};

    /// Extinction per world unit and field value in the channel that has most, and what part of it each channel has.
    double mostExtinction() const { return densityScale * mostTint(); }
    Rgb relativeTint() const { return mostTint() > 0 ? extinctionTint / mostTint() : Rgb(1); }

  private:
    double mostTint() const { return std::max({extinctionTint.x, extinctionTint.y, extinctionTint.z}); }
};

}  // namespace scrim
