// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/atmosphere.h>

#include <scrim/base/legendre.h>
#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace scrim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kScales = 14;  // heights of this many scales hold all but 1e-6 of a column
constexpr double kOzoneBottom = 10, kOzoneMiddle = 25, kOzoneTop = 40;  // km

// Per km at the sea. Dust extinguishes and scatters all wavelengths alike, and absorbs a tenth.
constexpr double kDustScattering = 0.02, kDustExtinction = kDustScattering / 0.9;

// Cross-sections of ozone, 1e-26 m^2, means over 20 nm around each wavelength.
constexpr Spectrum kOzone{0.025, 0.110, 0.414, 1.21, 2.99, 6.34, 11.9, 18.7, 29.2, 38.8, 45.4,
                          48.6,  40.2,  29.4,  20.5, 13.4, 8.44, 5.84, 4.19, 2.84, 2.67};
// Per km and 1e-26 m^2, of 300 Dobson units (2.687e20 molecules per m^2 each) in a layer as high as
// 15 km of its middle.
constexpr double kOzoneMost = 300 * 2.687e20 / 15e3 * 1e-26 * 1e3;

// Of tables: heights that are dense at the sea, and suns that are dense at the horizon. Suns below
// the last one give no light.
constexpr int kHeights = 10, kSuns = 30;
constexpr double kHighest = 80, kLowestSun = -0.5;  // km; the root of the cosine, with its sign

std::size_t inTable(int height, int sun) {
    return static_cast<std::size_t>(height * kSuns + sun);
}

// Extinction by air at the sea, per km: the optical depth of all air over its scale.
const Spectrum& airExtinction() {
    static const Spectrum all = [] {
        Spectrum out{};
        for (int i = 0; i < kWavelengths; ++i) {
            const double micrometres = 0.38 + 0.02 * i, w2 = 1 / (micrometres * micrometres);
            out[std::size_t(i)] = 0.008569 * w2 * w2 * (1 + 0.0113 * w2 + 0.00013 * w2 * w2) / kAirScale;
        }
        return out;
    }();
    return all;
}

struct Quadrature {
    std::vector<QuadraturePoint> points;  // on [0, 1]; weights sum to 1
    explicit Quadrature(int count) : points(gaussLegendre(count)) {
        for (QuadraturePoint& point : points) point = {0.5 * (1 + point.x), 0.5 * point.weight};
    }
};

// The integral of exp(-height / scale) from s >= 0 to space, on a way whose nearest distance from the centre is given.
double exponentialColumn(double nearest, double s, double scale) {
    static const Quadrature rule(10);
    const double radius = std::hypot(nearest, s), top = radius + kScales * scale;
    const double length = std::sqrt((top - nearest) * (top + nearest)) - s;
    double sum = 0;
    for (const QuadraturePoint& point : rule.points)
        sum += point.weight * std::exp((radius - std::hypot(nearest, s + point.x * length)) / scale);
    return sum * length * std::exp((kEarthRadius - radius) / scale);
}

// The integral of (height - base) from place a to b.
double heightsBetween(double nearest, double a, double b, double base) {
    const auto integral = [&](double s) {
        const double radius = std::hypot(nearest, s);
        const double curved = nearest > 0 ? nearest * nearest * std::asinh(s / nearest) : 0;
        return 0.5 * (s * radius + curved);
    };
    return integral(b) - integral(a) - (kEarthRadius + base) * (b - a);
}

double ozoneColumn(double nearest, double s) {
    const auto placeAt = [&](double height) {
        const double radius = kEarthRadius + height;
        return radius > nearest ? std::sqrt((radius - nearest) * (radius + nearest)) : 0;
    };
    const double bottom = std::max(s, placeAt(kOzoneBottom)), middle = std::max(s, placeAt(kOzoneMiddle)),
                 top = std::max(s, placeAt(kOzoneTop));
    return (heightsBetween(nearest, bottom, middle, kOzoneBottom) - heightsBetween(nearest, middle, top, kOzoneTop)) /
           (kOzoneMiddle - kOzoneBottom);
}

AirColumn operator-(const AirColumn& a, const AirColumn& b) {
    return {a.air - b.air, a.dust - b.dust, a.ozone - b.ozone};
}
AirColumn twice(const AirColumn& a) {
    return {2 * a.air, 2 * a.dust, 2 * a.ozone};
}

}  // namespace

AirWay::AirWay(double height, double cosine)
    : m_nearest((kEarthRadius + height) * std::sqrt(std::max(1 - cosine * cosine, 0.0))),
      m_start((kEarthRadius + height) * cosine) {}

double AirWay::end() const {
    const double radius = kEarthRadius + (meetsGround() ? 0 : kTopOfAir);
    const double s = std::sqrt(std::max((radius - m_nearest) * (radius + m_nearest), 0.0));
    return meetsGround() ? std::max(-s, m_start) : std::max(s, m_start);
}

double AirWay::heightAt(double s) const {
    return std::hypot(m_nearest, s) - kEarthRadius;
}

