// SPDX-License-Identifier: Apache-2.0
// The picture of a clear sky, from the place of the sun and the air: what a dome shows in place of a file.
#pragma once

#include <scrim/image/atmosphere.h>
#include <scrim/image/colour.h>
#include <scrim/image/sky_parts.h>
#include <scrim/image/texture.h>

#include <array>
#include <compare>
#include <memory>

namespace scrim {

/// Two equal skies have the same picture. Densities are factors on those of a clear day (see Atmosphere).
struct ClearSky {
    double sunElevation = 15;  ///< of the sun's centre above the horizontal, degrees, from -90 to 90
    double altitude = 0;       ///< of the eye and all that the sky lights, metres above the sea
    double airDensity = 1, dustDensity = 1, ozoneDensity = 1;
    double groundAlbedo = 0.2;  ///< of the Earth below the horizon, which scatters evenly to all sides
    bool sunDisc = true;        ///< the sun itself is in the sky
    double sunSize = 0.545;     ///< angular diameter, degrees; its irradiance stays the same
    double sunIntensity = 1;    ///< factor on the sun itself, not on the light that the air scatters

    auto operator<=>(const ClearSky&) const = default;
};

/// The irradiance in lux that stands for pi, so that a white card in it has radiance 1.
inline constexpr double kLuxOfPi = 100e3;

/// Turns light of the sun, of which the air has left or scattered a part at each wavelength, into a colour of the
/// working space, in units of kLuxOfPi. Components may be negative. Throws as skyPicture does.
class SunColours {
  public:
    explicit SunColours(const ColourConfig& colour);
    Rgb operator()(const Spectrum& parts) const;

  private:
    std::array<Rgb, kWavelengths> m_colours;
};

struct SkyPicture {
    std::shared_ptr<const Texture> image;   ///< lat-long, 1024 x 512, without the sun, which is in its middle column
    std::shared_ptr<const SkyParts> parts;  ///< that picture as the smooth part, and the sun
};

/// The radiance of the sky in the working space of `colour`, in units of kLuxOfPi; negative components are 0. Takes
/// about 0.35 s of processor time. Throws Error(input) where the config allows no conversion from CIE XYZ.
SkyPicture skyPicture(const ClearSky& sky, const ColourConfig& colour);

}  // namespace scrim
