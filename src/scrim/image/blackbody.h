// SPDX-License-Identifier: Apache-2.0
// The colour of blackbodies in the working space: Planck's law as seen by the CIE 1931 2-degree
// observer. It is used for fire.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/image/colour.h>

#include <utility>
#include <vector>

namespace scrim {

/// Between these temperatures chromaticity follows the temperature; beyond them it is that of the nearer limit.
inline constexpr double kCoolestColour = 800, kHottestColour = 40000;  // Kelvin

/// CIE XYZ of a blackbody at `kelvin`, normalised to Y = 1.
Vec3 blackbodyXyz(double kelvin);

/// The total radiance of a blackbody, in MW / (m^2 sr): sigma T^4 / pi (Stefan-Boltzmann); 0 for
/// temperatures that are not above 0.
double blackbodyRadiance(double kelvin);

/// Colours of blackbodies in a config's working space.
class Blackbody {
  public:
    /// Throws Error(input) where the config has neither linear Rec.709 nor ACES2065-1, from which
    /// the conversion is known.
    explicit Blackbody(const ColourConfig& config);

    /// The colour at `kelvin`, with luminance 1: CIE Y before adaptation to the white of the working space. Where the
    /// colour is outside of the space, negative components become 0 and the luminance is kept.
    Rgb colour(double kelvin) const;

    /// A ramp from grid value to colour, for `kelvin = value * scale + offset`, scale > 0: black where kelvin is below
    /// 0, constant above kHottestColour. The luminance is blackbodyRadiance to the power of `physical`, 0 to 1. Points
    /// ascend; linear interpolation between them is within 0.2 % of the luminance from 100 K on.
    std::vector<std::pair<double, Rgb>> ramp(double scale, double offset, double physical) const;

  private:
    Mat3 m_workingFromXyz;
    Vec3 m_luminance;  ///< CIE Y of the working space's primaries
};

}  // namespace scrim
