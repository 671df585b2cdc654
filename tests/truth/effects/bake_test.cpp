// SPDX-License-Identifier: Apache-2.0
// Baked light: what arrives at voxels, against closed forms and brute force; and as emission it is the picture.
#include "scenes.h"
#include "support/expect_error.h"
#include "support/luminaires.h"

#include <scrim/base/error.h>
#include <scrim/engine/baked_light.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/verify/reference.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include <glm/exponential.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

std::vector<BakedVolume> bakeAll(const ViewScene& scene) {
    return bakeLight(scene, std::vector<bool>(scene.lights.size(), true), true, false, 2);
}

struct Voxel {
    Vec3 is;
    std::size_t block;
    int offset;
};

std::vector<Voxel> voxelsOf(const BakedVolume& baked) {
    std::vector<Voxel> voxels;
    for (std::size_t b = 0; b < baked.blockOrigins.size(); ++b)
        for (int i = 0; i < kBlockVoxels; ++i)
            if (baked.active[b][std::size_t(i)])
                voxels.push_back({Vec3(baked.blockOrigins[b]) + Vec3(i / 64, i / 8 % 8, i % 8), b, i});
    return voxels;
}

Rgb at(const std::vector<float>& values, const Voxel& voxel) {
    const float* own = values.data() + voxel.block * 3 * kBlockVoxels + voxel.offset;
    return {own[0], own[kBlockVoxels], own[2 * kBlockVoxels]};
}

// A slab of 20 voxels, lit from above: its top voxel at z = 9 has half a voxel of smoke before it, by its tent.
TEST(BakedLight, OfASlabIsBeersLaw) {
    Medium medium;
    medium.densityScale = 0.2;
    medium.extinctionTint = {1, 0.5, 0};
    for (const double slant : {0.0, 0.75}) {
        ViewScene scene = orthographicScene(boxField({-60, -60, -10}, {59, 59, 9}), medium, 20, 9);
        scene.lights = {distantLight(glm::normalize(Vec3(slant, 0, -1)), 3)};
        const BakedVolume baked = bakeAll(scene).at(0);
        const double path = std::sqrt(1 + slant * slant);
        int looked = 0;
        for (const Voxel& voxel : voxelsOf(baked)) {
            if (std::max(std::abs(voxel.is.x), std::abs(voxel.is.y)) > 30) continue;  // no light from the sides
            const double tau = 0.2 * path * (9.5 - voxel.is.z);
            for (int c = 0; c < 3; ++c) {
                const double expected = 3 * std::exp(-tau * medium.extinctionTint[c]);
                ASSERT_NEAR(at(baked.lights.at(0), voxel)[c], expected, 0.02 * expected) << voxel.is.z << " " << c;
            }
            ++looked;
        }
        EXPECT_EQ(looked, 61 * 61 * 20);
    }
}

// A slab of voxels of 1 below one of voxels of 3, which is 9 thick.
TEST(BakedLight, OfSlabsOfUnlikeVoxelsIsBeersLaw) {
    Medium medium;
    medium.densityScale = 0.1;
    ViewScene scene = orthographicScene(boxField({-40, -40, -10}, {39, 39, 9}), medium, 20, 9);
    ViewVolume upper = scene.volumes.front();
    upper.name = "upper";
    upper.place = 1;
    const auto field = boxField({-20, -20, 10}, {19, 19, 12});
    upper.field = field;
    upper.wsFromIs = glm::scale(Mat4(1.0), Vec3(3)) * field->wsFromIs;
    upper.medium.densityScale = 0.05;
    scene.volumes.push_back(upper);
    scene.lights = {distantLight({0, 0, -1}, 3)};
    const std::vector<BakedVolume> baked = bakeAll(scene);
    const auto inside = [](const Voxel& voxel, double most) {
        return std::max(std::abs(voxel.is.x), std::abs(voxel.is.y)) <= most;
    };
    int looked = 0;
    for (const Voxel& voxel : voxelsOf(baked.at(0))) {
        if (!inside(voxel, 30)) continue;
        const double expected = 3 * std::exp(-0.1 * (9.5 - voxel.is.z) - 0.05 * 9);
        ASSERT_NEAR(at(baked[0].lights.at(0), voxel).x, expected, 0.02 * expected) << voxel.is.z;
        ++looked;
    }
    EXPECT_EQ(looked, 61 * 61 * 20);
    for (const Voxel& voxel : voxelsOf(baked.at(1))) {
        if (!inside(voxel, 15)) continue;
        const double expected = 3 * std::exp(-0.05 * 3 * (12.5 - voxel.is.z));
        ASSERT_NEAR(at(baked[1].lights.at(0), voxel).x, expected, 0.02 * expected) << voxel.is.z;
    }
}

