// SPDX-License-Identifier: Apache-2.0
// The vectorised float shader against algorithm section 6, written down once more in plain double precision.
//
// Tolerances are relative to what a sample would be without cones and windows. Floats carry 6e-8; an exponent of up
// to 87 multiplies that (5e-6), the cosine in Henyey-Greenstein's denominator (1 - g)^2 divides it (1e-5 at g = 0.85),
// and so does the width of a cone's or window's fading (0.02 and more: 1e-5). Light that has passed a tau of more
// than 87 is 0 in floats.
#include <scrim/engine/shade/shade_tile.h>

#include <scrim/engine/plan/light_groups.h>
#include <scrim/scene/medium.h>
#include <scrim/verify/sheet_integral.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim::test {
namespace {

constexpr double kTolerance = 3e-5;

class Random {
  public:
    explicit Random(unsigned seed) : m_engine(seed) {}
    double in(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(m_engine); }
    float floatIn(double lower, double upper) { return static_cast<float>(in(lower, upper)); }
    bool coin() { return m_engine() % 2 == 0; }

  private:
    std::mt19937 m_engine;
};

// 256 values where vectors may load them.
struct alignas(64) Row {
    float values[kTileSize] = {};
};

// A tile with everything that ShadeInput points to.
struct Tile {
    SampleTile samples;
    Row extinction;
    std::vector<Row> mediaExtinction;
    std::vector<Row> tauIn;
    std::vector<SheetMedium> media;
    std::vector<SheetLight> lights;
    float ambient[3] = {0, 0, 0};
    bool sameSide = true;
    float thickness = 0.9f;

