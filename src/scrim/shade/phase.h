// SPDX-License-Identifier: Apache-2.0
// Phase functions: how much of the scattered light goes which way, per steradian.
#pragma once

namespace scrim {

enum class PhaseType {
    henyeyGreenstein,  ///< one lobe of mean cosine g
    twoLobe,           ///< two of them: g with the weight 1 - blend, g2 with the weight blend
    rayleigh,          ///< 3/(16 pi) (1 + cos^2): particles much smaller than the wavelength
};

struct Phase {
    double g = 0;  ///< mean cosine in (-1, 1); 0 is isotropic, above 0 scatters forward
    PhaseType type = PhaseType::henyeyGreenstein;
    double g2 = 0;        ///< two-lobe: of the second lobe
    double blend = 0.5;   ///< two-lobe: weight of the second lobe, in [0, 1]
    double strength = 1;  ///< rayleigh: in [0, 1], how much of it is not isotropic

    bool isotropic() const {
        switch (type) {
            case PhaseType::twoLobe:
                return (g == 0 || blend == 1) && (g2 == 0 || blend == 0);
            case PhaseType::rayleigh:
                return strength == 0;
            default:
                return g == 0;
        }
    }
};

/// Phase function for light that travels along l before and along o after scattering, cosTheta = l.o (both unit
/// directions of travel). Integrates to 1 over the sphere.
double phaseValue(const Phase& phase, double cosTheta);

/// The same with `part` in [0, 1] of its direction left: mean cosines times `part` (Wrenninge's octaves).
Phase flattened(const Phase& phase, double part);

}  // namespace scrim
