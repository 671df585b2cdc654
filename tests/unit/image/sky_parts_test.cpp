// SPDX-License-Identifier: Apache-2.0
// The suns in pictures of skies: found where they are, with their light and size, and nothing else is.
#include "support/slides.h"

#include <scrim/image/sky_parts.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kWidth = 1024, kHeight = 512;

Vec3 toward(double u, double v) {
    return {std::sin(kPi * v) * std::cos(2 * kPi * u), std::sin(kPi * v) * std::sin(2 * kPi * u), std::cos(kPi * v)};
}

// A disk of `angle` degrees around (u, v), its border smoothed over a pixel by 4 x 4 points.
struct Disk {
    double u, v, angle, radiance;
};
std::shared_ptr<const Texture> sky(const std::vector<Disk>& disks) {
    return makeTexture(kWidth, kHeight, [&](int x, int y) {
        double value = 1 + 0.5 * std::cos(kPi * (y + 0.5) / kHeight);
        for (const Disk& disk : disks)
            for (int k = 0; k < 16; ++k) {
                const Vec3 at = toward((x + (k % 4 + 0.5) / 4) / kWidth, (y + (k / 4 + 0.5) / 4) / kHeight);
                if (glm::dot(at, toward(disk.u, disk.v)) > std::cos(disk.angle * kPi / 360))
                    value += disk.radiance / 16;
            }
        return Rgb(value, 0.5 * value, 0.25 * value);
    });
}
Rgb integral(const Texture& picture) {
    const Texture::Level& level = picture.levels().front();
    Rgb sum(0);
    for (int y = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x) {
            const float* p = level.pixel(x, y);
            sum +=
                Rgb(p[0], p[1], p[2]) *
                (2 * kPi / level.width * (std::cos(kPi * y / level.height) - std::cos(kPi * (y + 1) / level.height)));
        }
    return sum;
}

TEST(SkyParts, AreTheSunAndTheRestAndLoseNoLight) {
    for (const Disk& disk :
         {Disk{0.3, 0.2, 0.53, 2e5}, Disk{0.999, 0.4, 0.53, 2e5}, Disk{0.6, 0.002, 2, 1e4}, Disk{0.1, 0.7, 4, 4e3}}) {
        const auto picture = sky({disk});
        const SkyParts parts = skyParts(*picture);
        ASSERT_EQ(parts.suns.size(), 1u) << disk.u;
        const SkySun& sun = parts.suns[0];
        const double pixel = 360.0 / kWidth;
        EXPECT_LT(std::acos(std::min(glm::dot(toward(sun.u, sun.v), toward(disk.u, disk.v)), 1.0)) * 180 / kPi,
                  0.2 * pixel);
        EXPECT_NEAR(sun.angle, disk.angle, 0.7 * pixel);
        const Rgb all = integral(*picture);
        Rgb sum = sun.light;
        sum += integral(*parts.smooth);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], all[c], 1e-5 * all[c]);
        // What is left is the sky without it: a gradient.
        const Texture::Level& level = parts.smooth->levels().front();
        for (int y = 0; y < kHeight; y += 3)
            for (int x = 0; x < kWidth; x += 3)
                EXPECT_NEAR(level.pixel(x, y)[0], 1 + 0.5 * std::cos(kPi * (y + 0.5) / kHeight), 0.05);
    }
}

TEST(SkyParts, FindNoneWhereNothingIsSmallAndBright) {
    EXPECT_TRUE(skyParts(*sky({})).suns.empty());
    EXPECT_TRUE(skyParts(*sky({{0.3, 0.2, 30, 500}})).suns.empty());    // a window
    EXPECT_TRUE(skyParts(*sky({{0.3, 0.2, 0.53, 100}})).suns.empty());  // too little light
    EXPECT_EQ(skyParts(*sky({})).smooth, nullptr);
    EXPECT_TRUE(skyParts(*makeTexture(8, 4, [](int, int) { return Rgb(0); })).suns.empty());
    EXPECT_TRUE(skyParts(*makeTexture(1, 1, [](int, int) { return Rgb(1); })).suns.empty());
}

TEST(SkyParts, FindTheSunWithinItsGlow) {
    const auto picture = makeTexture(kWidth, kHeight, [&](int x, int y) {
        const double cosine = glm::dot(toward((x + 0.5) / kWidth, (y + 0.5) / kHeight), toward(0.4, 0.3));
        const double degrees = std::acos(std::min(cosine, 1.0)) * 180 / kPi;
        return Rgb(1 + 300 * std::exp(-degrees / 4) + (degrees < 0.6 ? 1e5 : 0));
    });
    const SkyParts parts = skyParts(*picture);
    ASSERT_EQ(parts.suns.size(), 1u);
    EXPECT_NEAR(parts.suns[0].u, 0.4, 1.0 / kWidth);
    EXPECT_NEAR(parts.suns[0].v, 0.3, 1.0 / kHeight);
    EXPECT_NEAR(parts.suns[0].angle, 1.2, 0.3);
}

TEST(SkyParts, AreAtMostEightOfTheBrightest) {
    std::vector<Disk> lamps;
    for (int i = 0; i < 12; ++i) lamps.push_back({(i + 0.5) / 12, 0.5, 1, 1e4 * (1 + i)});
    const SkyParts parts = skyParts(*sky(lamps));
    ASSERT_EQ(parts.suns.size(), 8u);
    for (int i = 0; i < 8; ++i) EXPECT_NEAR(parts.suns[std::size_t(i)].u, (11 - i + 0.5) / 12, 1.0 / kWidth);
}

}  // namespace
}  // namespace scrim::test