    ShadeInput input() const {
        ShadeInput in{};
        in.samples = &samples;
        in.texel = 0.7f;
        in.thickness = thickness;
        in.sameSide = sameSide;
        in.extinction[0] = extinction.values;
        in.channels = 1;
        in.tints[0][0] = in.tints[0][1] = in.tints[0][2] = 1;
        in.media = media;
        in.lights = lights;
        in.tauIn = tauIn.empty() ? nullptr : tauIn.front().values;
        std::copy(ambient, ambient + 3, in.ambient);
        return in;
    }
    std::vector<float> shaded() const {
        alignas(64) float out[4 * kTileSize];
        shadeTile(input(), out);
        return {out, out + 4 * kTileSize};
    }
};

// Random samples whose tau through a sheet is spread evenly over the decades from 1e-12 to `mostTau`.
Tile randomTile(unsigned seed, int media, double mostTau) {
    Random random(seed);
    Tile tile;
    for (int k = 0; k < kTileSize; ++k) {
        tile.samples.u[k] = random.floatIn(100, 140);
        tile.samples.v[k] = random.floatIn(30, 60);
        tile.samples.eyeA[k] = random.floatIn(-1.5, 1.5);
        tile.samples.eyeB[k] = random.floatIn(-1.5, 1.5);
    }
    tile.mediaExtinction.resize(static_cast<std::size_t>(media));
    for (Row& extinction : tile.mediaExtinction) {
        for (int k = 0; k < kTileSize; ++k) {
            const double some = std::pow(10, random.in(-12, std::log10(mostTau)));
            extinction.values[k] = k % 17 == 3 ? 0.0f : static_cast<float>(some);
            tile.extinction.values[k] += extinction.values[k];
        }
        tile.media.push_back({{extinction.values, extinction.values, extinction.values},
                              {random.floatIn(0, 1), random.floatIn(0, 1), random.floatIn(0, 1)},
                              {random.coin() ? 0.0 : random.in(-0.85, 0.85)},
                              {}});
    }
    return tile;
}

void addLight(Tile& tile, const SheetLight& light, Random& random) {
    tile.lights.push_back(light);
    for (SheetLight& l : tile.lights)
        for (float& c : l.intensity) c = random.floatIn(0, 5);
    tile.tauIn.push_back({});
    for (int k = 0; k < kTileSize; ++k) tile.tauIn.back().values[k] = random.floatIn(0, k % 5 == 0 ? 60 : 2);
}

struct Plain {
    double rgb[3] = {0, 0, 0};
    double scale[3] = {0, 0, 0};  // the same without cones and windows
    double minusOpacity = 0;
};

double smoothstep(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

double windowShare(const NearOnSheet::Window& window, const Vec3& travel) {
    double own = 0, sum = 0;
    for (std::size_t i = 0; i < window.axes->size(); ++i) {
        const double t = std::max(0.0, glm::dot((*window.axes)[i], travel) - double(window.cosEdge));
        sum += t * t;
        if (static_cast<int>(i) == window.number) own = t * t;
    }
    return sum > 0 ? own / sum : 0;
}

// Sample k by the text of section 6.
Plain plainShade(const ShadeInput& in, int k) {
    Plain out;
    const double a = in.samples->eyeA[k], b = in.samples->eyeB[k];
    const double slantEye = std::sqrt(1 + a * a + b * b), pathEye = slantEye * in.thickness;
    const double sigma = in.extinction[0][k], tauEye = sigma * pathEye;
    out.minusOpacity = std::expm1(-tauEye);
    // The eye's direction: along +w where it meets the light's side first, and against it otherwise.
    const Vec3 eye = (in.sameSide ? 1.0 : -1.0) * glm::normalize(Vec3(a, b, 1));

    for (std::size_t i = 0; i < in.lights.size(); ++i) {
        const SheetLight& light = in.lights[i];
        const NearOnSheet* const lamp = light.near();
        Vec3 way(0, 0, 1);
        double irradiance = 1;
        if (const DistantOnSheet* sun = light.distant()) {
            way = {sun->slopeA, sun->slopeB, 1};
        } else {
            way = {(in.samples->u[k] - double(lamp->texelU)) * in.texel / lamp->distanceW,
                   (in.samples->v[k] - double(lamp->texelV)) * in.texel / lamp->distanceW, 1};
            if (lamp->decay) {
                // Mean over the eye's segment, at the two points of Gauss' quadrature.
                irradiance = 0;
                for (const double at : {-0.5, 0.5}) {
                    const Vec3 from =
                        way * double(lamp->distanceW) + at / std::sqrt(3.0) * in.thickness * Vec3(a, b, 1);
                    irradiance += 0.5 / std::max(glm::dot(from, from), double(lamp->radius2));
                }
            }
        }
        const Vec3 travel = glm::normalize(way);
        double share = 1;
        if (lamp && lamp->cone)
            share *= smoothstep((glm::dot(travel, Vec3(lamp->axisU, lamp->axisV, lamp->axisW)) - lamp->cone->cosOuter) /
                                (double(lamp->cone->cosInner) - lamp->cone->cosOuter));
        if (lamp && lamp->window) share *= windowShare(*lamp->window, travel);

        double transmit = psi(tauEye);
        if (light.shadowed) {
            const double tauLight = sigma * glm::length(way) * in.thickness;
            transmit = std::exp(-double(in.tauIn[i * kTileSize + std::size_t(k)])) *
                       sheetTransmit(tauEye, tauLight, in.sameSide);
        }
        for (const SheetMedium& medium : in.media) {
            // Light leaves towards the eye, against its ray.
            const double phase = phaseValue(medium.phase, -glm::dot(travel, eye));
            for (int c = 0; c < 3; ++c) {
                const double full = double(medium.scatter[0][k]) * pathEye * medium.albedo[c] * light.intensity[c] *
                                    irradiance * phase * transmit;
                out.rgb[c] += share * full;
                out.scale[c] += full;
            }
        }
    }
    for (const SheetMedium& medium : in.media)
        for (int c = 0; c < 3; ++c) {
            const double full = double(medium.scatter[0][k]) * pathEye * medium.albedo[c] * in.ambient[c] * psi(tauEye);
            out.rgb[c] += full;
            out.scale[c] += full;
        }
    return out;
}

void expectPlainShading(const Tile& tile, const std::string& what) {
    const std::vector<float> actual = tile.shaded();
    const ShadeInput input = tile.input();
    for (int k = 0; k < kTileSize; ++k) {
        const Plain expected = plainShade(input, k);
        const float* sample = actual.data() + 4 * k;
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(sample[c], expected.rgb[c], kTolerance * expected.scale[c] + 1e-36)
                << what << ", sample " << k << " of extinction " << tile.extinction.values[k];
        ASSERT_NEAR(sample[3], expected.minusOpacity, 1e-6 * -expected.minusOpacity)
            << what << ", sample " << k << " of extinction " << tile.extinction.values[k];
    }
}

SheetLight distantLight(Random& random) {
    SheetLight light;
    auto& sun = light.source.emplace<DistantOnSheet>();
    sun.slopeA = random.floatIn(-1.5, 1.5);
    sun.slopeB = random.floatIn(-1.5, 1.5);
    return light;
}

SheetLight pointLight(Random& random) {
    SheetLight light;
    auto& lamp = light.source.emplace<NearOnSheet>();
    lamp.texelU = random.floatIn(90, 150);
    lamp.texelV = random.floatIn(20, 70);
    lamp.distanceW = random.floatIn(5, 40);
    lamp.radius2 = random.floatIn(0.1, 300);
    lamp.decay = random.coin();
    return light;
}

// A sheet so thin that a spot's light hardly changes within it; means over paths are the LampOnPath tests'.
constexpr float kThin = 1e-4f;

SheetLight spotLight(Random& random) {
    SheetLight light = pointLight(random);
    auto& lamp = std::get<NearOnSheet>(light.source);
    const Vec3 axis = glm::normalize(Vec3(random.in(-0.5, 0.5), random.in(-0.5, 0.5), 1));
    lamp.axisU = static_cast<float>(axis.x);
    lamp.axisV = static_cast<float>(axis.y);
    lamp.axisW = static_cast<float>(axis.z);
    auto& cone = lamp.cone.emplace();
    cone.cosOuter = random.floatIn(0.6, 0.9);
    cone.cosInner = cone.cosOuter + random.floatIn(0.02, 0.09);
    return light;
}

// Window axes around +w.
std::vector<Vec3> someWindows() {
    return {glm::normalize(Vec3(0, 0, 1)), glm::normalize(Vec3(0.6, 0, 1)), glm::normalize(Vec3(-0.5, 0.4, 1)),
            glm::normalize(Vec3(-0.2, -0.7, 1))};
}

class ShadeTile : public testing::TestWithParam<bool> {};

TEST_P(ShadeTile, OfADistantLightIsTheClosedForm) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Random random(seed);
        Tile tile = randomTile(seed, 1, 1e4);
        tile.sameSide = GetParam();
        addLight(tile, distantLight(random), random);
        expectPlainShading(tile, "seed " + std::to_string(seed));
    }
}

