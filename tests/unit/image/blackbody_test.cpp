// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/blackbody.h>

#include <scrim/base/error.h>

#include "support/temp_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

// Y of the primaries of AP1, the ACES documents' digits.
const Rgb kLuminanceOfAp1(0.2722287, 0.6740818, 0.0536895);

const ColourConfig& ownConfig() {
    static const ColourConfig config = [] {
        ::unsetenv("OCIO");
        return ColourConfig::open("");
    }();
    return config;
}

ColourConfig configOf(const test::TempFolder& folder, const std::string& role, const std::string& spaces) {
    const std::string file = folder.file("test.ocio");
    std::ofstream(file) << "ocio_profile_version: 1\nroles: {scene_linear: " << role << ", default: " << role
                        << "}\ndisplays: {d: [!<View> {name: v, colorspace: " << role << "}]}\ncolorspaces:\n"
                        << spaces;
    return ColourConfig::open(file);
}

// As an engine reads a ramp.
Rgb at(const std::vector<std::pair<double, Rgb>>& ramp, double x) {
    const auto next = std::find_if(ramp.begin(), ramp.end(), [x](const auto& p) { return p.first > x; });
    if (next == ramp.end()) return ramp.back().second;
    if (next == ramp.begin()) return ramp.front().second;
    const auto& last = *(next - 1);
    return glm::mix(last.second, next->second, (x - last.first) / (next->first - last.first));
}

void expectNear(const Rgb& a, const Rgb& b, double tolerance, const std::string& what) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << what << ", component " << c;
}

TEST(Blackbody, ChromaticitiesAreOfThePlanckianLocus) {
    // Published to 4 digits; 2856 K is the CIE's illuminant A.
    struct Known {
        double kelvin, x, y;
    };
    for (const Known& k : {Known{1000, 0.6528, 0.3444}, Known{1500, 0.5857, 0.3931}, Known{2000, 0.5267, 0.4133},
                           Known{2856, 0.4476, 0.4075}, Known{4000, 0.3805, 0.3768}, Known{6500, 0.3135, 0.3237},
                           Known{10000, 0.2807, 0.2884}}) {
        const Vec3 xyz = blackbodyXyz(k.kelvin);
        const double sum = xyz.x + xyz.y + xyz.z;
        EXPECT_EQ(xyz.y, 1);
        EXPECT_NEAR(xyz.x / sum, k.x, 2e-4) << k.kelvin;
        EXPECT_NEAR(xyz.y / sum, k.y, 2e-4) << k.kelvin;
    }
}

TEST(Blackbody, ColoursStayBeyondTheirRange) {
    EXPECT_EQ(blackbodyXyz(799), blackbodyXyz(800));
    EXPECT_EQ(blackbodyXyz(-5), blackbodyXyz(0));
    EXPECT_NE(blackbodyXyz(801), blackbodyXyz(800));
    EXPECT_EQ(blackbodyXyz(1e9), blackbodyXyz(40000));
    EXPECT_NE(blackbodyXyz(39000), blackbodyXyz(40000));
}

TEST(Blackbody, LuminanceIsOne) {
    const Blackbody blackbody(ownConfig());
    for (const double kelvin : {500., 1000., 1500., 2500., 5000., 10000., 40000.}) {
        const Rgb colour = blackbody.colour(kelvin);
        // AP1's own weights are for its white; Bradford's adaptation from D65 moves reds by 1.6 %, blues by 0.5 %.
        EXPECT_NEAR(glm::dot(colour, kLuminanceOfAp1), 1, 0.017) << kelvin;
        EXPECT_GT(std::min({colour.r, colour.g, colour.b}), 0) << kelvin;
    }
}

TEST(Blackbody, GetsBluerAsItGetsHotter) {
    const Blackbody blackbody(ownConfig());
    double last = 1e9;
    for (double kelvin = kCoolestColour; kelvin <= kHottestColour; kelvin *= 1.05) {
        const Rgb colour = blackbody.colour(kelvin);
        EXPECT_LT(colour.r / colour.b, last) << kelvin;
        last = colour.r / colour.b;
    }
}

TEST(Blackbody, WhiteOfTheWorkingSpaceIsNearItsWhitePoint) {
    // D65 lies beside the locus, near 6500 K: by 0.003 in y.
    expectNear(Blackbody(ownConfig()).colour(6504), Rgb(1), 0.04, "6504 K");
}

TEST(Blackbody, ColoursBeyondTheGamutKeepTheirLuminance) {
    const test::TempFolder folder;
    const ColourConfig config = configOf(folder, "lin_rec709", "  - !<ColorSpace> {name: lin_rec709}\n");
    const Rgb colour = Blackbody(config).colour(1000);
    EXPECT_EQ(colour.b, 0) << "1000 K has no blue in Rec.709";
    EXPECT_GT(colour.g, 0);
    EXPECT_NEAR(glm::dot(colour, Rgb(0.2126390, 0.7151687, 0.0721923)), 1, 1e-6);
}

