// SPDX-License-Identifier: Apache-2.0
// Photometric files: what they say, and what is wrong with bad ones.
#include "support/luminaires.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace scrim::test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// The direction at these angles, degrees, in the frame of the light.
Vec3 towards(double vertical, double horizontal) {
    const double v = vertical * kDegree, h = horizontal * kDegree;
    return {std::sin(v) * std::sin(h), -std::sin(v) * std::cos(h), std::cos(v)};
}

/// A file of these angles; candela values are those of `candelas`, or else 1, 2, 3, ...
std::string fileWith(const std::vector<double>& vertical, const std::vector<double>& horizontal,
                     std::vector<double> candelas = {}, const std::string& tilt = "NONE") {
    for (std::size_t i = candelas.size(); i < vertical.size() * horizontal.size(); ++i)
        candelas.push_back(double(i) + 1);
    return fmt::format("IESNA:LM-63-2002\n[TEST] made up\nTILT={}\n1 1000 2 {} {} 1 2 0 0 0\n1 1 50\n{}\n{}\n{}\n",
                       tilt, vertical.size(), horizontal.size(), fmt::join(vertical, " "), fmt::join(horizontal, " "),
                       fmt::join(candelas, " "));
}

std::string problemOf(const std::string& text) {
    return parsePhotometry(text, "lamp.ies").problem;
}

// Straight lines between angles 5 degrees apart are at most (5 degrees)^2 / 8 = 0.001 below a cosine.
TEST(LightProfile, OfTheCosineLawIsACosine) {
    const FilePhotometry file = photometryOf("downlight");
    ASSERT_EQ(file.problem, "");
    const LightProfile profile(file);
    EXPECT_EQ(profile.reach(), 90);
    for (const double v : {0.0, 1.0, 12.5, 33.0, 60.0, 77.3, 89.0})
        for (const double h : {0.0, 90.0, 200.0}) {
            EXPECT_NEAR(profile.at(towards(v, h)), std::cos(v * kDegree), 1e-3) << v << ", " << h;
            EXPECT_EQ(profile.at(towards(180 - v, h)), 0) << v << ", " << h;
        }
}

// At the file's angles, its values; in the middle between four of them, their mean.
TEST(LightProfile, IsBilinearInTheAngles) {
    const FilePhotometry file = parsePhotometry(fileWith({0, 20, 50, 180}, {0, 40, 100, 360}), "lamp.ies");
    ASSERT_EQ(file.problem, "");
    const LightProfile profile(file);
    const double most = 16;
    for (std::size_t h = 0; h < 3; ++h)
        for (std::size_t v = 1; v < 3; ++v)
            EXPECT_NEAR(profile.at(towards(file.vertical[v], file.horizontal[h])), double(4 * h + v + 1) / most, 1e-6);
    EXPECT_NEAR(profile.at(towards(35, 70)), (6 + 7 + 10 + 11) / 4.0 / most, 1e-6);
    EXPECT_NEAR(profile.at(towards(35, 10)), (0.75 * (2 + 3) + 0.25 * (6 + 7)) / 2 / most, 1e-6);
}

TEST(LightProfile, IsMirroredWhereHorizontalAnglesEndEarly) {
    const std::vector<double> v{0, 30, 60};
    const LightProfile quarter(parsePhotometry(fileWith(v, {0, 30, 90}), ""));
    const LightProfile half(parsePhotometry(fileWith(v, {0, 60, 180}), ""));
    const LightProfile side(parsePhotometry(fileWith(v, {90, 200, 270}), ""));
    const LightProfile round(parsePhotometry(fileWith(v, {0}), ""));
    for (const double h : {0.0, 12.0, 30.0, 61.0, 90.0}) {
        const double at = quarter.at(towards(40, h));
        for (const double other : {180 - h, 180 + h, 360 - h})
            EXPECT_NEAR(quarter.at(towards(40, other)), at, 1e-6) << h << ", " << other;
        EXPECT_NEAR(half.at(towards(40, 360 - h)), half.at(towards(40, h)), 1e-6) << h;
        EXPECT_NEAR(side.at(towards(40, h)), side.at(towards(40, 180 - h)), 1e-6) << h;
        EXPECT_NEAR(side.at(towards(40, 360 - h)), side.at(towards(40, 180 + h)), 1e-6) << h;
        EXPECT_NEAR(round.at(towards(40, h)), round.at(towards(40, 0)), 1e-6) << h;
    }
    EXPECT_NEAR(half.at(towards(30, 60)), 5 / 9.0, 1e-6);
    EXPECT_NEAR(side.at(towards(30, 200)), 5 / 9.0, 1e-6);
    EXPECT_LT(half.at(towards(30, 0)), half.at(towards(30, 180)));
}

TEST(LightProfile, EndsWithTheVerticalAnglesOfItsFile) {
    const LightProfile down(parsePhotometry(fileWith({0, 60}, {0}, {1, 1}), ""));
    EXPECT_NEAR(down.at(towards(59.9, 0)), 1, 1e-6);
    EXPECT_EQ(down.at(towards(60.1, 0)), 0);
    EXPECT_EQ(down.reach(), 60);
    const LightProfile up(parsePhotometry(fileWith({90, 180}, {0}, {1, 1}), ""));
    EXPECT_EQ(up.at(towards(89.9, 0)), 0);
    EXPECT_NEAR(up.at(towards(90.1, 0)), 1, 1e-6);
    EXPECT_EQ(up.reach(), 180);
}