TEST(BakedLight, OfALampFallsOffWithTheSquareOfDistance) {
    Medium medium;
    medium.densityScale = 1e-6;
    ViewScene scene = orthographicScene(boxField(Int3(-10), Int3(10)), medium, 20, 9);
    for (const Vec3& place : {Vec3(3, 14, 30), Vec3(0.3, 0.2, 0.4)}) {  // the second stands within
        scene.lights = {lamp(place, 100, 0.5)};
        const BakedVolume baked = bakeAll(scene).at(0);
        for (const Voxel& voxel : voxelsOf(baked)) {
            const double distance = glm::distance(voxel.is, place);
            if (distance < 1) continue;
            const double expected = 100 / (distance * distance);
            ASSERT_NEAR(at(baked.lights.at(0), voxel).x, expected, 2e-3 * expected) << voxel.is.x << " " << voxel.is.y;
        }
    }
}

ViewScene sceneOf(const std::string& name) {
    if (name == "lamp within" || name == "luminaire within" || name == "sphere" || name == "sun with an angle") {
        ViewScene scene = plainScene();
        scene.lights.resize(1);
        if (name == "lamp within") {
            scene.lights.push_back(lamp({2, 5, -3}, 300, 1));
            scene.lights.back().name = "lamp";
        } else if (name == "luminaire within") {
            scene.lights.push_back(lamp({2, 5, -3}, 300, 1));
            scene.lights.back().name = "lamp";
            scene.lights.back().luminaire = luminaireOf("wall");
        } else {
            Light& light = scene.lights[0];
            light.samples = 64;
            light.intensity = Rgb(2, 1, 0.5);
            if (name == "sphere") {
                light.kind = Light::Area{AreaShape::sphere, 1, 1, 12};
                light.wsPosition = {40, 30, 20};
            } else {
                light.kind = Light::Distant(20);
            }
        }
        return scene;
    }
    const bool full = name == "full";
    ViewScene scene = sceneWith(full ? "ambient" : name);
    for (ViewVolume& volume : scene.volumes) {
        volume.medium.phase = {};
        if (full) volume.medium.scattering = Scattering::full;
    }
    return scene;
}

class Baked : public testing::TestWithParam<std::string> {};

