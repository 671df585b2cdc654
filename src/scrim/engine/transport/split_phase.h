// SPDX-License-Identifier: Apache-2.0
// Splits a phase function whose lobes are too narrow for the ordinates: part of the light continues straight on as if
// it had not been scattered, the rest scatters into a wider lobe, and the mean cosine is preserved (J. H. Joseph, W. J.
// Wiscombe and J. A. Weinman, The Delta-Eddington Approximation, J. Atmos. Sci. 33, 1976). The light of a beam that
// continued straight on is shown to the eye without this approximation of its directions, because the eye is sensitive
// to them.
#pragma once

#include <scrim/scene/medium.h>

#include <vector>

namespace scrim {

class SplitPhase {
  public:
    /// Splits `phase` for a solve with `ordinates` directions.
    SplitPhase(const Phase& phase, int ordinates);

    /// The fraction of scattered light that continues straight on, in [0, 1).
    double straight() const { return m_straight; }
    /// The phase function of the rest.
    const Phase& spread() const { return m_spread; }

    /// The light of a beam, relative to the beam, that was scattered before and is now scattered, per steradian, in a
    /// direction at cosine `cosTheta` to the beam. The beam has passed the optical depth `depth` of scattering straight
    /// on. In the solve it is as narrow as before, but its true light is not: each time, it is spread by the phase
    /// function minus the wider lobe. In Legendre's polynomials the repeated spreading is a product, and the sum over
    /// the number of times is an exponential. The difference of the two lobes may be below zero far from the beam, and
    /// then so is the result; this preserves its sum.
    double scatteredAgain(double depth, double cosTheta) const;

  private:
    double m_straight = 0;
    Phase m_spread;
    std::vector<float> m_table;  // over depth and angle, see split_phase.cpp
};

}  // namespace scrim