// From 300 degrees on to 360, which is 0.
TEST(LightProfile, GoesRoundWhereTheLastAngleIsLeftOut) {
    const LightProfile profile(parsePhotometry(fileWith({0, 90}, {0, 120, 300}, {1, 1, 1, 2, 1, 4}), ""));
    EXPECT_NEAR(profile.at(towards(90, 300)), 1, 1e-6);
    EXPECT_NEAR(profile.at(towards(90, 330)), (4 + 1) / 8.0, 1e-6);
}

// The wall on its right is what the made-up luminaire washes.
TEST(LightProfile, CountsHorizontalAnglesFromBelowTheAxisToItsRight) {
    const LightProfile profile(photometryOf("wall"));
    const auto at = [&](double x, double y, double z) {
        return profile.at(Vec3(x, y, z) / std::sqrt(x * x + y * y + z * z));
    };
    EXPECT_GT(at(0.6, 0, 0.8), 0.9);
    EXPECT_LT(at(-0.6, 0, 0.8), 0.1);
    EXPECT_NEAR(at(0, 0.6, 0.8), at(0, -0.6, 0.8), 1e-3);
    EXPECT_GT(at(0, 0, -1), 0.05);
}

TEST(LightProfile, ReadsAllVersionsOfTheFormat) {
    const FilePhotometry tube = photometryOf("batwing");  // with TILT=INCLUDE
    ASSERT_EQ(tube.problem, "");
    EXPECT_EQ(tube.vertical.size(), 10u);
    EXPECT_EQ(tube.horizontal.size(), 5u);
    const std::string plain = fileWith({0, 45, 90}, {0}, {4, 2, 1});
    const FilePhotometry expected = parsePhotometry(plain, "");
    const auto same = [&](std::string text) {
        const FilePhotometry file = parsePhotometry(text, "lamp.ies");
        EXPECT_EQ(file.problem, "");
        EXPECT_EQ(file.vertical, expected.vertical);
        EXPECT_EQ(file.candela, expected.candela);
    };
    EXPECT_EQ(expected.candela, (std::vector<float>{8, 4, 2}));  // the multiplier is 2
    same(plain.substr(plain.find("[TEST]")));                    // 1986: no version
    std::string commas = plain, dos = plain;
    for (char& c : commas) c = c == ' ' ? ',' : c;
    commas.replace(0, commas.find('\n'), "IESNA91");
    same(commas);
    for (std::size_t at = dos.find('\n'); at != std::string::npos; at = dos.find('\n', at + 2)) dos.insert(at, "\r");
    same(dos + "\x1a");
}

TEST(LightProfile, SaysWhatIsWrongWithAFileAndWhere) {
    EXPECT_EQ(problemOf(""), "lamp.ies:1: the file ends before a line TILT=; expected a photometric file (IES LM-63)");
    EXPECT_EQ(problemOf("TILT=lamp.tlt\n1\n"), "lamp.ies:1: TILT=lamp.tlt; expected NONE or INCLUDE");
    const std::string good = fileWith({0, 90}, {0, 90}, {1, 2, 3, 4});
    ASSERT_EQ(problemOf(good), "");
    const auto with = [&](const std::string& old, const std::string& now) {
        std::string text = good;
        text.replace(text.find(old), old.size(), now);
        return problemOf(text);
    };
    EXPECT_EQ(with("1 2 3 4", "1 2 3"), "lamp.ies:9: the file ends before candela value 4 of 4");
    EXPECT_EQ(with("1 2 3 4", "1 2 -3 4"), "lamp.ies:8: a candela value of -3; expected 0 or more");
    EXPECT_EQ(with("1 2 3 4", "0 0 0 0"), "lamp.ies:8: all candela values are 0");
    EXPECT_EQ(with("1 2 3 4", "1 2 3 nan"), "lamp.ies:8: 'nan' is not a number; expected candela value 4 of 4");
    EXPECT_EQ(with("1 2 3 4", "1 2 3 4 5"),
              "lamp.ies:8: '5' after the last candela value; expected the end of the file");
    EXPECT_EQ(with("0 90\n0 90", "90 0\n0 90"),
              "lamp.ies:6: vertical angle 2 is 0, after 90; expected ascending angles");
    EXPECT_EQ(with("0 90\n0 90", "0 190\n0 90"),
              "lamp.ies:6: vertical angle 2 is 190; expected one from 0 to 180 degrees");
    EXPECT_EQ(with("0 90\n0 90", "0 90\n0 70"),
              "lamp.ies:7: horizontal angles from 0 to 70; expected 0, 0 to 90, 0 to 180, 90 to 270 or 0 to 360");
    EXPECT_EQ(with("2 2 2 1", "2 2000000000 2 1"),
              "lamp.ies:4: 2e+09; expected the number of vertical angles, a whole number from 2 to 7201");
    EXPECT_EQ(with("2 2 2 1", "2 7000 7000 1"), "lamp.ies:4: 7000 x 7000 candela values; expected at most 4194304");
    EXPECT_EQ(with("2 2 2 1", "-1 2 2 1"), "lamp.ies:4: a multiplier of -1; expected one above 0");
    EXPECT_EQ(with("2 2 2 1", "2 2 2 2"), "lamp.ies:4: photometric type 2 (B); expected 1, type C");
    EXPECT_EQ(with("2 2 2 1", "2 2 2 3"), "lamp.ies:4: photometric type 3 (A); expected 1, type C");
    EXPECT_EQ(readPhotometry("/none.ies").problem, "/none.ies: there is no such file");
    EXPECT_EQ(readPhotometry("/").problem, "/: is not a file");
}

}  // namespace
}  // namespace scrim::test