// What the reference makes of a voxel is all of its sources; light by light it is what arrives.
TEST_P(Baked, AgreesWithBruteForce) {
    ViewScene scene = sceneOf(GetParam());
    for (ViewVolume& volume : scene.volumes) volume.emission.clear();
    scene.dials.texel = scene.dials.sheetThickness = 0.7;
    const std::vector<BakedVolume> baked = bakeAll(scene);
    std::mt19937 random(7);
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        // One volume scatters, all of them shadow.
        ViewScene alone = scene;
        for (std::size_t w = 0; w < scene.volumes.size(); ++w)
            if (w != v) {
                alone.volumes[w].medium.albedo = Rgb(0);
                alone.volumes[w].scatter.clear();
            }
        const std::vector<Voxel> voxels = voxelsOf(baked[v]);
        for (std::size_t l = 0; l <= scene.lights.size(); ++l) {
            const bool all = l == scene.lights.size();
            ViewScene truth = alone;
            if (!all) {
                for (std::size_t other = 0; other < scene.lights.size(); ++other)
                    if (other != l) truth.lights[other].intensity = Rgb(0);
                truth.ambient = Rgb(0);
                truth.volumes[v].medium.octaves = {};
                truth.volumes[v].medium.albedo = Rgb(1);
                truth.volumes[v].scatter.clear();
            }
            const std::vector<float>& values = all ? baked[v].scattered : baked[v].lights[l];
            const ViewVolume& volume = scene.volumes[v];
            EXPECT_EQ(values.empty(), !all && !volume.lights.empty() && !volume.lights[l]);
            if (values.empty()) continue;
            const Reference reference(truth);
            double square = 0, mean = 0;
            for (int i = 0; i < 60; ++i) {
                const Voxel& voxel = voxels[random() % voxels.size()];
                const Vec3 ws = transformPoint(volume.wsFromIs, voxel.is);
                const Reference::Sample sample = reference.sample(ws, {0, 0, -1});
                Rgb expected = sample.source;
                const double own =
                    volume.medium.densityScale * FieldSampler(*volume.field, Kernel::linear).voxel(Int3(voxel.is));
                if (!all) expected *= 4 * kPi / (own * glm::max(volume.medium.extinctionTint, 1e-9));
                const Rgb error = at(values, voxel) - expected;
                square += glm::dot(error, error) / 3 / 60;
                mean += (expected.x + expected.y + expected.z) / 3 / 60;
            }
            std::printf("%s, volume %zu, %s: %.2f %%\n", GetParam().c_str(), v,
                        all ? "scattered" : scene.lights[l].name.c_str(), 100 * std::sqrt(square) / mean);
            EXPECT_LT(std::sqrt(square), 0.02 * mean) << "volume " << v << ", light " << l;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Each, Baked,
                         testing::Values("ambient", "coloured extinction", "two tints", "albedo grid", "octaves",
                                         "light linking", "shadow linking", "lamp within", "luminaire within", "sphere",
                                         "sun with an angle"));

// A renderer that shows the baked light as emission, with the same extinction and without any light, shows the picture.
TEST(BakedLight, AsEmissionIsThePicture) {
    for (const char* name :
         {"ambient", "coloured extinction", "albedo grid", "octaves", "light linking", "shadow linking", "full"}) {
        ViewScene scene = sceneOf(name);
        scene.dials.texel = scene.dials.sheetThickness = 0.7;
        const Frame picture = renderScene(scene);
        const std::vector<BakedVolume> baked = bakeAll(scene);
        ViewScene shown = scene;
        shown.lights.clear();
        shown.ambient = Rgb(0);
        for (std::size_t v = 0; v < baked.size(); ++v) {
            ViewVolume& volume = shown.volumes[v];
            volume.lights.clear();
            volume.scatter.clear();
            volume.medium.albedo = Rgb(0);
            volume.medium.scattering = Scattering::single;
            for (int c = 0; c < 3; ++c) {
                auto field = std::make_shared<SparseField>(*volume.field);
                auto values = std::shared_ptr<float[]>(new float[baked[v].blockOrigins.size() * kBlockVoxels]);
                field->blockOrigins = baked[v].blockOrigins;
                for (std::size_t b = 0; b < field->blockCount(); ++b)
                    std::copy_n(baked[v].scattered.data() + (3 * b + std::size_t(c)) * kBlockVoxels, kBlockVoxels,
                                values.get() + b * kBlockVoxels);
                field->blockValues = std::shared_ptr<const float>(values, values.get());
                Rgb colour(0);
                colour[c] = 1;
                volume.emission.push_back({{field, volume.wsFromIs}, colour});
            }
        }
        const Frame again = renderScene(shown);
        const PixelWindow& window = picture.image.window;
        double square = 0, mean = 0, count = 0;
        for (int y = window.y0; y + 8 <= window.y1; y += 8)
            for (int x = window.x0; x + 8 <= window.x1; x += 8)
                for (int c = 0; c < 3; ++c) {
                    double a = 0, b = 0;
                    for (int j = 0; j < 8; ++j)
                        for (int i = 0; i < 8; ++i) {
                            a += pixelOf(picture, x + i, y + j)[std::size_t(c)] / 64;
                            b += pixelOf(again, x + i, y + j)[std::size_t(c)] / 64;
                        }
                    square += (a - b) * (a - b);
                    mean += a;
                    ++count;
                }
        const double error = std::sqrt(square / count) / (mean / count);
        std::printf("%s: %.2f %%\n", name, 100 * error);
        EXPECT_LT(error, 0.02) << name;
    }
}

// The divergence of the flux of light that has scattered is what becomes such light less what extinction takes of it:
// div 4 pi H = sigma_s (E + 4 pi J) - sigma_t 4 pi J (S. Chandrasekhar, Radiative Transfer, 1950). Both sides are
// weighted with a bell inside of the medium, and the divergence is moved to the bell.
TEST(BakedLight, FluxOfIndirectLightIsWhatScatteringMakesAndExtinctionTakes) {
    constexpr double kSigma = 0.12, kAlbedo = 0.9, kWidth = 4;
    for (const double g : {0.0, 0.6, 0.85}) {
        Medium medium;
        medium.densityScale = kSigma;
        medium.albedo = Rgb(kAlbedo);
        medium.scattering = Scattering::full;
        medium.phase = Phase{g};
        ViewScene scene = orthographicScene(boxField({-20, -20, -20}, {19, 19, 19}), medium, 20, 9);
        scene.lights = {distantLight(glm::normalize(Vec3(1, -2, -3)), 3)};
        scene.dials.scatterCell = 2;
        const BakedVolume baked = bakeLight(scene, {true}, false, true, 2).at(0);
        for (const Vec3& center : {Vec3(0), Vec3(5, -3, 2), Vec3(-4, 6, 6)}) {
            double divergence = 0, change = 0, made = 0;
            for (const Voxel& voxel : voxelsOf(baked)) {
                const Vec3 way = voxel.is - center;
                const double bell = std::exp(-glm::dot(way, way) / (2 * kWidth * kWidth));
                const double mean = 4 * kPi * at(baked.indirect, voxel).x, direct = at(baked.lights[0], voxel).x;
                divergence += glm::dot(way / (kWidth * kWidth) * bell, 4 * kPi * at(baked.flux[0], voxel));
                change += bell * kSigma * (kAlbedo * (direct + mean) - mean);
                made += bell * kSigma * kAlbedo * (direct + mean);
            }
            std::printf("g = %g: %.4f of %.4f\n", g, divergence / made, change / made);
            EXPECT_NEAR(divergence, change, 0.01 * made) << "g = " << g;
        }
    }
}

TEST(BakedLight, IndirectIsOnlyWhereLightScattersMoreThanOnce) {
    ViewScene scene = plainScene();
    const auto bake = [&] { return bakeLight(scene, {true, true}, false, true, 2).at(0); };
    EXPECT_TRUE(bake().indirect.empty());
    scene.volumes[0].medium.scattering = Scattering::full;
    const BakedVolume baked = bake();
    EXPECT_TRUE(baked.scattered.empty());
    ViewScene dark = scene;
    for (Light& light : dark.lights) light.intensity = Rgb(0);
    const BakedVolume black = bakeLight(dark, {true, true}, false, true, 2).at(0);
    EXPECT_EQ(black.indirect, std::vector<float>(baked.indirect.size()));
    EXPECT_EQ(black.flux[0], black.indirect);
    for (const Voxel& voxel : voxelsOf(baked))
        for (int c = 0; c < 3; ++c) {
            const double mean = at(baked.indirect, voxel)[c];
            ASSERT_GT(mean, 0);
            ASSERT_LE(glm::length(at(baked.flux[std::size_t(c)], voxel)), 1.0001 * mean);
        }
}

// Cells keep all directions for it, which light that is scattered evenly does not need otherwise.
TEST(BakedLight, FluxCountsAgainstTheMemoryLimit) {
    ViewScene scene = plainScene();
    scene.volumes[0].medium.phase = {};
    scene.volumes[0].medium.scattering = Scattering::full;
    const std::size_t bytes = planTransport(scene, true).bytes;
    EXPECT_GT(bytes, 2 * planTransport(scene).bytes);
    scene.memoryLimit = bytes - 1;
    EXPECT_NO_THROW(bakeLight(scene, {true, true}, true, false, 2));
    try {
        bakeLight(scene, {true, true}, false, true, 2);
        ADD_FAILURE() << "no limit";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::memory) << error.what();
    }
}

