// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/blackbody.h>

#include <scrim/image/spectrum.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr double kSecondRadiation = 1.438776877e7;   // hc/k in nm K, CODATA 2018
constexpr double kStefanBoltzmann = 5.670374419e-8;  // W / (m^2 K^4), CODATA 2018
constexpr double kMegawatts = 1e-6;                  // per watt
constexpr double kCoolestPoint = 100;                // Kelvin; below, a straight line to 0 suffices
// Ratio of successive points; between them T^4 deviates by 1.5 (kGrowth - 1)^2 of itself.
constexpr double kGrowth = 1.015;

}  // namespace

Vec3 blackbodyXyz(double kelvin) {
    const double t = std::clamp(kelvin, kCoolestColour, kHottestColour);
    Vec3 xyz(0);
    double wavelength = kFirstWavelength;
    for (const Vec3& seen : observer()) {
        // Planck's law up to a factor; relative to 560 nm, so that numbers stay near 1.
        const double planck = std::pow(560 / wavelength, 5) / std::expm1(kSecondRadiation / (wavelength * t));
        xyz += planck * seen;
        wavelength += kWavelengthStep;
    }
    return xyz / xyz.y;
}

double blackbodyRadiance(double kelvin) {
    constexpr double pi = std::numbers::pi;
    return kelvin > 0 ? kStefanBoltzmann * std::pow(kelvin, 4) / pi * kMegawatts : 0;
}

Blackbody::Blackbody(const ColourConfig& config) : m_workingFromXyz(workingFromXyz(config)) {
    const Mat3 xyzFromWorking = glm::inverse(m_workingFromXyz);
    m_luminance = Vec3(xyzFromWorking[0].y, xyzFromWorking[1].y, xyzFromWorking[2].y);
}

Rgb Blackbody::colour(double kelvin) const {
    const Rgb inGamut = glm::max(m_workingFromXyz * blackbodyXyz(kelvin), Rgb(0));
    return inGamut / glm::dot(m_luminance, inGamut);
}

std::vector<std::pair<double, Rgb>> Blackbody::ramp(double scale, double offset, double physical) const {
    std::vector<std::pair<double, Rgb>> points;
    const auto add = [&](double kelvin) {
        points.emplace_back((kelvin - offset) / scale, colour(kelvin) * std::pow(blackbodyRadiance(kelvin), physical));
    };
    // The ramp rises from black to the first colour within one Kelvin: above 0 Kelvin, or lower
    // where grid value 0 lies at 0 to 1 Kelvin, since that value must have its colour.
    const double dark = offset < 0 ? 0 : std::min(0.0, offset - 1);
    points.emplace_back((dark - offset) / scale, Rgb(0));
    add(dark + 1);
    add(kCoolestPoint);
    const auto addUpTo = [&](double from, double to) {
        const double steps = std::ceil(std::log(to / from) / std::log(kGrowth));
        for (double step = 1; step < steps; ++step) add(from * std::pow(to / from, step / steps));
        add(to);
    };
    addUpTo(kCoolestPoint, kCoolestColour);  // chromaticity starts to change here, which makes a kink
    addUpTo(kCoolestColour, kHottestColour);
    return points;
}

}  // namespace scrim
