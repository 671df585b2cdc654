// SPDX-License-Identifier: Apache-2.0
// The clear air: closed forms of exponential columns, and sums in fine steps that share nothing with the quadrature.
#include <scrim/image/atmosphere.h>

#include <scrim/geometry/spaces.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi, kDegree = kPi / 180;
constexpr std::size_t kBlue = 3, kGreen = 8, kRed = 13;  // 440, 540 and 640 nm

double ozoneAt(double height) {
    if (height < 10 || height > 40) return 0;
    return height < 25 ? (height - 10) / 15 : (40 - height) / 15;
}

// What a straight way of `length` holds, by `steps` even steps in a plane through the Earth's centre.
AirColumn walk(double height, double cosine, double length, int steps) {
    AirColumn sum;
    const double step = length / steps, start = kEarthRadius + height, sine = std::sqrt(1 - cosine * cosine);
    for (int i = 0; i < steps; ++i) {
        const double t = (i + 0.5) * step, h = std::hypot(start + t * cosine, t * sine) - kEarthRadius;
        sum.air += step * std::exp(-h / kAirScale);
        sum.dust += step * std::exp(-h / kDustScale);
        sum.ozone += step * ozoneAt(h);
    }
    return sum;
}

void expectColumn(const AirColumn& seen, const AirColumn& truth, double part) {
    EXPECT_NEAR(seen.air, truth.air, part * truth.air);
    EXPECT_NEAR(seen.dust, truth.dust, part * truth.dust + 1e-9);
    EXPECT_NEAR(seen.ozone, truth.ozone, part * truth.ozone + 1e-9);
}

TEST(AirWay, HoldsTheScaleHeightAtTheZenith) {
    for (const double height : {0.0, 2.0, 12.0}) {
        const AirColumn up = AirWay(height, 1).toSpace();
        EXPECT_NEAR(up.air, kAirScale * std::exp(-height / kAirScale), 1e-6 * kAirScale) << height;
        EXPECT_NEAR(up.dust, kDustScale * std::exp(-height / kDustScale), 1e-6 * kDustScale) << height;
        EXPECT_NEAR(up.ozone, height < 10 ? 15 : 15 - 0.5 * 4 / 15, 1e-6) << height;  // a triangle of 30 km
    }
}

TEST(AirWay, AgreesWithFineStepsOnSlantedWays) {
    for (const double height : {0.0, 3.0})
        for (const double cosine : {0.7, 0.1, 0.01, 0.0})
            expectColumn(AirWay(height, cosine).toSpace(), walk(height, cosine, 2500, 400000), 3e-5);
    // Down past the Earth and up again, and between two places of such a way.
    const double height = 30, cosine = -0.09;
    const AirWay past(height, cosine);
    ASSERT_FALSE(past.meetsGround());
    expectColumn(past.toSpace(), walk(height, cosine, 3500, 700000), 3e-5);
    const double from = past.start(), low = past.heightAt(0);
    expectColumn(past.between(from, from + 400), walk(height, cosine, 400, 400000), 1e-4);
    expectColumn(past.between(0, 300), walk(low, 0, 300, 400000), 1e-4);
}

TEST(AirWay, EndsAtTheGroundOrWhereTheAirEnds) {
    EXPECT_NEAR(AirWay(2, -1).end() - AirWay(2, -1).start(), 2, 1e-9);
    EXPECT_NEAR(AirWay(0, 1).end() - AirWay(0, 1).start(), kTopOfAir, 1e-9);
    EXPECT_TRUE(AirWay(1, -0.02).meetsGround());
    EXPECT_FALSE(AirWay(1, -0.01).meetsGround());  // the horizon is 1.015 degrees below the horizontal
    EXPECT_FALSE(AirWay(0, 0).meetsGround());
}

// Extinction per km at the sea, from the sources that the header names.
double airAt(double micrometres) {
    const double w2 = 1 / (micrometres * micrometres);
    return 0.008569 * w2 * w2 * (1 + 0.0113 * w2 + 0.00013 * w2 * w2) / kAirScale;
}
constexpr double kOzoneAt540 = 29.2e-26 * 300 * 2.687e20 / 15e3 * 1e3, kDustAll = 0.02 / 0.9;

TEST(Atmosphere, LetsTheSunThroughAsFineStepsDo) {
    const Atmosphere clear({1, 1, 1}), dusty({0.5, 4, 0});
    for (const double elevation : {90.0, 30.0, 5.0, 0.0}) {
        const double cosine = std::sin(elevation * kDegree);
        const AirColumn c = walk(0, cosine, 2500, 400000);
        const AirColumn own = AirWay(0, cosine).toSpace();
        EXPECT_NEAR(clear.transmittance(own)[kGreen] /
                        std::exp(-airAt(0.54) * c.air - kDustAll * c.dust - kOzoneAt540 * c.ozone),
                    1, 1e-3)
            << elevation;
        EXPECT_NEAR(dusty.transmittance(own)[kRed] / std::exp(-0.5 * airAt(0.64) * c.air - 4 * kDustAll * c.dust), 1,
                    1e-3)
            << elevation;
    }
    EXPECT_NEAR(clear.transmittance({})[0], 1, 0);
}

