// SPDX-License-Identifier: Apache-2.0
// A participating medium, as VFX scenes state it: extinction is the field times a scale, a part of what is
// taken from a ray is scattered.
#pragma once

#include <scrim/geometry/spaces.h>

#include <algorithm>

namespace scrim {

/// Phase functions: how much of the scattered light goes which way, per steradian.
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

    bool operator==(const Phase&) const = default;

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

/// The look of multiple scattering, after M. Wrenninge, "Oz: the great and volumetric" (2013): octave n adds single
/// scattering anew, with extinction towards the light times extinction^n, the whole times contribution^n, and a phase
/// function of which phase^n is left. As long as contribution <= extinction no octave scatters more than it would take
/// away from light that passed its own thinner medium; what all of them scatter together is bounded by the sum only.
struct Octaves {
    int count = 1;  ///< 1: single scattering
    double extinction = 0.5, contribution = 0.5, phase = 0.5;

    bool operator==(const Octaves&) const = default;
};

/// How often light may scatter in a medium before it reaches the eye.
enum class Scattering {
    single,   ///< once
    octaves,  ///< the look of more than once, see Octaves
    full,     ///< as often as it does: transport by discrete ordinates (engine/transport)
};

struct Medium {
    double densityScale = 1;  ///< extinction per world unit = field value times this
    Rgb albedo{0.9};          ///< scattered part of extinction, each channel in [0, 1]
    Phase phase = {};
    Rgb extinctionTint{1};  ///< multiplies extinction, in each channel
    Scattering scattering = Scattering::single;
    Octaves octaves = {};

    bool operator==(const Medium&) const = default;
    /// Extinction per world unit and field value in the channel that has most, and what part of it each channel has.
    double mostExtinction() const { return densityScale * mostTint(); }
    Rgb relativeTint() const { return mostTint() > 0 ? extinctionTint / mostTint() : Rgb(1); }

  private:
    double mostTint() const { return std::max({extinctionTint.x, extinctionTint.y, extinctionTint.z}); }
};

}  // namespace scrim
