// SPDX-License-Identifier: Apache-2.0
// Phase functions: how much of the scattered light goes which way, per steradian.
#pragma once

namespace scrim {

/// Henyey-Greenstein with mean cosine g in (-1, 1); g = 0 is isotropic, g > 0 scatters forward.
struct Phase {
    double g = 0;

    bool isotropic() const { return g == 0; }
};

/// Phase function for light that travels along l before and along o after scattering, cosTheta = l.o (both unit
/// directions of travel). Integrates to 1 over the sphere.
double phaseValue(const Phase& phase, double cosTheta);

}  // namespace scrim