TEST(BakedLight, ThatIsNotWantedIsNotThere) {
    const ViewScene scene = plainScene();
    const BakedVolume baked = bakeLight(scene, {false, true}, false, false, 2).at(0);
    EXPECT_TRUE(baked.lights.at(0).empty());
    EXPECT_FALSE(baked.lights.at(1).empty());
    EXPECT_TRUE(baked.scattered.empty());
}

TEST(BakedLight, IsCutFromTiles) {
    Medium medium;
    ViewScene scene = plainScene();
    auto field = std::make_shared<SparseField>();
    field->tiles = {{{0, 0, 0}, 16, 0.05f}};
    field->activeVoxels = 16 * 16 * 16;
    field->maxValue = 0.05f;
    scene.volumes[0].field = field;
    scene.volumes[0].medium = medium;
    scene.lights = {distantLight({0, 0, -1}, 1)};
    const BakedVolume baked = bakeAll(scene).at(0);
    ASSERT_EQ(baked.blockOrigins.size(), 8u);
    for (const Voxel& voxel : voxelsOf(baked)) {
        if (std::min(voxel.is.x, voxel.is.y) < 2 || std::max(voxel.is.x, voxel.is.y) > 13) continue;
        const double expected = std::exp(-0.05 * (15.5 - voxel.is.z));
        ASSERT_NEAR(at(baked.lights[0], voxel).x, expected, 0.01 * expected);
    }
}

TEST(BakedLight, RefusesConstantRegionsThatNoMachineHasMemoryFor) {
    for (const int edge : {4096 * 2, 16384, 1 << 20}) {
        auto field = std::make_shared<SparseField>();
        field->name = "density";
        field->tiles = {{{0, 0, 0}, edge, 0.05f}};
        field->maxValue = 0.05f;
        ViewScene scene = orthographicScene(field, {0.2, Rgb(0.9), {}}, 20, 9);
        scene.lights = {distantLight({0, 0, -1}, 3)};
        EXPECT_EQ(errorOf(ErrorKind::memory, [&] { bakeAll(scene); }),
                  fmt::format("grid 'density' has {:.3g} voxels, with those in constant regions; at most 6.87e+10 can "
                              "be baked",
                              std::pow(double(edge), 3)));
    }
}

}  // namespace
}  // namespace scrim::test
