// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/clear_sky.h>

#include <scrim/base/parallel.h>
#include <scrim/image/spectrum.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include <glm/common.hpp>

namespace scrim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180, kMetre = 1e-3;
constexpr int kWidth = 1024, kHeight = 512;
constexpr int kAzimuths = 32;  // steps from the sun's side to the far one; linear between them is within 0.2 %
constexpr int kStrips = 33;    // of the sun, from its lower rim to its upper one

// The sun's irradiance above the air, W / (m^2 nm), means over 20 nm around each wavelength (ASTM G173-03).
constexpr Spectrum kSun{1.078, 1.437, 1.710, 1.762, 2.028, 1.978, 1.937, 1.849, 1.872, 1.842, 1.825,
                        1.767, 1.689, 1.626, 1.539, 1.493, 1.429, 1.355, 1.299, 1.252, 1.198};
constexpr double kLumens = 683;  // per watt at 555 nm

}  // namespace

SunColours::SunColours(const ColourConfig& colour) {
    const Mat3 working = workingFromXyz(colour);
    const std::span<const Vec3> seen = observer();  // every 10 nm, at every second wavelength one of the spectrum's
    for (std::size_t i = 0; i < m_colours.size(); ++i) {
        Vec3 xyz = seen[2 * i];
        if (i > 0) xyz += 0.5 * seen[2 * i - 1];
        if (2 * i + 1 < seen.size()) xyz += 0.5 * seen[2 * i + 1];
        m_colours[i] = working * xyz * (kSun[i] * kWavelengthStep * kLumens * kPi / kLuxOfPi);
    }
}

Rgb SunColours::operator()(const Spectrum& parts) const {
    Rgb sum(0);
    for (std::size_t i = 0; i < parts.size(); ++i) sum += parts[i] * m_colours[i];
    return sum;
}

namespace {

class SkyPainter {
  public:
    SkyPainter(const ClearSky& sky, const ColourConfig& colour)
        : m_sky(sky),
          m_colours(colour),
          m_atmosphere({sky.airDensity, sky.dustDensity, sky.ozoneDensity, sky.groundAlbedo}) {}

    Image picture() const {
        Image image = emptyImage({0, 0, kWidth, kHeight});
        parallelFor(kHeight, [&](std::size_t y) { paintRow(static_cast<int>(y), image); });
        return image;
    }

    // The sun, whose air changes its light from its lower rim to its upper one; black below the horizon.
    SkySun sun() const {
        SkySun sun{0.5, 0.5 - sunElevation() / kPi, m_sky.sunSize, Rgb(0), {}};
        const double radius = 0.5 * m_sky.sunSize * kDegree, solidAngle = 2 * kPi * (1 - std::cos(radius));
        const auto below = [](double x) { return (std::asin(x) + x * std::sqrt(1 - x * x)) / kPi; };  // of a disk
        for (int i = 0; i < kStrips; ++i) {
            const double low = 2.0 * i / kStrips - 1, high = 2.0 * (i + 1) / kStrips - 1;
            const double elevation = sunElevation() + 0.5 * (low + high) * radius;
            const AirWay way(height(), std::sin(elevation));
            Rgb light(0);
            if (!way.meetsGround()) light = m_colours(m_atmosphere.transmittance(way.toSpace())) * m_sky.sunIntensity;
            light = glm::max(light, Rgb(0));
            sun.light += light * (below(std::min(high, 1.0)) - below(low));
            sun.rows.push_back(light / solidAngle);
        }
        return sun;
    }

  private:
    double sunElevation() const { return m_sky.sunElevation * kDegree; }
    double height() const { return m_sky.altitude * kMetre; }

    struct Colours {
        Rgb air{0}, dust{0}, rest{0};
    };

    Colours coloursAt(const Atmosphere::View& view, double azimuth) const {
        const Atmosphere::Sent sent = view.under(sunElevation(), azimuth);
        return {m_colours(sent.air), m_colours(sent.dust), m_colours(sent.rest)};
    }

    void paintRow(int y, Image& image) const {
        const double elevation = kPi * (0.5 - (y + 0.5) / kHeight);
        const Atmosphere::View view(m_atmosphere, height(), elevation);
        std::vector<Colours> around;
        for (int i = 0; i <= kAzimuths; ++i) around.push_back(coloursAt(view, kPi * i / kAzimuths));
        for (int x = 0; x < kWidth; ++x) {
            const double turn = std::abs((x + 0.5) / kWidth - 0.5) * 2;  // from the sun's side, in parts of pi
            const double at = turn * kAzimuths,
                         cosine = std::sin(elevation) * std::sin(sunElevation()) +
                                  std::cos(elevation) * std::cos(sunElevation()) * std::cos(kPi * turn);
            const auto first = static_cast<std::size_t>(at);
            const double part = at - static_cast<double>(first);
            const auto mixed = [&](Rgb Colours::*of) {
                return (1 - part) * around[first].*of + part * around[first + 1].*of;
            };
            const Rgb light = airPhase(cosine) * mixed(&Colours::air) + dustPhase(cosine) * mixed(&Colours::dust) +
                              mixed(&Colours::rest);
            float* pixel = image.rgba.data() + image.indexOf(x, y);
            for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(std::max(light[c], 0.0));
            pixel[3] = 1;
        }
    }

    ClearSky m_sky;
    SunColours m_colours;
    Atmosphere m_atmosphere;
};

}  // namespace

SkyPicture skyPicture(const ClearSky& sky, const ColourConfig& colour) {
    const SkyPainter painter(sky, colour);
    SkyPicture out;
    out.image = std::make_shared<const Texture>(painter.picture());
    SkyParts parts{{}, out.image};
    if (sky.sunDisc) parts.suns.push_back(painter.sun());
    if (sky.sunDisc && parts.suns.front().light == Rgb(0)) parts.suns.clear();
    out.parts = std::make_shared<const SkyParts>(std::move(parts));
    return out;
}

}  // namespace scrim
