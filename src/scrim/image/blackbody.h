// SPDX-License-Identifier: Apache-2.0
// The light of black bodies: Planck's law, seen by the CIE 1931 2-degree observer, in the working space. Fire is
// drawn with it.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/image/colour.h>

#include <utility>
#include <vector>

namespace scrim {

/// Between them chromaticity follows the temperature; beyond them it is that of the nearer one.
inline constexpr double kCoolestColour = 800, kHottestColour = 40000;  // Kelvin

/// CIE XYZ of a black body of `kelvin`, for Y = 1.
Vec3 blackbodyXyz(double kelvin);

/// All it radiates, in MW / (m^2 sr): sigma T^4 / pi (Stefan-Boltzmann); 0 for a temperature not above 0.
double blackbodyRadiance(double kelvin);

/// Colours of black bodies in a config's working space.
class Blackbody {
  public:
    /// Throws Error(input) where the config has neither linear Rec.709 nor ACES2065-1, from which the way is known.
    explicit Blackbody(const ColourConfig& config);

    /// The colour at `kelvin`, of luminance 1: CIE Y before the white of the working space is adapted to. Where the
    /// space has no such colour the negative components are 0, and the luminance is kept.
    Rgb colour(double kelvin) const;

    /// Colour over grid value, for `kelvin = value * scale + offset`, scale > 0: black where that is below 0, constant
    /// above kHottestColour, the luminance 1 or, where not `normalize`, blackbodyRadiance. Ascending; what is linear
    /// between two points is within 0.2 % of the luminance from 100 K on.
    std::vector<std::pair<double, Rgb>> ramp(double scale, double offset, bool normalize) const;

  private:
    Mat3 m_workingFromXyz;
    Vec3 m_luminance;  ///< CIE Y of the working space's primaries
};

}  // namespace scrim
