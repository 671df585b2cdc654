// SPDX-License-Identifier: Apache-2.0
// The Earth's clear air: how much light it lets through, and how much of the sun's it scatters towards an eye. Light
// travels straight (no refraction). What scatters once is integrated, after T. Nishita, T. Sirai, K. Tadamura and E.
// Nakamae, "Display of The Earth Taking into Account Atmospheric Scattering", SIGGRAPH 1993, with ozone. What scatters
// again comes evenly from all sides, after S. Hillaire, "A Scalable and Production Ready Sky and Atmosphere Rendering
// Technique", EGSR 2020, section 5.5. Lengths are km.
#pragma once

#include <array>
#include <vector>

namespace scrim {

inline constexpr int kWavelengths = 21;  ///< 380 to 780 nm, every 20 nm
/// A value for each wavelength.
using Spectrum = std::array<double, kWavelengths>;

inline constexpr double kEarthRadius = 6371, kTopOfAir = 100;  ///< km; no light scatters above the top
/// The heights over which air and dust thin out by a factor e, km.
inline constexpr double kAirScale = 8, kDustScale = 1.2;

/// What lies along a way: the length through air as dense as at the sea, through dust as dense as there, and through
/// ozone as dense as in the middle of its layer, which rises from 10 to 25 km and falls to 40 km.
struct AirColumn {
    double air = 0, dust = 0, ozone = 0;
};

/// A straight way through the atmosphere. A place on it is `s`, its distance behind the point that
/// is nearest to the Earth's centre.
class AirWay {
  public:
    /// From a height above the sea, 0 or more, at an angle of this cosine to the vertical.
    AirWay(double height, double cosine);

    double start() const { return m_start; }
    bool meetsGround() const { return m_start < 0 && m_nearest < kEarthRadius; }
    /// Where it meets the ground, or else leaves the air.
    double end() const;
    double heightAt(double s) const;
    /// The column between two places, a <= b, none of which is below the ground.
    AirColumn between(double a, double b) const;
    /// The column from its start to space, for a way that does not meet the ground.
    AirColumn toSpace() const;

  private:
    AirColumn outwards(double s) const;  // from s >= 0 to space

    double m_nearest, m_start;
};

/// What is in the air, and below it: factors on the densities of a clear day, with dust of an optical depth of 0.027
/// and 300 Dobson units of ozone; and the part of its light that the ground sends back, evenly.
struct AirContent {
    double air = 1, dust = 1, ozone = 1, groundAlbedo = 0;
};

class Atmosphere {
  public:
    /// Takes about 0.1 s of processor time.
    explicit Atmosphere(const AirContent& content);

    /// What light keeps along a way with this column. Air: J. Hansen and L. Travis, Space Science Reviews 16, 1974,
    /// eq. 2.30. Ozone: the cross-sections at 233 K of V. Gorshelev, A. Serdyuchenko and others, 2014.
    Spectrum transmittance(const AirColumn& column) const;

    /// The sunlight that comes to an eye, per unit of the sun's irradiance: what air and dust scatter once, still to be
    /// multiplied by their phase functions, and radiance that has scattered again or comes from the ground.
    struct Sent {
        Spectrum air{}, dust{}, rest{};
    };

    /// What an eye sees along a ray, for any place of the sun.
    class View {
      public:
        /// From a height, at an elevation above the horizontal, radians.
        View(const Atmosphere& atmosphere, double height, double elevation);
        /// `azimuth`: between the ray and the sun, radians.
        Sent under(double sunElevation, double azimuth) const;
        /// The part of light from all sides that scatters on the ray towards the eye, but for the phase function.
        const Spectrum& scattered() const { return m_scattered; }

      private:
        struct Place {
            double along, height;  // from the eye; above the sea
            Spectrum air, dust;    // what reaches the eye of all that scatters there, per unit of light
        };
        Place placeAt(double s, double length) const;

        const Atmosphere& m_atmosphere;
        AirWay m_way;
        double m_height, m_elevation;
        std::vector<Place> m_places;
        Spectrum m_fromEnd, m_scattered{};
    };

    /// The irradiance of level ground at the sea, by the sun and the sky, per unit of the sun's.
    /// `cosine`: of the angle between the sun and the vertical.
    Spectrum onGround(double cosine) const;

  private:
    /// Spectra at heights and cosines between the sun and the vertical, linear between them.
    class Table {
      public:
        explicit Table(int heights);
        Spectrum at(double height, double cosine) const;
        Spectrum& value(int height, int sun);
        static double heightOf(int i);
        static double cosineOf(int j);

      private:
        int m_heights;
        std::vector<Spectrum> m_values;
    };
    void fillAgain(int height, Table& again) const;
    Spectrum skyOnGround(double cosine) const;

    AirContent m_content;
    Table m_again;     // the mean over all directions of light that has scattered at least once
    Table m_onGround;  // of the height 0 alone
};

/// The phase functions of air (Rayleigh) and dust (Cornette and Shanks, 1992, with g = 0.76), for
/// the cosine between sunlight and the way to the eye. Their integrals over the sphere are 1.
double airPhase(double cosine);
double dustPhase(double cosine);

}  // namespace scrim