TEST_P(ShadeTile, OfPointLightsIsTheClosedForm) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Random random(seed + 100);
        Tile tile = randomTile(seed, 1, 1e4);
        tile.sameSide = GetParam();
        addLight(tile, pointLight(random), random);
        expectPlainShading(tile, "seed " + std::to_string(seed));
    }
}

TEST_P(ShadeTile, OfSpotsFadesBetweenTheirAngles) {
    double lit = 0, dark = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Random random(seed + 200);
        Tile tile = randomTile(seed, 1, 1e4);
        tile.sameSide = GetParam();
        tile.thickness = kThin;
        addLight(tile, spotLight(random), random);
        expectPlainShading(tile, "seed " + std::to_string(seed));
        const std::vector<float> rgba = tile.shaded();
        for (std::size_t k = 0; k < kTileSize; ++k) (rgba[4 * k] > 0 ? lit : dark) += 1;
    }
    EXPECT_GT(lit, 100);  // the draw met both sides of the cones
    EXPECT_GT(dark, 100);
}

TEST_P(ShadeTile, OfUnshadowedLightsReadsNoTau) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
        Random random(seed + 300);
        Tile tile = randomTile(seed, 1, 1e4);
        tile.sameSide = GetParam();
        SheetLight light = distantLight(random);
        light.shadowed = false;
        addLight(tile, light, random);
        expectPlainShading(tile, "seed " + std::to_string(seed));
        const std::vector<float> before = tile.shaded();
        std::fill_n(tile.tauIn[0].values, kTileSize, 1e30f);
        EXPECT_EQ(before, tile.shaded());
    }
}

TEST_P(ShadeTile, OfALightsWindowIsItsShare) {
    const std::vector<Vec3> windows = someWindows();
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Random random(seed + 400);
        Tile tile = randomTile(seed, 1, 1e4);
        tile.sameSide = GetParam();
        SheetLight light = pointLight(random);
        std::get<NearOnSheet>(light.source).window = {&windows, static_cast<int>(seed % windows.size()),
                                                      static_cast<float>(std::cos(kWindowAngle))};
        addLight(tile, light, random);
        expectPlainShading(tile, "seed " + std::to_string(seed));
    }
}

TEST_P(ShadeTile, OfSeveralMediaLightsAndAmbientAddsUp) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Random random(seed + 500);
        Tile tile = randomTile(seed, 3, 1e4);
        tile.sameSide = GetParam();
        tile.thickness = kThin;
        addLight(tile, distantLight(random), random);
        addLight(tile, pointLight(random), random);
        addLight(tile, spotLight(random), random);
        for (float& c : tile.ambient) c = random.floatIn(0, 2);
        expectPlainShading(tile, "seed " + std::to_string(seed));
    }
}

