// SPDX-License-Identifier: Apache-2.0
// [volume.medium]: phases, tint, octaves, and what grids give: albedo, emission, black bodies.
#include <scrim/image/blackbody.h>
#include <scrim/scene/ramp.h>
#include <scrim/scene/scene_reader.h>

#include "support/temp_folder.h"
#include "unit/scene/read_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

namespace scrim {
namespace {

using test::errorOf;
using test::kCamera;
using test::kVolume;
using test::ownColours;
using test::read;

/// [volume.medium] is at line 6, `lines` begin at line 7.
std::string sceneWith(const std::string& lines) {
    return kCamera + kVolume + "[volume.medium]\n" + lines + "\n";
}
SceneVolume volume(const std::string& lines, double frame = 1) {
    return read(sceneWith(lines), {}, frame).volumes.at(0);
}
std::string errorIn(const std::string& lines) {
    return errorOf(sceneWith(lines));
}
void expectNear(const Rgb& a, const Rgb& b, double tolerance = 1e-6) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << "component " << c;
}

TEST(SceneMedium, HasDefaults) {
    const SceneVolume v = volume("");
    EXPECT_EQ(v.medium.extinctionTint, Rgb(1));
    EXPECT_EQ(v.medium.octaves.count, 1);
    EXPECT_FALSE(v.albedoGrid.has_value());
    EXPECT_TRUE(v.emission.empty());
}

TEST(SceneMedium, RefusesUnknownKeys) {
    EXPECT_EQ(errorIn("emision = { grid = \"flame\" }"),
              "scene.toml:7:1: 'emision' is not known here ([volume.medium] of [[volume]] 'volume1'); did you mean "
              "'emission'?; allowed: 'albedo', 'extinction_tint', 'transparency', 'transparency_depth', 'phase', "
              "'scattering', "
              "'octaves', 'emission' or 'blackbody'");
}

// ---- phase

Phase phase(const std::string& text) {
    return volume("phase = " + text).medium.phase;
}

TEST(ScenePhase, ReadsEveryType) {
    EXPECT_TRUE(phase("{ type = \"isotropic\" }").isotropic());
    const Phase hg = phase("{ type = \"hg\", g = -0.4 }");
    EXPECT_EQ(hg.type, PhaseType::henyeyGreenstein);
    EXPECT_EQ(hg.g, -0.4);
    const Phase two = phase("{ type = \"two-lobe\", g1 = 0.8, g2 = -0.3, blend = 0.25 }");
    EXPECT_EQ(two.type, PhaseType::twoLobe);
    EXPECT_EQ(two.g, 0.8);
    EXPECT_EQ(two.g2, -0.3);
    EXPECT_EQ(two.blend, 0.25);
    EXPECT_EQ(phase("{ type = \"two-lobe\", g1 = 0.8, g2 = -0.3 }").blend, 0.5);
    EXPECT_EQ(phase("{ type = \"rayleigh\" }").type, PhaseType::rayleigh);
    EXPECT_EQ(phase("{ type = \"rayleigh\" }").strength, 1);
    EXPECT_EQ(phase("{ type = \"draine\", g = 0.6, alpha = 3 }"), drainePhase(0.6, 3));
    EXPECT_EQ(phase("{ type = \"draine\", g = 0.6 }"), drainePhase(0.6, 1));
    EXPECT_EQ(phase("{ type = \"droplets\", size = 20 }"), dropletPhase(20));
}

TEST(ScenePhase, IsChecked) {
    const auto phaseError = [](const std::string& text) { return errorIn("phase = " + text); };
    EXPECT_EQ(phaseError("{ type = \"mie\" }"),
              "scene.toml:7:18: 'type' is the string \"mie\"; expected 'isotropic', 'hg', 'two-lobe', 'rayleigh', "
              "'draine' or 'droplets'");
    EXPECT_EQ(phaseError("{ type = \"two-lobe\", g1 = 0.5 }"),
              "scene.toml:7:9: 'phase' of [volume.medium] of [[volume]] 'volume1' of type 'two-lobe' lacks 'g2'; "
              "expected a number greater than -1 and less than 1");
    EXPECT_EQ(phaseError("{ type = \"two-lobe\", g1 = 1, g2 = 0 }"),
              "scene.toml:7:35: 'g1' is 1; expected a number greater than -1 and less than 1");
    EXPECT_EQ(phaseError("{ type = \"two-lobe\", g1 = 0, g2 = -1 }"),
              "scene.toml:7:43: 'g2' is -1; expected a number greater than -1 and less than 1");
    EXPECT_EQ(phaseError("{ type = \"two-lobe\", g1 = 0, g2 = 0, blend = 1.5 }"),
              "scene.toml:7:54: 'blend' is 1.5; expected a number from 0 to 1");
    EXPECT_EQ(phaseError("{ type = \"draine\", g = 0.5, alpha = -1 }"),
              "scene.toml:7:45: 'alpha' is -1; expected a number from 0 to 1000000");
    EXPECT_EQ(phaseError("{ type = \"droplets\", size = 60 }"),
              "scene.toml:7:37: 'size' is 60; expected a number greater than 0 and of at most 50 micrometres");
    EXPECT_EQ(phaseError("{ type = \"droplets\" }"),
              "scene.toml:7:9: 'phase' of [volume.medium] of [[volume]] 'volume1' of type 'droplets' lacks 'size'; "
              "expected a number greater than 0 and of at most 50 micrometres");
    EXPECT_EQ(phaseError("{ type = \"rayleigh\", g = 0.5 }"),
              "scene.toml:7:30: 'g' is not known here ('phase' of [volume.medium] of [[volume]] 'volume1' of type "
              "'rayleigh'); allowed: 'type'");
}

// ---- tint and octaves

TEST(SceneTint, IsAColourOfAnyBrightness) {
    EXPECT_EQ(volume("extinction_tint = [0, 2, 1000]").medium.extinctionTint, Rgb(0, 2, 1000));
    expectNear(volume("extinction_tint = { rgb = [3, 3, 3], colorspace = \"lin_rec709\" }").medium.extinctionTint,
               Rgb(3), 1e-5);
    EXPECT_EQ(errorIn("extinction_tint = [0, -1, 0]"),
              "scene.toml:7:23: 'extinction_tint[1]' is -1; expected a number of at least 0");
    EXPECT_EQ(errorIn("extinction_tint = [0, 2e6, 0]"),
              "scene.toml:7:19: 'extinction_tint' is 0, 2000000, 0 in the working space; expected numbers from 0 to "
              "1e+06");
}

TEST(SceneTint, BeyondSinglePrecisionIsRefused) {
    const std::string text = errorIn("extinction_tint = { rgb = [1e300, 1, 1], colorspace = \"lin_rec709\" }");
    EXPECT_EQ(text.substr(0, 34), "scene.toml:7:19: 'extinction_tint'") << text;
}

TEST(SceneOctaves, AreRead) {
    const Octaves o = volume("octaves = { count = 4, extinction = 0.4, contribution = 0.6, phase = 0 }").medium.octaves;
    EXPECT_EQ(o.count, 4);
    EXPECT_EQ(o.extinction, 0.4);
    EXPECT_EQ(o.contribution, 0.6);
    EXPECT_EQ(o.phase, 0);
    const Octaves d = volume("octaves = {}").medium.octaves;
    EXPECT_EQ(d.count, 8) << "who writes octaves wants some";
    EXPECT_EQ(d.extinction, 0.5);
    EXPECT_EQ(d.contribution, 0.5);
    EXPECT_EQ(d.phase, 0.5);
}

TEST(SceneOctaves, AreChecked) {
    EXPECT_EQ(
        errorIn("scattering = \"full\"\noctaves = {}"),
        "scene.toml:8:11: [volume.medium] of [[volume]] 'volume1' has 'scattering' = \"full\" and 'octaves'; expected "
        "one of them");
    EXPECT_EQ(errorIn("octaves = { count = 0 }"),
              "scene.toml:7:21: 'count' is 0; expected a whole number from 1 to 16");
    EXPECT_EQ(errorIn("octaves = { count = 17 }"),
              "scene.toml:7:21: 'count' is 17; expected a whole number from 1 to 16");
    for (const char* key : {"extinction", "contribution", "phase"}) {
        const std::string text = errorIn("octaves = { " + std::string(key) + " = 1.1 }");
        EXPECT_NE(text.find("'" + std::string(key) + "' is 1.1; expected a number from 0 to 1"), std::string::npos)
            << text;
    }
    EXPECT_EQ(errorIn("octaves = 8"), "scene.toml:7:11: 'octaves' is 8; expected a table");
}

// ---- albedo

TEST(SceneAlbedo, IsAColourOrAGrid) {
    const SceneVolume colour = volume("albedo = { rgb = [0.5, 0.5, 0.5], colorspace = \"lin_rec709\" }");
    EXPECT_FALSE(colour.albedoGrid.has_value());
    expectNear(colour.medium.albedo, Rgb(0.5));
    const SceneVolume grid = volume("albedo = { grid = \"Cd\", scale = 0.5 }");
    ASSERT_TRUE(grid.albedoGrid.has_value());
    EXPECT_EQ(grid.albedoGrid->grid, "Cd");
    EXPECT_EQ(grid.albedoGrid->scale, 0.5);
    EXPECT_EQ(grid.albedoGrid->workingFromGrid, Mat3(1.0));
    EXPECT_EQ(grid.albedoGrid->where, "scene.toml:7:19");
    EXPECT_EQ(volume("albedo = { grid = \"Cd\" }").albedoGrid->scale, 1);
}

TEST(SceneAlbedo, OfAGridIsConvertedByAMatrix) {
    const auto grid = volume("albedo = { grid = \"Cd\", colorspace = \"lin_rec709\" }").albedoGrid;
    const Rgb probe(0.1, 0.7, 0.4);
    expectNear(grid->workingFromGrid * probe, ownColours().toWorking(probe, "lin_rec709"));
}

TEST(SceneAlbedo, IsChecked) {
    EXPECT_EQ(
        errorIn("albedo = { grid = \"Cd\", colorspace = \"sRGB\" }"),
        "scene.toml:7:38: 'colorspace': the colour space 'sRGB - Texture' is not linear; expected one that a matrix "
        "takes to 'ACEScg'");
    EXPECT_EQ(errorIn("albedo = { grid = \"Cd\", colorspace = \"none such\" }").substr(0, 70),
              "scene.toml:7:38: 'colorspace': unknown colour space 'none such' in the");
    EXPECT_EQ(errorIn("albedo = { grid = \"Cd\", scale = -1 }"),
              "scene.toml:7:33: 'scale' is -1; expected a number from 0 to 1e+30");
    EXPECT_EQ(
        errorIn("albedo = { grid = \"Cd\", rgb = [1, 1, 1] }"),
        "scene.toml:7:25: 'rgb' is not known here ('albedo' of [volume.medium] of [[volume]] 'volume1'); allowed: "
        "'grid', 'scale', 'colorspace' or 'ramp'");
    EXPECT_EQ(errorIn("albedo = { gird = \"Cd\" }"),
              "scene.toml:7:12: 'gird' is not known here (the colour 'albedo'); allowed: 'rgb' or 'colorspace'");
}

// ---- emission

TEST(SceneEmission, ReadsGridRampAndScale) {
    const SceneVolume v = volume(
        "emission = { grid = \"flame\", ramp = [[0, [0, 0, 0]], [1, [1, 0.5, 0.1]],\n"
        "  [2, { rgb = [4, 4, 4], colorspace = \"lin_rec709\" }]], scale = 2 }");
    ASSERT_EQ(v.emission.size(), 1u);
    const Emission& e = v.emission[0];
    EXPECT_EQ(e.grid, "flame");
    EXPECT_EQ(e.where, "scene.toml:7:21");
    EXPECT_EQ(e.scale, 2);
    EXPECT_FALSE(e.blackbody);
    ASSERT_EQ(e.ramp.size(), 3u);
    EXPECT_EQ(e.ramp[0], std::make_pair(0.0, Rgb(0)));
    EXPECT_EQ(e.ramp[1], std::make_pair(1.0, Rgb(1, 0.5, 0.1)));
    EXPECT_EQ(e.ramp[2].first, 2);
    expectNear(e.ramp[2].second, Rgb(4), 1e-5);
}

TEST(SceneEmission, RampsTakeTemperaturesAndStrengths) {
    const auto ramp = volume(
                          "emission = { grid = \"heat\", ramp = [[0, 1000, 0], [0.5, 1500, 3], [1, [1, 0.5, 0.1], 2],\n"
                          "  [2, 2000]] }")
                          .emission.at(0)
                          .ramp;
    const Blackbody blackbody(ownColours());
    ASSERT_EQ(ramp.size(), 4u);
    EXPECT_EQ(ramp[0], std::make_pair(0.0, Rgb(0)));
    EXPECT_EQ(ramp[1], std::make_pair(0.5, blackbody.colour(1500) * 3.0));
    EXPECT_EQ(ramp[2], std::make_pair(1.0, Rgb(2, 1, 0.2)));
    EXPECT_EQ(ramp[3], std::make_pair(2.0, blackbody.colour(2000)));
}

TEST(SceneEmission, RampsAreOfARangeOfGridValues) {
    const std::string ramp = "ramp = [[0, 1000, 0], [0.5, 1500], [1, 2000]] }";
    const auto points = [&](const std::string& range) {
        return volume("emission = { grid = \"heat\", " + range + ramp).emission.at(0).ramp;
    };
    const auto plain = points(""), moved = points("range = [0.5, 4.5], ");
    EXPECT_EQ(points("range = [0, 1], "), plain);
    ASSERT_EQ(moved.size(), plain.size());
    for (std::size_t i = 0; i < moved.size(); ++i) {
        EXPECT_EQ(moved[i].first, 0.5 + 4 * plain[i].first);
        EXPECT_EQ(moved[i].second, plain[i].second);
    }
    // A range that begins below 0 would let empty space glow.
    EXPECT_NE(errorIn("emission = { grid = \"heat\", range = [-1, 1], " + ramp).find("not black at grid value 0"),
              std::string::npos);
}

TEST(SceneEmission, WithoutARampIsTheGridsOwnValue) {
    const SceneVolume v = volume("emission = { grid = \"heat\" }");
    EXPECT_TRUE(v.emission.at(0).ramp.empty());
    EXPECT_EQ(v.emission.at(0).scale, 1);
    EXPECT_EQ(v.emission.at(0).color, Rgb(1));
}

TEST(SceneMedium, EmissionOfColoursIsThatOfThreeGrids) {
    const SceneVolume v = volume("emission = { grid = \"Le\", colors = true, scale = 3 }");
    ASSERT_EQ(v.emission.size(), 3u);
    for (int c = 0; c < 3; ++c) {
        const Emission& channel = v.emission[std::size_t(c)];
        EXPECT_EQ(channel.grid, std::string("Le.") + "rgb"[c]);
        EXPECT_EQ(channel.scale, 3);
        Rgb only(0);
        only[c] = 1;
        EXPECT_EQ(channel.color, only);
        EXPECT_TRUE(channel.ramp.empty());
        EXPECT_EQ(channel.where, v.emission[0].where);
    }
    EXPECT_EQ(volume("emission = { grid = \"Le\", colors = false }").emission.size(), 1u);
    EXPECT_NE(errorIn("emission = { grid = \"Le\", colors = true, ramp = [[0, [0, 0, 0]], [1, [1, 1, 1]]] }")
                  .find("has 'colors' and 'ramp'; expected one of them"),
              std::string::npos);
}

TEST(SceneEmission, ScaleMayBeKeyed) {
    EXPECT_EQ(volume("emission = { grid = \"flame\", scale = { keys = [[1, 0], [5, 8]] } }", 3).emission.at(0).scale,
              4);
}

TEST(SceneEmission, RampsKeepEmptySpaceBlack) {
    const auto rampError = [](const std::string& ramp) {
        return errorIn("emission = { grid = \"flame\", ramp = " + ramp + " }");
    };
    const std::string zero =
        "scene.toml:7:37: 'ramp' is not black at grid value 0; expected black there, because empty space is skipped";
    EXPECT_EQ(rampError("[[0, [0, 0, 0.1]], [1, [1, 1, 1]]]"), zero);
    EXPECT_EQ(rampError("[[-1, [0, 0, 0]], [1, [1, 1, 1]]]"), zero);
    EXPECT_EQ(rampError("[[0.5, [1, 0, 0]], [1, [0, 0, 0]]]"), zero);
    EXPECT_EQ(rampError("[[0.5, [0, 0, 0]], [1, [1, 1, 1]]]"), "no error");
    EXPECT_EQ(rampError("[[-1, [1, 1, 1]], [0, [0, 0, 0]], [1, [1, 1, 1]]]"), "no error");
}

TEST(SceneEmission, IsChecked) {
    const auto emissionError = [](const std::string& text) { return errorIn("emission = { " + text + " }"); };
    EXPECT_EQ(
        emissionError("scale = 1"),
        "scene.toml:7:12: 'emission' of [volume.medium] of [[volume]] 'volume1' lacks 'grid'; expected the name of "
        "a grid");
    EXPECT_EQ(emissionError("grid = \"f\", scale = -1"),
              "scene.toml:7:34: 'scale' is -1; expected a number from 0 to 1e+30");
    EXPECT_EQ(emissionError("grid = \"f\", ramp = [[0, [0, 0, 0]]]"),
              "scene.toml:7:33: 'ramp' is a list of 1; expected at least two [grid value, colour or Kelvin] or "
              "[grid value, colour or Kelvin, strength]");
    EXPECT_EQ(emissionError("grid = \"f\", ramp = [[0, [0, 0, 0]], [0, [1, 1, 1]]]"),
              "scene.toml:7:51: 'ramp': 0 does not come after 0; expected ascending values");
    EXPECT_EQ(emissionError("grid = \"f\", ramp = [[0, [0, 0, 0]], [1, 2]]"),
              "scene.toml:7:54: 'ramp[1][1]' is 2; expected a number from 800 to 40000 Kelvin");
    EXPECT_EQ(emissionError("grid = \"f\", ramp = [[0, [0, 0, 0]], [1, \"red\"]]"),
              "scene.toml:7:54: 'ramp[1][1]' is the string \"red\"; expected a colour [r, g, b], each of at least 0, "
              "or { rgb = [r, "
              "g, b], colorspace = \"...\" }");
    EXPECT_EQ(emissionError("grid = \"f\", ramp = [[0, 1000, 0], [1, 1500, -1]]"),
              "scene.toml:7:58: 'ramp[1][2]' is -1; expected a number of at least 0");
    EXPECT_EQ(emissionError("grid = \"f\", range = [0, 2]"),
              "scene.toml:7:34: 'emission' of [volume.medium] of [[volume]] 'volume1' has 'range' without 'ramp'");
    EXPECT_EQ(emissionError("grid = \"f\", range = [2, 1], ramp = [[0, 1000, 0], [1, 1500]]"),
              "scene.toml:7:34: 'range' is [2, 1]; expected ascending numbers");
    EXPECT_EQ(emissionError("grid = \"f\", ramp = [[0, [0, 0, 0]], [1, [0, -1, 0]]]"),
              "scene.toml:7:58: 'ramp[1][1][1]' is -1; expected a number of at least 0");
}

// ---- black bodies

TEST(SceneBlackbody, IsARampOverTheGrid) {
    const SceneVolume v =
        volume("blackbody = { grid = \"temperature\", scale = 1500, offset = -200, intensity = 3, normalize = false }");
    ASSERT_EQ(v.emission.size(), 1u);
    const Emission& e = v.emission[0];
    EXPECT_EQ(e.grid, "temperature");
    EXPECT_EQ(e.where, "scene.toml:7:22");
    EXPECT_TRUE(e.blackbody);
    EXPECT_EQ(e.scale, 3);
    EXPECT_EQ(e.ramp, Blackbody(ownColours()).ramp(1500, -200, 1));
}

TEST(SceneBlackbody, HasDefaults) {
    const SceneVolume v = volume("blackbody = { grid = \"temperature\" }");
    EXPECT_EQ(v.emission.at(0).ramp, Blackbody(ownColours()).ramp(1, 0, 1));
    EXPECT_EQ(v.emission.at(0).scale, 1);
}

TEST(SceneBlackbody, TakesTheTemperaturesOfGridValuesZeroAndOne) {
    const SceneVolume v = volume("blackbody = { grid = \"heat\", kelvin = [500, 1900] }");
    EXPECT_EQ(v.emission.at(0).ramp, Blackbody(ownColours()).ramp(1400, 500, 1));
    EXPECT_EQ(v.emission.at(0).kelvinScale, 1400);
    EXPECT_EQ(v.emission.at(0).kelvinOffset, 500);
}

TEST(SceneBlackbody, BlendsFromEquallyBrightToPhysical) {
    // Stefan and Boltzmann: at intensity 1 a body of 1500 K has the radiance 0.0914 MW/(m^2 sr), T^4 as T.
    const auto brightness = [](const std::string& keys, double kelvin) {
        const auto ramp = volume("blackbody = { grid = \"heat\", " + keys + " }").emission.at(0).ramp;
        const Rgb colour = ramped(ramp, kelvin), pure = ramped(Blackbody(ownColours()).ramp(1, 0, 0), kelvin);
        return colour.x / pure.x;
    };
    for (const double kelvin : {1000.0, 1500.0, 2500.0}) {
        const double physical = 5.670374419e-14 / 3.14159265358979 * std::pow(kelvin, 4);
        EXPECT_NEAR(brightness("physical_intensity = 1", kelvin) / physical, 1, 0.004) << kelvin;
        EXPECT_NEAR(brightness("physical_intensity = 0", kelvin), 1, 1e-12) << kelvin;
        EXPECT_NEAR(brightness("physical_intensity = 0.5", kelvin) / std::sqrt(physical), 1, 0.004) << kelvin;
        EXPECT_EQ(brightness("normalize = true", kelvin), brightness("physical_intensity = 0", kelvin));
        EXPECT_EQ(brightness("normalize = false", kelvin), brightness("physical_intensity = 1", kelvin));
    }
    const std::string blackbody = "[volume.medium]\nblackbody = { grid = 'heat', ";
    EXPECT_EQ(errorOf(test::kCamera + test::kVolume + blackbody + "physical_intensity = 1.5 }"),
              "scene.toml:7:51: 'physical_intensity' is 1.5; expected a number from 0 to 1");
    EXPECT_EQ(errorOf(test::kCamera + test::kVolume + blackbody + "normalize = true, physical_intensity = 1 }"),
              "scene.toml:7:69: 'blackbody' of [volume.medium] of [[volume]] 'volume1' has both 'normalize' and "
              "'physical_intensity'; expected one of them");
    EXPECT_TRUE(test::read(test::kCamera + test::kVolume + blackbody + "physical_intensity = 1 }").warnings.empty())
        << "whoever says it knows what 'normalize' does";
}

// ---- transparency

TEST(SceneTransparency, IsTheColourOfLightAfterADepth) {
    // Beer and Lambert: exp(-extinction * depth) is the colour, whatever the depth.
    const Rgb colour(0.8, 0.5, 1);
    for (const double depth : {1.0, 0.25, 40.0}) {
        const SceneVolume v = volume("transparency = [0.8, 0.5, 1]\ntransparency_depth = " + std::to_string(depth));
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(std::exp(-v.medium.extinctionTint[c] * depth), colour[c], 1e-12);
    }
    // e^-1 after 1 is what a density of 1 does without the key.
    const SceneVolume one = volume("transparency = [0.36787944117144233, 0.36787944117144233, 0.36787944117144233]");
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(one.medium.extinctionTint[c], 1, 1e-12);
    EXPECT_EQ(volume("transparency = [1, 1, 1]").medium.extinctionTint, Rgb(0));
}

TEST(SceneTransparency, RefusesWhatNoExtinctionDoes) {
    EXPECT_EQ(
        errorIn("transparency = [0.5, 0, 1]"),
        "scene.toml:7:16: 'transparency' is a list of 3; expected a colour of which some of each channel is left: "
        "above 0, at most 1");
    EXPECT_EQ(errorIn("transparency = [0.5, 1.5, 1]"),
              "scene.toml:7:16: 'transparency' is 0.5, 1.5, 1 in the working space; expected numbers from 0 to 1");
    EXPECT_EQ(errorIn("transparency = [0.5, 0.5, 1]\ntransparency_depth = 1e-8"),
              "scene.toml:7:16: 'transparency' is reached so soon that extinction is above 1e+06; expected a greater "
              "'transparency_depth'");
    EXPECT_EQ(
        errorIn("transparency_depth = 2"),
        "scene.toml:7:22: [volume.medium] of [[volume]] 'volume1' has 'transparency_depth' without 'transparency'");
    EXPECT_EQ(errorIn("transparency = [0.5, 0.5, 1]\nextinction_tint = [1, 1, 1]"),
              "scene.toml:8:19: [volume.medium] of [[volume]] 'volume1' has both 'transparency' and 'extinction_tint'; "
              "expected one of them");
}

TEST(SceneBlackbody, WarnsScenesThatRelyOnTheOldDefault) {
    const auto warnings = [](const std::string& blackbody, const std::string& version) {
        return test::read(version + test::kCamera + test::kVolume + "[volume.medium]\nblackbody = { " + blackbody +
                          " }\n")
            .warnings;
    };
    const std::string bare = "grid = \"heat\"";
    ASSERT_EQ(warnings(bare, "").size(), 1u);
    EXPECT_EQ(warnings(bare, "")[0],
              "scene.toml:7:13: 'normalize' of the blackbody now defaults to false; before scene_version 2 it was "
              "true, which makes all temperatures equally bright. Set it, or set scene_version = 2");
    EXPECT_TRUE(warnings(bare, "scene_version = 2\n").empty());
    EXPECT_TRUE(warnings(bare + ", normalize = false", "").empty());
    EXPECT_EQ(test::errorOf("scene_version = 3\n" + test::kCamera + test::kVolume),
              "scene.toml:1:17: 'scene_version' is 3; expected a whole number from 1 to 2");
}

TEST(SceneBlackbody, ComesAfterEmission) {
    const SceneVolume v = volume("blackbody = { grid = \"temperature\" }\nemission = { grid = \"flame\" }");
    ASSERT_EQ(v.emission.size(), 2u);
    EXPECT_EQ(v.emission[0].grid, "flame");
    EXPECT_EQ(v.emission[1].grid, "temperature");
}

TEST(SceneBlackbody, IntensityMayBeKeyed) {
    const std::string text = "blackbody = { grid = \"temperature\", intensity = { keys = [[1, 0], [5, 8]] } }";
    EXPECT_EQ(volume(text, 2).emission.at(0).scale, 2);
}

TEST(SceneBlackbody, IsChecked) {
    const auto blackbodyError = [](const std::string& text) { return errorIn("blackbody = { " + text + " }"); };
    EXPECT_EQ(
        blackbodyError("scale = 1"),
        "scene.toml:7:13: 'blackbody' of [volume.medium] of [[volume]] 'volume1' lacks 'grid'; expected the name of "
        "a grid");
    EXPECT_EQ(blackbodyError("grid = \"t\", scale = 0"),
              "scene.toml:7:35: 'scale' is 0; expected a number from 1e-09 to 1e+09 Kelvin");
    EXPECT_EQ(blackbodyError("grid = \"t\", offset = -1e7"),
              "scene.toml:7:36: 'offset' is -10000000; expected a number from -1000000 to 1000000 Kelvin");
    EXPECT_EQ(blackbodyError("grid = \"t\", kelvin = [1900, 500]"),
              "scene.toml:7:36: 'kelvin' is [1900, 500]; expected the second temperature above the first");
    EXPECT_EQ(blackbodyError("grid = \"t\", kelvin = [500, 1900], offset = 3"),
              "scene.toml:7:58: 'blackbody' of [volume.medium] of [[volume]] 'volume1' has both 'kelvin' and 'offset'; "
              "expected one of them");
    EXPECT_EQ(
        blackbodyError("grid = \"t\", kelvin = 1900"),
        "scene.toml:7:36: 'kelvin' is 1900; expected two temperatures [of grid value 0, of grid value 1] in Kelvin");
    EXPECT_EQ(blackbodyError("grid = \"t\", intensity = -1"),
              "scene.toml:7:39: 'intensity' is -1; expected a number from 0 to 1e+30");
    EXPECT_EQ(blackbodyError("grid = \"t\", normalize = 1"),
              "scene.toml:7:39: 'normalize' is 1; expected true or false");
}

TEST(SceneBlackbody, NeedsAConfigThatKnowsItsColours) {
    const test::TempFolder folder;
    const std::string file = folder.file("house.ocio");
    std::ofstream(file) << "ocio_profile_version: 1\nroles: {scene_linear: house, default: house}\n"
                           "displays: {d: [!<View> {name: v, colorspace: house}]}\n"
                           "colorspaces: [!<ColorSpace> {name: house}]\n";
    try {
        readScene({"scene.toml", "", sceneWith("blackbody = { grid = \"temperature\" }")}, 1, {},
                  ColourConfig::open(file));
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.what(), "scene.toml:7:13: 'blackbody': the OpenColorIO config '" + file +
                                    "' has neither linear Rec.709 nor ACES2065-1; expected one of them, from which the "
                                    "colours of black bodies and skies come");
    }
}

TEST(SceneTint, ConversionThatFailsIsLocated) {
    const test::TempFolder folder;
    const std::string file = folder.file("ring.ocio");
    std::ofstream(file) << "ocio_profile_version: 1\nroles: {scene_linear: house, default: house}\n"
                           "displays: {d: [!<View> {name: v, colorspace: house}]}\n"
                           "colorspaces: [!<ColorSpace> {name: house}, !<ColorSpace> {name: ring, to_reference: "
                           "!<ColorSpaceTransform> {src: ring, dst: house}}]\n";
    try {
        readScene({"scene.toml", "", sceneWith("extinction_tint = { rgb = [1, 1, 1], colorspace = \"ring\" }")}, 1, {},
                  ColourConfig::open(file));
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).rfind("scene.toml:7:51: cannot convert from 'ring' to 'house': ", 0), 0u)
            << error.what();
    }
}

}  // namespace
}  // namespace scrim
