// SPDX-License-Identifier: Apache-2.0
// The picture of a clear sky: its symmetry, its energy and its sun against sums that are finer, and its colours.
#include <scrim/image/clear_sky.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include <glm/common.hpp>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi, kDegree = kPi / 180;

const ColourConfig& colour() {
    static const ColourConfig config = [] {
        ::unsetenv("OCIO");
        return ColourConfig::open("");
    }();
    return config;
}

ClearSky at(double elevation) {
    ClearSky sky;
    sky.sunElevation = elevation;
    return sky;
}

// The mean over pixels around an elevation, at an azimuth from the sun; degrees.
Rgb seen(const Texture& picture, double elevation, double azimuth) {
    const Texture::Level& level = picture.levels().front();
    const double u = 0.5 + azimuth / 360, v = 0.5 - elevation / 180;
    const float* p = level.pixel(static_cast<int>(u * level.width) % level.width, static_cast<int>(v * level.height));
    return {p[0], p[1], p[2]};
}

TEST(ClearSky, IsEqualOnBothSidesOfTheSun) {
    const SkyPicture sky = skyPicture(at(20), colour());
    const Texture::Level& level = sky.image->levels().front();
    for (int y = 0; y < level.height; y += 7)
        for (int x = 0; x < level.width / 2; x += 5)
            for (int c = 0; c < 3; ++c) EXPECT_EQ(level.pixel(x, y)[c], level.pixel(level.width - 1 - x, y)[c]) << x;
}

// Light on level ground, by the picture and by rays that are closer along the azimuth and even in the sine of
// elevation.
TEST(ClearSky, LightsTheGroundAsAFinerIntegralDoes) {
    const SunColours colours(colour());
    const Atmosphere air({1, 1, 1, 0.2});
    for (const double elevation : {60.0, 8.0}) {
        const SkyPicture sky = skyPicture(at(elevation), colour());
        const Texture::Level& level = sky.image->levels().front();
        Rgb picture(0);
        for (int y = 0; y < level.height / 2; ++y) {
            const double low = std::cos(kPi * (y + 1) / level.height), high = std::cos(kPi * y / level.height);
            const double weight = kPi / level.width * (high * high - low * low);  // solid angle times cosine
            for (int x = 0; x < level.width; ++x) {
                const float* p = level.pixel(x, y);
                picture += weight * Rgb(p[0], p[1], p[2]);
            }
        }
        Rgb fine(0);
        constexpr int kRows = 300, kColumns = 100;
        const double sun = elevation * kDegree;
        for (int y = 0; y < kRows; ++y) {
            const double sine = (y + 0.5) / kRows, e = std::asin(sine);
            const Atmosphere::View view(air, 0, e);
            for (int x = 0; x < kColumns; ++x) {
                const double azimuth = kPi * (x + 0.5) / kColumns;
                const double cosine = sine * std::sin(sun) + std::cos(e) * std::cos(sun) * std::cos(azimuth);
                const Atmosphere::Sent sent = view.under(sun, azimuth);
                fine += sine * (airPhase(cosine) * colours(sent.air) + dustPhase(cosine) * colours(sent.dust) +
                                colours(sent.rest));
            }
        }
        fine *= 2 * kPi / (kRows * kColumns);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(picture[c] / fine[c], 1, 2e-3) << elevation << " " << c;
    }
}

TEST(ClearSky, HoldsTheSunWithTheIrradianceThatTheAirLeaves) {
    const SunColours colours(colour());
    const Atmosphere air({1, 1, 1, 0.2});
    for (const double elevation : {90.0, 30.0, 5.0})
        for (const double size : {0.545, 3.0}) {
            ClearSky sky = at(elevation);
            sky.sunSize = size;
            const SkyPicture picture = skyPicture(sky, colour());
            ASSERT_EQ(picture.parts->suns.size(), 1u);
            const SkySun& sun = picture.parts->suns.front();
            const Rgb direct = colours(air.transmittance(AirWay(0, std::sin(elevation * kDegree)).toSpace()));
            // The air changes over a wide sun that is low, which moves the mean by its second derivative.
            const double allowed = size > 1 && elevation < 10 ? 0.02 : 1e-3;
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(sun.light[c] / direct[c], 1, allowed) << elevation << " " << size;
            EXPECT_EQ(sun.angle, size);
            EXPECT_NEAR(sun.v, 0.5 - elevation / 180, 1e-12);
            EXPECT_EQ(sun.u, 0.5);
            const double solidAngle = 2 * kPi * (1 - std::cos(0.5 * size * kDegree));
            EXPECT_NEAR(sun.rows[sun.rows.size() / 2].y * solidAngle / direct.y, 1, 1e-3);
            EXPECT_EQ(picture.parts->smooth, picture.image);
        }
}

