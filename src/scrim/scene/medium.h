// SPDX-License-Identifier: Apache-2.0
// A participating medium as VFX scenes state it: extinction is the field times a scale, and a
// fraction of it (the albedo) is scattered.
#pragma once

#include <scrim/geometry/spaces.h>

#include <algorithm>
#include <vector>

namespace scrim {

/// Phase functions: the distribution of scattered light over directions, per steradian.
enum class PhaseType {
    henyeyGreenstein,  ///< one lobe of mean cosine g
    twoLobe,           ///< g with weight 1 - blend, and g2, which may be Draine's, with weight blend
    rayleigh,          ///< 3/(16 pi) (1 + cos^2): particles much smaller than the wavelength
};

struct Phase {
    double g = 0;  ///< mean cosine in (-1, 1); 0 is isotropic, above 0 scatters forward
    PhaseType type = PhaseType::henyeyGreenstein;
    double g2 = 0;        ///< two-lobe: mean cosine of the second lobe
    double blend = 0.5;   ///< two-lobe: weight of the second lobe, in [0, 1]
    double strength = 1;  ///< rayleigh: the fraction, in [0, 1], that is not isotropic
    /// two-lobe: the second lobe times 1 + alpha cos^2, normalised (B. T. Draine, Astrophys. J. 598, 2003); 0 or more.
    double alpha = 0;

    bool operator==(const Phase&) const = default;

    bool isotropic() const {
        switch (type) {
            case PhaseType::twoLobe:
                return (g == 0 || blend == 1) && ((g2 == 0 && alpha == 0) || blend == 0);
            case PhaseType::rayleigh:
                return strength == 0;
            default:
                return g == 0;
        }
    }
};

/// Draine's phase function: 0 is Henyey and Greenstein's, 1 Cornette and Shanks', 1 with g = 0 Rayleigh's.
inline Phase drainePhase(double g, double alpha) {
    return {0, PhaseType::twoLobe, g, 1, 1, alpha};
}

/// The phase function of water droplets, `size` micrometres in diameter, above 0 to 50: a fit to
/// Mie's theory with one lobe of Henyey and Greenstein and one of Draine (J. Jendersie and E.
/// d'Eon, An Approximate Mie Scattering Function for Fog and Cloud Rendering, SIGGRAPH Talks 2023).
Phase dropletPhase(double size);

/// Value of the phase function for light that travels along l before and along o after scattering,
/// with cosTheta = l.o (both unit directions of travel). It integrates to 1 over the sphere.
double phaseValue(const Phase& phase, double cosTheta);

/// The phase function with its mean cosines multiplied by `part` in [0, 1] (Wrenninge's octaves).
Phase flattened(const Phase& phase, double part);

/// An approximation of multiple scattering, after M. Wrenninge, "Oz: the great and volumetric" (2013). Octave n adds
/// single scattering once more, with extinction towards the light times extinction^n, the result times contribution^n,
/// and the phase function's mean cosines times phase^n. As long as contribution <= extinction, no octave scatters more
/// than it removes from light that passes its own, thinner medium; nothing but the sum over octaves bounds what all of
/// them scatter together.
struct Octaves {
    int count = 1;  ///< 1: single scattering
    double extinction = 0.5, contribution = 0.5, phase = 0.5;

    bool operator==(const Octaves&) const = default;
};

/// The order of scattering that is simulated between the lights and the eye.
enum class Scattering {
    single,   ///< single scattering
    octaves,  ///< an approximation of multiple scattering, see Octaves
    full,     ///< multiple scattering, by the method of discrete ordinates (engine/solve)
};

struct Medium {
    double densityScale = 1;  ///< extinction per world unit = field value times this
    Rgb albedo{0.9};          ///< scattered fraction of extinction, each channel in [0, 1]
    Phase phase = {};
    Rgb extinctionTint{1};  ///< factor on extinction in each channel
    Scattering scattering = Scattering::single;
    Octaves octaves = {};

    bool operator==(const Medium&) const = default;
    /// mostExtinction: extinction per world unit for a field value of 1, in the channel where it is
    /// largest. relativeTint: the extinction of each channel relative to that channel.
    double mostExtinction() const { return densityScale * mostTint(); }
    Rgb relativeTint() const { return mostTint() > 0 ? extinctionTint / mostTint() : Rgb(1); }

  private:
    double mostTint() const { return std::max({extinctionTint.x, extinctionTint.y, extinctionTint.z}); }
};

/// What one octave of a medium sends towards the eye; the first one is single scattering (see Octaves).
struct Octave {
    Phase phase;
    double extinction = 1;  ///< factor on what attenuates the light
    double share = 1;       ///< factor on the light
};
std::vector<Octave> octavesOf(const Medium& medium);

}  // namespace scrim
