// SPDX-License-Identifier: Apache-2.0
// A participating medium, as VFX scenes state it: extinction is the field times a scale, a part of what is
// taken from a ray is scattered.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/shade/phase.h>

namespace scrim {

struct Medium {
    double densityScale = 1;  ///< extinction per world unit = field value times this
    Rgb albedo{0.9};          ///< scattered part of extinction, each channel in [0, 1]
    Phase phase;
};

}  // namespace scrim