// The solar constant in lux is 128 to 134 thousand, by source; white becomes about equal parts.
TEST(ClearSky, IsInUnitsOfAWhiteCardInFullSun) {
    Spectrum all{};
    all.fill(1);
    const Rgb space = SunColours(colour())(all);
    const double lux = (0.2722287 * space.x + 0.6740818 * space.y + 0.0536895 * space.z) / kPi * kLuxOfPi;
    EXPECT_GT(lux, 126e3);
    EXPECT_LT(lux, 136e3);
    const SkyPicture noon = skyPicture(at(60), colour());
    const double card = noon.parts->suns.front().light.y / kPi;
    EXPECT_GT(card, 0.9);
    EXPECT_LT(card, 1.3);
    const Rgb blue = seen(*noon.image, 60, 180);
    EXPECT_GT(blue.y, 0.03);
    EXPECT_LT(blue.y, 0.2);
}

TEST(ClearSky, IsBlueAboveAndRedAroundASettingSun) {
    const SkyPicture day = skyPicture(at(40), colour()), evening = skyPicture(at(1), colour());
    const Rgb above = seen(*day.image, 80, 180), low = seen(*evening.image, 1, 4),
              behind = seen(*evening.image, 60, 180);
    EXPECT_GT(above.z, 2 * above.x);
    EXPECT_GT(low.x, 2 * low.z);
    EXPECT_GT(behind.z, behind.x);  // ozone keeps it blue
    const Rgb sun = evening.parts->suns.front().light, noon = day.parts->suns.front().light;
    EXPECT_GT(sun.x, 4 * sun.z);
    EXPECT_LT(noon.x, 1.4 * noon.z);
    ClearSky thin = at(1);
    thin.ozoneDensity = 0;
    const Rgb without = seen(*skyPicture(thin, colour()).image, 60, 180);
    EXPECT_LT(without.z / without.x, 0.8 * behind.z / behind.x);
}

TEST(ClearSky, FollowsItsNumbers) {
    const SkyPicture clear = skyPicture(at(20), colour());
    ClearSky sky = at(20);
    sky.sunIntensity = 3;
    const SkyPicture bright = skyPicture(sky, colour());
    EXPECT_NEAR(bright.parts->suns.front().light.y / clear.parts->suns.front().light.y, 3, 1e-12);
    EXPECT_EQ(seen(*bright.image, 30, 40), seen(*clear.image, 30, 40));
    sky.sunDisc = false;
    EXPECT_TRUE(skyPicture(sky, colour()).parts->suns.empty());
    sky = at(20);
    sky.airDensity = sky.dustDensity = sky.ozoneDensity = 0;
    const SkyPicture black = skyPicture(sky, colour());
    EXPECT_EQ(seen(*black.image, 30, 40), Rgb(0));
    EXPECT_GT(black.parts->suns.front().light.y, clear.parts->suns.front().light.y);
    EXPECT_GT(seen(*black.image, -30, 40).y, 0.02);  // the ground
    sky.groundAlbedo = 0;
    EXPECT_EQ(seen(*skyPicture(sky, colour()).image, -30, 40), Rgb(0));
    sky = at(20);
    sky.altitude = 10000;
    EXPECT_LT(seen(*skyPicture(sky, colour()).image, 60, 90).y, 0.6 * seen(*clear.image, 60, 90).y);
    sky.dustDensity = 5;
    sky.altitude = 0;
    EXPECT_GT(seen(*skyPicture(sky, colour()).image, 20, 5).y, 2 * seen(*clear.image, 20, 5).y);
}

// As much of everything as the keys allow; no light comes from nowhere.
TEST(ClearSky, IsFiniteInTheThickestAir) {
    for (const double elevation : {90.0, 1.0, -90.0})
        for (const double altitude : {0.0, 60000.0}) {
            const SkyPicture sky = skyPicture({elevation, altitude, 10, 10, 10, 1}, colour());
            const Texture::Level& mean = sky.image->levels().back();
            EXPECT_GE(mean.pixel(0, 0)[1], 0) << elevation << " " << altitude;
            EXPECT_LT(mean.pixel(0, 0)[1], 3) << elevation << " " << altitude;
        }
    for (const double cosine : {1.0, 0.3, 0.0, -0.2}) {
        const Spectrum light = Atmosphere({10, 10, 10, 1}).onGround(cosine);
        for (const double part : light) {
            EXPECT_GE(part, 0) << cosine;
            EXPECT_LE(part, 1) << cosine;
        }
    }
}

TEST(ClearSky, SetsItsSunAtTheHorizon) {
    const double whole = skyPicture(at(0.4), colour()).parts->suns.front().light.x;
    const double half = skyPicture(at(0), colour()).parts->suns.front().light.x;
    EXPECT_GT(half, 0);
    EXPECT_LT(half, 0.5 * whole);
    EXPECT_TRUE(skyPicture(at(-0.4), colour()).parts->suns.empty());
    const SkyPicture dusk = skyPicture(at(-4), colour());
    EXPECT_TRUE(dusk.parts->suns.empty());
    EXPECT_GT(seen(*dusk.image, 5, 0).x, 1e-4);
}

}  // namespace
}  // namespace scrim::test
