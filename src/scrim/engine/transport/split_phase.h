// SPDX-License-Identifier: Apache-2.0
// A phase function with narrow lobes, for which ordinates are too few: part of the light goes straight on as if it had
// not been scattered, the rest into a wider lobe, and the mean cosine is kept (J. H. Joseph, W. J. Wiscombe and
// J. A. Weinman, The Delta-Eddington Approximation, J. Atmos. Sci. 33, 1976). What the eye sees of a light's beam that
// so went straight on is found without that approximation of its directions, for which the eye has a sharp sense.
#pragma once

#include <scrim/scene/medium.h>

#include <vector>

namespace scrim {

class SplitPhase {
  public:
    /// For a solve with `ordinates` directions.
    SplitPhase(const Phase& phase, int ordinates);

    /// Part of the scattered light that goes straight on, in [0, 1).
    double straight() const { return m_straight; }
    /// Of the rest.
    const Phase& spread() const { return m_spread; }

    /// Of a beam that came an optical depth `depth` of scattering straight on: what of it is scattered towards a
    /// direction at cosine `cosTheta` to it, per steradian, that was scattered before, relative to the beam with all
    /// that. The beam is as narrow as ever, but its light is not: each time it is spread by what is left of the phase
    /// function without the wider lobe. In Legendre's polynomials that is a product, and a sum over the number of times
    /// is an exponential. What is left may be below zero far from the beam; then so is this, which keeps its sum.
    double scatteredAgain(double depth, double cosTheta) const;

  private:
    double m_straight = 0;
    Phase m_spread;
    std::vector<float> m_table;  // over depth and angle, see split_phase.cpp
};

}  // namespace scrim