TEST(Blackbody, ComesThroughAces20651WhereThereIsNoRec709) {
    const test::TempFolder folder;
    // A working space of twice the numbers of AP0.
    const std::string twice = "!<MatrixTransform> {matrix: [2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1]}";
    const Blackbody ap0(configOf(
        folder, "work",
        "  - !<ColorSpace> {name: ACES2065-1, to_reference: " + twice + "}\n  - !<ColorSpace> {name: work}\n"));
    const Mat3 ap0FromAp1 = glm::inverse(ownConfig().workingFrom("ACES2065-1"));
    for (const double kelvin : {1500., 6500.})
        // OpenColorIO's matrices are made of the same definitions, in single precision here.
        expectNear(ap0.colour(kelvin), 2.0 * (ap0FromAp1 * Blackbody(ownConfig()).colour(kelvin)), 1e-5,
                   std::to_string(kelvin));
}

TEST(Blackbody, NeedsASpaceItKnowsTheWayFrom) {
    const test::TempFolder folder;
    const ColourConfig config = configOf(folder, "house", "  - !<ColorSpace> {name: house}\n");
    try {
        const Blackbody blackbody(config);
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        EXPECT_EQ(error.what(), "the OpenColorIO config '" + config.name() +
                                    "' has neither linear Rec.709 nor ACES2065-1; expected one of them, from which the "
                                    "colours of black bodies and skies come");
    }
}

TEST(Blackbody, RadianceIsStefansAndBoltzmanns) {
    // 5.670374419e-8 * 1000^4 / pi W/(m^2 sr)
    EXPECT_NEAR(blackbodyRadiance(1000), 0.01804936, 1e-8);
    EXPECT_NEAR(blackbodyRadiance(3000) / blackbodyRadiance(1500), 16, 1e-12);
    EXPECT_EQ(blackbodyRadiance(0), 0);
    EXPECT_EQ(blackbodyRadiance(-300), 0);
}

TEST(BlackbodyRamp, IsWithinAFiveHundredthBetweenItsPoints) {
    const Blackbody blackbody(ownConfig());
    for (const double physical : {0.0, 0.25, 0.5, 1.0}) {
        const auto ramp = blackbody.ramp(1500, 0, physical);
        for (double kelvin = 100; kelvin < 45000; kelvin *= 1.0071) {
            const double held = std::min(kelvin, kHottestColour);
            const double luminance = std::pow(blackbodyRadiance(held), physical);
            expectNear(at(ramp, kelvin / 1500), blackbody.colour(held) * luminance, 0.002 * luminance,
                       std::to_string(kelvin) + " K");
        }
    }
}

TEST(BlackbodyRamp, Ascends) {
    const Blackbody blackbody(ownConfig());
    for (const double offset : {-1e6, -273.15, -1e-9, 0.0, 1e-9, 0.5, 1.0, 273.15, 1e6})
        for (const double scale : {1e-9, 1.0, 1e9}) {
            const auto ramp = blackbody.ramp(scale, offset, 0);
            EXPECT_LT(ramp.size(), 500u);
            for (std::size_t i = 1; i < ramp.size(); ++i)
                // floats keep them apart, too
                EXPECT_LT(static_cast<float>(ramp[i - 1].first), static_cast<float>(ramp[i].first))
                    << offset << " " << scale << " " << i;
        }
}

TEST(BlackbodyRamp, IsBlackBelowZeroKelvinOnly) {
    const Blackbody blackbody(ownConfig());
    const Rgb cold = blackbody.colour(0);
    EXPECT_EQ(at(blackbody.ramp(1500, 0, 0), 0), cold);
    EXPECT_EQ(at(blackbody.ramp(1500, 0, 0), 1e-9), cold);
    EXPECT_EQ(at(blackbody.ramp(1500, 0, 0), -1), Rgb(0));
    EXPECT_EQ(at(blackbody.ramp(1500, 0, 1), 0), Rgb(0));
    EXPECT_EQ(at(blackbody.ramp(1500, -500, 0), 0), Rgb(0));
    EXPECT_EQ(at(blackbody.ramp(1500, -600, 0), 0.4), Rgb(0)) << "0 K";
    expectNear(at(blackbody.ramp(1500, -600, 0), 0.41), cold, 1e-12, "15 K");
    expectNear(at(blackbody.ramp(1, 273.15, 0), 0), cold, 1e-12, "0 C");
    EXPECT_EQ(at(blackbody.ramp(1, 273.15, 0), -274), Rgb(0));
    expectNear(at(blackbody.ramp(1, 2000, 0), 0), blackbody.colour(2000), 0.002, "2000 K");
}

}  // namespace
}  // namespace scrim