// The same integral, in even steps along a ray, each of which looks at the sun.
TEST(Atmosphere, ScattersLightOnceAsFineStepsDo) {
    const Atmosphere clear({1, 1, 1});
    for (const double sun : {60.0, 5.0, -3.0})
        for (const double elevation : {80.0, 20.0, 2.0}) {
            const double azimuth = 0.7, height = 0.5, length = 1200;
            constexpr int kSteps = 60000;
            double air = 0, dust = 0;
            for (int i = 0; i < kSteps; ++i) {
                const double t = (i + 0.5) * length / kSteps, e = elevation * kDegree, s = sun * kDegree;
                const double up = kEarthRadius + height + t * std::sin(e), across = t * std::cos(e),
                             radius = std::hypot(up, across);
                const AirWay toSun(radius - kEarthRadius,
                                   (up * std::sin(s) + across * std::cos(s) * std::cos(azimuth)) / radius);
                if (toSun.meetsGround() || radius > kEarthRadius + kTopOfAir) continue;
                const AirWay way(height, std::sin(e));
                const double left = clear.transmittance(way.between(way.start(), way.start() + t))[kGreen] *
                                    clear.transmittance(toSun.toSpace())[kGreen] * length / kSteps;
                air += left * airAt(0.54) * std::exp((kEarthRadius - radius) / kAirScale);
                dust += left * 0.02 * std::exp((kEarthRadius - radius) / kDustScale);
            }
            const Atmosphere::View view(clear, height, elevation * kDegree);
            const Atmosphere::Sent sent = view.under(sun * kDegree, azimuth);
            EXPECT_NEAR(sent.air[kGreen] / air, 1, 2e-3) << sun << " " << elevation;
            EXPECT_NEAR(sent.dust[kGreen], dust, 2e-3 * dust + 1e-6) << sun << " " << elevation;
        }
}

TEST(Atmosphere, ShowsTheGroundThroughTheAirBeforeIt) {
    const Atmosphere none({0, 0, 0, 0.5}), thin({1e-3, 0, 0, 0.5});
    const double sun = 40 * kDegree;
    const Atmosphere::View bare(none, 5, -90 * kDegree), veiled(thin, 5, -90 * kDegree);
    EXPECT_NEAR(bare.under(sun, 0).rest[kBlue], 0.5 * std::sin(sun) / kPi, 1e-3);
    const AirWay way(5, -1);
    const double through = thin.transmittance(way.between(way.start(), way.end()))[kBlue];
    EXPECT_NEAR(veiled.under(sun, 0).rest[kBlue] / (0.5 * thin.onGround(std::sin(sun))[kBlue] / kPi * through), 1,
                1e-3);
    EXPECT_NEAR(thin.onGround(std::sin(sun))[kBlue], std::sin(sun),
                1e-3);  // a sky takes half from the sun, and gives it
    EXPECT_EQ(bare.under(-10 * kDegree, 0).rest[kBlue], 0);
    EXPECT_EQ(Atmosphere::View(none, 5, 0.1).under(sun, 0).rest[kBlue], 0);
}

TEST(Atmosphere, LightsTheGroundByItsSkyAndTheSun) {
    const Atmosphere clear({1, 1, 1, 0.2});
    for (const double sun : {70.0, 10.0}) {
        double sum = 0;
        constexpr int kRows = 60, kColumns = 60;
        for (int y = 0; y < kRows; ++y) {
            const double sine = (y + 0.5) / kRows, elevation = std::asin(sine);
            const Atmosphere::View view(clear, 0, elevation);
            for (int x = 0; x < kColumns; ++x) {
                const double azimuth = kPi * (x + 0.5) / kColumns;
                const Atmosphere::Sent sent = view.under(sun * kDegree, azimuth);
                const double cosine =
                    sine * std::sin(sun * kDegree) + std::cos(elevation) * std::cos(sun * kDegree) * std::cos(azimuth);
                sum += sine *
                       (airPhase(cosine) * sent.air[kBlue] + dustPhase(cosine) * sent.dust[kBlue] + sent.rest[kBlue]);
            }
        }
        const double up = std::sin(sun * kDegree);
        const double direct = up * clear.transmittance(AirWay(0, up).toSpace())[kBlue];
        EXPECT_NEAR(clear.onGround(up)[kBlue] / (direct + sum * 2 * kPi / (kRows * kColumns)), 1, 0.01) << sun;
    }
}