// Ambient alone, in one channel only: the channels do not mix.
TEST_P(ShadeTile, OfAmbientIsAlbedoTimesOpacityTimesItsRadiance) {
    Tile tile = randomTile(3, 1, 1e4);
    tile.sameSide = GetParam();
    tile.ambient[1] = 2;
    const std::vector<float> rgba = tile.shaded();
    for (std::size_t k = 0; k < kTileSize; ++k) {
        EXPECT_EQ(rgba[4 * k], 0);
        EXPECT_NEAR(rgba[4 * k + 1], -2 * tile.media[0].albedo[1] * rgba[4 * k + 3], -1e-6 * rgba[4 * k + 3]);
        EXPECT_EQ(rgba[4 * k + 2], 0);
    }
}

// Neither nothing nor far too much may spoil a picture.
TEST_P(ShadeTile, IsFiniteFromNoExtinctionToAMillion) {
    for (const float extinction : {0.0f, 1e-45f, 1e-38f, 1e-30f, 1e6f, 1e30f}) {
        Random random(1);
        Tile tile = randomTile(1, 1, 1);
        tile.sameSide = GetParam();
        std::fill_n(tile.extinction.values, kTileSize, extinction);
        std::fill_n(tile.mediaExtinction[0].values, kTileSize, extinction);
        addLight(tile, distantLight(random), random);
        addLight(tile, spotLight(random), random);
        for (float& c : tile.ambient) c = 1;
        for (const double tauIn : {0.0, 1e6}) {
            for (Row& row : tile.tauIn) std::fill_n(row.values, kTileSize, static_cast<float>(tauIn));
            for (const float v : tile.shaded()) {
                ASSERT_TRUE(std::isfinite(v)) << extinction;
                if (extinction == 0) {
                    ASSERT_EQ(v, 0);
                }
            }
            if (extinction >= 1e6f) {
                for (std::size_t k = 0; k < kTileSize; ++k) ASSERT_EQ(tile.shaded()[4 * k + 3], -1) << extinction;
            }
        }
    }
}

INSTANTIATE_TEST_SUITE_P(BothSides, ShadeTile, testing::Values(true, false),
                         [](const auto& test) { return test.param ? "sameSide" : "oppositeSides"; });

// A light inside the volume, cut as `groupLights` cuts it: over all its parts the shares of every direction must sum
// to one, or the picture would show the windows.
TEST(SplitLight, PartsAddUpToTheWholeLightInEveryDirection) {
    auto field = std::make_shared<SparseField>();
    field->tiles.push_back({Int3(-8), 16, 1.0f});
    field->activeVoxels = 16 * 16 * 16;
    ViewScene scene;
    scene.volumes.push_back({"fog", field, Mat4(1.0), {}});
    scene.region = {0, 0, 512, 512};
    scene.camera.wsPosition = {0, 0, 60};
    Light inside;
    inside.kind = Light::Point{};
    scene.lights.push_back(inside);
    scene.dials.crossFade = 0;
    std::vector<PlannedLight> parts;
    for (const GroupPlan& group :
         groupLights(scene, subLights(scene), wsCorners(scene), eyeParts(scene, wsCorners(scene)).front()))
        parts.insert(parts.end(), group.lights.begin(), group.lights.end());
    ASSERT_GT(parts.size(), 20u);

    Random random(9);
    for (int i = 0; i < 40; ++i) {
        // Sweeps along random axes, each with 256 directions within 60 degrees.
        const Vec3 axis = glm::normalize(Vec3(random.in(-1, 1), random.in(-1, 1), random.in(-1, 1)));
        const Mat3 ssFromWs = sweepRotation(axis, {0, 1, 0});
        Tile tile = randomTile(static_cast<unsigned>(i), 1, 1e-3);
        tile.media[0].phase = {};
        SheetLight light;
        auto& lamp = light.source.emplace<NearOnSheet>();
        light.shadowed = lamp.decay = false;
        lamp.texelU = 120;
        lamp.texelV = 45;
        lamp.distanceW = 10;
        tile.lights = {light};
        tile.tauIn.resize(1);
        const std::vector<float> whole = tile.shaded();
        std::vector<double> sum(kTileSize, 0.0);
        for (const PlannedLight& part : parts) {
            std::vector<Vec3> windows;
            for (const Vec3& window : part.wsWindows) windows.push_back(ssFromWs * window);
            std::get<NearOnSheet>(tile.lights[0].source).window = {&windows, part.window,
                                                                   static_cast<float>(std::cos(kWindowAngle))};
            const std::vector<float> shaded = tile.shaded();
            for (std::size_t k = 0; k < kTileSize; ++k) sum[k] += shaded[4 * k];
        }
        for (std::size_t k = 0; k < kTileSize; ++k)
            ASSERT_NEAR(sum[k], whole[4 * k], 1e-5 * whole[4 * k] + 1e-36) << "sample " << k;
    }
}

}  // namespace
}  // namespace scrim::test