AirColumn AirWay::outwards(double s) const {
    return {exponentialColumn(m_nearest, s, kAirScale), exponentialColumn(m_nearest, s, kDustScale),
            ozoneColumn(m_nearest, s)};
}

AirColumn AirWay::between(double a, double b) const {
    if (a >= 0) return outwards(a) - outwards(b);
    if (b <= 0) return outwards(-b) - outwards(-a);
    return twice(outwards(0)) - outwards(-a) - outwards(b);
}

AirColumn AirWay::toSpace() const {
    return m_start >= 0 ? outwards(m_start) : twice(outwards(0)) - outwards(-m_start);
}

Spectrum Atmosphere::transmittance(const AirColumn& column) const {
    const double dust = m_content.dust * kDustExtinction * column.dust, air = m_content.air * column.air,
                 ozone = m_content.ozone * kOzoneMost * column.ozone;
    Spectrum out{};
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = std::exp(-(airExtinction()[i] * air + kOzone[i] * ozone + dust));
    return out;
}

Atmosphere::View::View(const Atmosphere& atmosphere, double height, double elevation)
    : m_atmosphere(atmosphere), m_way(height, std::sin(elevation)), m_height(height), m_elevation(elevation) {
    static const Quadrature rule(24);
    const double start = m_way.start(), end = m_way.end();
    m_fromEnd = atmosphere.transmittance(m_way.between(start, end));
    // Places are dense where the way is low: each part of it rises or falls all along.
    const auto addPart = [&](double low, double high) {
        for (const QuadraturePoint& point : rule.points)
            m_places.push_back(placeAt(low + (high - low) * std::pow(point.x, 3),
                                       std::abs(high - low) * 3 * point.x * point.x * point.weight));
    };
    if (start < 0) addPart(std::min(end, 0.0), start);
    if (end > 0) addPart(std::max(start, 0.0), end);
    for (const Place& place : m_places)
        for (std::size_t i = 0; i < m_scattered.size(); ++i) m_scattered[i] += place.air[i] + place.dust[i];
    // In air that is dense within a step the sum may exceed what the air takes, and the series of fillAgain diverge.
    for (std::size_t i = 0; i < m_scattered.size(); ++i) m_scattered[i] = std::min(m_scattered[i], 1 - m_fromEnd[i]);
}

Atmosphere::View::Place Atmosphere::View::placeAt(double s, double length) const {
    Place place{s - m_way.start(), std::max(m_way.heightAt(s), 0.0), {}, {}};
    const double air = length * m_atmosphere.m_content.air * std::exp(-place.height / kAirScale);
    const double dust = length * m_atmosphere.m_content.dust * kDustScattering * std::exp(-place.height / kDustScale);
    const Spectrum left = m_atmosphere.transmittance(m_way.between(m_way.start(), s));
    for (std::size_t i = 0; i < left.size(); ++i) {
        place.air[i] = left[i] * air * airExtinction()[i];
        place.dust[i] = left[i] * dust;
    }
    return place;
}

Atmosphere::Sent Atmosphere::View::under(double sunElevation, double azimuth) const {
    const double sunUp = std::sin(sunElevation), sunAcross = std::cos(sunElevation) * std::cos(azimuth);
    const double radius = kEarthRadius + m_height;
    // The cosine between the sun and the vertical of a place on the way, which the Earth's curvature turns.
    const auto cosineAt = [&](double along) {
        const double up = radius + along * std::sin(m_elevation), across = along * std::cos(m_elevation);
        return (up * sunUp + across * sunAcross) / std::hypot(up, across);
    };
    Sent sent;
    for (const Place& place : m_places) {
        const double cosine = cosineAt(place.along);
        const Spectrum again = m_atmosphere.m_again.at(place.height, cosine);
        for (std::size_t i = 0; i < again.size(); ++i) sent.rest[i] += (place.air[i] + place.dust[i]) * again[i];
        const AirWay toSun(place.height, cosine);
        if (toSun.meetsGround()) continue;
        const Spectrum light = m_atmosphere.transmittance(toSun.toSpace());
        for (std::size_t i = 0; i < light.size(); ++i) {
            sent.air[i] += place.air[i] * light[i];
            sent.dust[i] += place.dust[i] * light[i];
        }
    }
    if (!m_way.meetsGround()) return sent;
    const Spectrum ground = m_atmosphere.m_onGround.at(0, cosineAt(m_way.end() - m_way.start()));
    for (std::size_t i = 0; i < ground.size(); ++i)
        sent.rest[i] += m_fromEnd[i] * ground[i] * m_atmosphere.m_content.groundAlbedo / kPi;
    return sent;
}

Atmosphere::Table::Table(int heights) : m_heights(heights), m_values(inTable(heights, 0)) {}

double Atmosphere::Table::heightOf(int i) {
    return kHighest * i * i / ((kHeights - 1) * (kHeights - 1));
}

double Atmosphere::Table::cosineOf(int j) {
    const double x = kLowestSun + (1 - kLowestSun) * j / (kSuns - 1);
    return x * std::abs(x);
}

