// SPDX-License-Identifier: Apache-2.0
// Phase functions as Legendre series, and those whose lobes are too narrow for one.
#pragma once

#include <scrim/scene/medium.h>

#include <vector>

namespace scrim {

/// The first `count` Legendre moments of a phase function: g^l for Henyey and Greenstein's.
std::vector<double> legendreMoments(const Phase& phase, int count);

/// Splits a phase function whose lobes are too narrow for the ordinates: part of the light continues straight on as if
/// it had not been scattered, and all moments that the ordinates resolve are preserved (W. J. Wiscombe, The Delta-M
/// Method, J. Atmos. Sci. 34, 1977). The light of a beam that continued straight on is shown to the eye without this
/// approximation of its directions, because the eye is sensitive to them.
class SplitPhase {
  public:
    /// Splits `phase` for ordinates that resolve `moments` moments.
    SplitPhase(const Phase& phase, int moments);

    /// The fraction of scattered light that continues straight on, in [0, 1).
    double straight() const { return m_straight; }
    /// The moments of the rest.
    const std::vector<double>& spread() const { return m_spread; }
    /// The moments by which light from a light is scattered for the first time. It comes from one direction, which no
    /// ordinates resolve. With many moments, these are not those of the rest: the first two are, and the
    /// others make the series most like the phase function away from its lobe, relative to it.
    const std::vector<double>& first() const { return m_first; }
    /// The moments of both that the ordinates resolve.
    const std::vector<double>& whole() const { return m_whole; }

    /// The light of a beam, relative to the beam, that was scattered before and is now scattered, per steradian, in a
    /// direction at cosine `cosTheta` to the beam. The beam has passed the optical depth `depth` of scattering straight
    /// on. In the solve it is as narrow as before, but its true light is not: each time, it is spread by the phase
    /// function minus its moments in `first`. In Legendre's polynomials the repeated spreading is a product, and the
    /// sum over the number of times is an exponential. The difference may be below zero far from the beam, and then so
    /// is the result; this preserves its sum.
    double scatteredAgain(double depth, double cosTheta) const;

  private:
    double m_straight = 0;
    std::vector<double> m_spread, m_first, m_whole;
    std::vector<float> m_table;  // over depth and angle, see ordinates.cpp
};

}  // namespace scrim