// Light that scatters any number of times, and from the ground, by random walks from the eye: at each place that
// scatters, the sun's part. Directions are drawn evenly, and collisions by the densest air.
class Walks {
  public:
    Walks(const Atmosphere& atmosphere, double albedo, double sun)
        : m_atmosphere(atmosphere), m_albedo(albedo), m_toSun(std::cos(sun), 0, std::sin(sun)) {}

    double mean(double elevation, double azimuth, int count) {
        const Vec3 way(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                       std::sin(elevation));
        double sum = 0;
        for (int i = 0; i < count; ++i) sum += one({0, 0, kEarthRadius + 1e-6}, way);
        return sum / count;
    }

  private:
    static constexpr double kAir = 0.013104, kMost = 0.0361;  // per km, at 540 nm; of all, at the sea and above
    double lot() { return m_lots(m_random); }
    double sunAt(const Vec3& at) const {
        const double radius = glm::length(at);
        const AirWay way(radius - kEarthRadius, glm::dot(at, m_toSun) / radius);
        return way.meetsGround() ? 0 : m_atmosphere.transmittance(way.toSpace())[kGreen];
    }
    Vec3 anyDirection() {
        const double z = 2 * lot() - 1, turn = 2 * kPi * lot(), r = std::sqrt(1 - z * z);
        return {r * std::cos(turn), r * std::sin(turn), z};
    }
    double one(Vec3 at, Vec3 way) {
        double sum = 0, weight = 1;
        for (;;) {
            at += way * (-std::log(1 - lot()) / kMost);
            const double height = glm::length(at) - kEarthRadius;
            if (height < 0) {
                const double b = glm::dot(at, way), c = glm::dot(at, at) - kEarthRadius * kEarthRadius;
                at += way * (-b - std::sqrt(b * b - c));  // back to the ground
                at *= (kEarthRadius + 1e-6) / glm::length(at);
                const Vec3 up = glm::normalize(at);
                weight *= m_albedo;
                sum += weight * sunAt(at) * std::max(glm::dot(up, m_toSun), 0.0) / kPi;
                way = glm::normalize(up + anyDirection());
                if (weight < 1e-3) return sum;
                continue;
            }
            if (height > kTopOfAir) return sum;
            const double air = kAir * std::exp(-height / kAirScale), dust = 0.02 * std::exp(-height / kDustScale);
            double kind = lot() * kMost - air;
            if (kind < 0) {
                step(sum, weight, at, way, airPhase);
            } else if ((kind -= dust) < 0) {
                step(sum, weight, at, way, dustPhase);
            } else if (kind < dust / 9 + kOzoneAt540 * ozoneAt(height)) {
                return sum;
            }
        }
    }
    void step(double& sum, double& weight, const Vec3& at, Vec3& way, double (*phase)(double)) {
        sum += weight * sunAt(at) * phase(glm::dot(way, m_toSun));
        const Vec3 next = anyDirection();
        weight *= 4 * kPi * phase(glm::dot(way, next));
        way = next;
    }

    const Atmosphere& m_atmosphere;
    double m_albedo;
    Vec3 m_toSun;
    std::mt19937_64 m_random{7};
    std::uniform_real_distribution<double> m_lots;
};

TEST(Atmosphere, ScattersAgainAsRandomWalksDo) {
    const Atmosphere clear({1, 1, 1, 0.3});
    EXPECT_NEAR(airAt(0.54), 0.013104, 1e-6);
    for (const double sun : {60.0, 10.0})
        for (const double elevation : {80.0, 20.0}) {
            const double s = sun * kDegree, e = elevation * kDegree, azimuth = 2;
            const double truth = Walks(clear, 0.3, s).mean(e, azimuth, 400000);
            const Atmosphere::Sent sent = Atmosphere::View(clear, 0, e).under(s, azimuth);
            const double cosine = std::sin(e) * std::sin(s) + std::cos(e) * std::cos(s) * std::cos(azimuth);
            const double once = airPhase(cosine) * sent.air[kGreen] + dustPhase(cosine) * sent.dust[kGreen];
            EXPECT_NEAR((once + sent.rest[kGreen]) / truth, 1, 0.1) << sun << " " << elevation;
            EXPECT_LT(once / truth, 0.85);
        }
}

TEST(Atmosphere, PhaseFunctionsIntegrateToOne) {
    double air = 0, dust = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
        const double cosine = 2 * (i + 0.5) / kSteps - 1;
        air += airPhase(cosine) * 4 * kPi / kSteps;
        dust += dustPhase(cosine) * 4 * kPi / kSteps;
    }
    EXPECT_NEAR(air, 1, 1e-6);
    EXPECT_NEAR(dust, 1, 1e-6);
}

}  // namespace
}  // namespace scrim::test