Spectrum& Atmosphere::Table::value(int height, int sun) {
    return m_values[inTable(height, sun)];
}

Spectrum Atmosphere::Table::at(double height, double cosine) const {
    const double row = std::min(std::sqrt(height / kHighest) * (kHeights - 1), double(m_heights - 1));
    const double x = std::copysign(std::sqrt(std::abs(cosine)), cosine);
    const double column = std::clamp((x - kLowestSun) / (1 - kLowestSun) * (kSuns - 1), 0.0, double(kSuns - 1));
    const int i = std::max(std::min(static_cast<int>(row), m_heights - 2), 0),
              j = std::min(static_cast<int>(column), kSuns - 2);
    Spectrum out{};
    for (const int di : {0, 1})
        for (const int dj : {0, 1}) {
            const double weight = (di == 0 ? 1 - row + i : row - i) * (dj == 0 ? 1 - column + j : column - j);
            if (weight == 0) continue;
            const Spectrum& corner = m_values[inTable(i + di, j + dj)];
            for (std::size_t k = 0; k < out.size(); ++k) out[k] += weight * corner[k];
        }
    return out;
}

Atmosphere::Atmosphere(const AirContent& content) : m_content(content), m_again(kHeights), m_onGround(1) {
    // While the light that scatters again is summed, the ground has the sun's light alone, and nothing scatters again.
    for (int j = 0; j < kSuns; ++j) {
        const double cosine = Table::cosineOf(j);
        if (cosine <= 0) continue;
        m_onGround.value(0, j) = transmittance(AirWay(0, cosine).toSpace());
        for (double& light : m_onGround.value(0, j)) light *= cosine;
    }
    Table again(kHeights);
    parallelFor(kHeights, [&](std::size_t i) { fillAgain(static_cast<int>(i), again); });
    m_again = std::move(again);
    Table sky(1);
    parallelFor(kSuns, [&](std::size_t j) {
        sky.value(0, static_cast<int>(j)) = skyOnGround(Table::cosineOf(static_cast<int>(j)));
    });
    for (int j = 0; j < kSuns; ++j)
        for (std::size_t k = 0; k < kWavelengths; ++k) m_onGround.value(0, j)[k] += sky.value(0, j)[k];
}

// Hillaire's second order, of evenly scattered light, and the sum of a geometric series for all further ones.
void Atmosphere::fillAgain(int height, Table& again) const {
    static const Quadrature rule(12);
    constexpr int kAzimuths = 2;
    std::vector<View> views;
    std::vector<double> weights;
    Spectrum further{};
    for (const QuadraturePoint& point : rule.points) {
        const View& view = views.emplace_back(*this, Table::heightOf(height), std::asin(2 * point.x - 1));
        weights.push_back(point.weight);
        for (std::size_t k = 0; k < further.size(); ++k) further[k] += point.weight * view.scattered()[k];
    }
    for (int j = 0; j < kSuns; ++j) {
        Spectrum& sum = again.value(height, j);
        for (std::size_t v = 0; v < views.size(); ++v)
            for (int a = 0; a < kAzimuths; ++a) {
                const Sent sent = views[v].under(std::asin(Table::cosineOf(j)), kPi * (a + 0.5) / kAzimuths);
                for (std::size_t k = 0; k < sum.size(); ++k)
                    sum[k] += weights[v] / kAzimuths * ((sent.air[k] + sent.dust[k]) / (4 * kPi) + sent.rest[k]);
            }
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] /= 1 - further[k];
    }
}

Spectrum Atmosphere::onGround(double cosine) const {
    return m_onGround.at(0, cosine);
}

Spectrum Atmosphere::skyOnGround(double cosine) const {
    static const Quadrature rule(8);
    constexpr int kAzimuths = 8;
    const double sun = std::asin(cosine);
    Spectrum sum{};
    for (const QuadraturePoint& point : rule.points) {
        const double elevation = std::asin(point.x);
        const View view(*this, 0, elevation);
        for (int i = 0; i < kAzimuths; ++i) {
            const double azimuth = kPi * (i + 0.5) / kAzimuths;
            const Sent sent = view.under(sun, azimuth);
            const double toSun = point.x * cosine + std::cos(elevation) * std::cos(sun) * std::cos(azimuth);
            const double weight = 2 * kPi / kAzimuths * point.weight * point.x;
            for (std::size_t k = 0; k < sum.size(); ++k)
                sum[k] += weight * (airPhase(toSun) * sent.air[k] + dustPhase(toSun) * sent.dust[k] + sent.rest[k]);
        }
    }
    return sum;
}

double airPhase(double cosine) {
    return 3 / (16 * kPi) * (1 + cosine * cosine);
}

double dustPhase(double cosine) {
    constexpr double g = 0.76, g2 = g * g;
    return 3 * (1 - g2) / (8 * kPi * (2 + g2)) * (1 + cosine * cosine) / std::pow(1 + g2 - 2 * g * cosine, 1.5);
}

}  // namespace scrim
