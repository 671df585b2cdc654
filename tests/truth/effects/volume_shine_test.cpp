// SPDX-License-Identifier: Apache-2.0
// The light that volumes send to surfaces: closed forms of balls and blocks, and what a camera at the surface sees.
#include "scenes.h"
#include "support/meshes.h"

#include <scrim/engine/light/volume_shine.h>
#include <scrim/engine/plan/transport_plan.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRadius = 20;

std::shared_ptr<const SparseField> ball(double value = 1) {
    return makeField(Int3(-24), Int3(24), 1,
                     [=](const Vec3& p) { return value * std::clamp(kRadius + 0.5 - glm::length(p), 0.0, 1.0); });
}

// The sum of its voxels.
double sizeOf(const SparseField& field) {
    double sum = 0;
    for (std::size_t i = 0; i < field.blockCount() * kBlockVoxels; ++i) sum += field.blockValues.get()[i];
    return sum;
}

ViewScene glowing(const std::shared_ptr<const SparseField>& field, const Rgb& color) {
    ViewScene scene;
    ViewVolume volume;
    volume.field = field;
    volume.medium.densityScale = 0;
    volume.medium.albedo = Rgb(0);
    volume.emission = {{{field, Mat4(1.0)}, color}};
    scene.volumes = {volume};
    return scene;
}

ViewScene litBall(double sigma, const Rgb& albedo) {
    ViewScene scene;
    ViewVolume volume;
    volume.field = ball();
    volume.medium.densityScale = sigma;
    volume.medium.albedo = albedo;
    scene.volumes = {volume};
    scene.lights = {distantLight({0, 0, -1}, 3)};
    return scene;
}

VolumeShine shineOf(const ViewScene& scene) {
    return VolumeShine(scene, planTransport(withScatteredApart(scene)), [] {});
}

Rgb irradiance(const ViewScene& scene, const Vec3& ws, const Vec3& normal) {
    return shineOf(scene).irradiance(ws, normal);
}

// Outside of a ball that sends the same from everywhere, 1 / r^2 adds up to that of its middle.
TEST(VolumeShine, OfAGlowingBallIsThatOfAPoint) {
    const auto field = ball();
    const Rgb color(1, 0.5, 0.25);
    const ViewScene scene = glowing(field, color);
    const VolumeShine shine = shineOf(scene);
    for (const double away : {1.2, 2.0, 5.0, 40.0, 1000.0})
        for (const Vec3& side : {Vec3(0, 0, -1), Vec3(0.6, 0, -0.8), Vec3(0.3, 0.8, -0.52)}) {
            const Vec3 ws = away * kRadius * glm::normalize(side), normal(0, 0, 1);
            const double true_ = sizeOf(*field) / glm::dot(ws, ws) * -glm::normalize(side).z;
            // Near the ball it fills most of what the surface sees.
            if (away < 1.5 && side.x > 0) continue;
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(shine.irradiance(ws, normal)[c] / (true_ * color[c]), 1, 0.06) << away << " " << side.x;
        }
    EXPECT_LT(shine.irradiance({0, 0, -3 * kRadius}, {0, 0, -1}).x, 1e-3 * sizeOf(*field) / (9 * kRadius * kRadius))
        << "it is behind the surface";
}

// Deep in a block that emits and absorbs, radiance is their ratio from all sides.
TEST(VolumeShine, WithinAnOpaqueBlockIsThatOfABlackBody) {
    const auto field = boxField(Int3(-40), Int3(40));
    ViewScene scene = glowing(field, Rgb(0.3));
    scene.volumes[0].medium.densityScale = 0.3;
    EXPECT_NEAR(irradiance(scene, Vec3(0.3, 0.2, 0.1), {0, 0, 1}).x / kPi, 1, 0.01);
    // At its face, one side is dark and the other as before.
    EXPECT_NEAR(irradiance(scene, Vec3(0, 0, 40), {0, 0, -1}).x / kPi, 1, 0.06);
    EXPECT_LT(irradiance(scene, Vec3(0, 0, 46), {0, 0, 1}).x, 0.02);
}

// So thin that it takes no light: what it scatters is that of a point, by the phase function.
TEST(VolumeShine, OfAThinBallInTheSunFollowsThePhaseFunction) {
    constexpr double kThin = 1e-4;
    ViewScene scene = litBall(kThin, {0.8, 0.4, 0.2});
    const double sent = 3 * kThin * sizeOf(*scene.volumes[0].field);
    for (const double g : {0.0, 0.5, -0.4}) {
        scene.volumes[0].medium.phase = Phase{g};
        const VolumeShine shine = shineOf(scene);
        for (const Vec3& side : {Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(0, 0.6, 0.8)}) {
            const Vec3 ws = 5 * kRadius * side;
            const double phase = phaseValue(scene.volumes[0].medium.phase, -side.z);
            const double true_ = sent * phase / glm::dot(ws, ws);
            EXPECT_NEAR(shine.irradiance(ws, -side).x / (0.8 * true_), 1, 0.07) << g << " " << side.z;
            EXPECT_NEAR(shine.irradiance(ws, -side).z / (0.2 * true_), 1, 0.07) << g << " " << side.z;
        }
    }
    scene.volumes[0].lights = {false};
    EXPECT_EQ(irradiance(scene, {0, 0, -100}, {0, 0, 1}), Rgb(0)) << "the light does not light the volume";
}

// The irradiance by what a camera at `ws` sees around `normal`; everything that shines is in its view.
double seenFrom(ViewScene scene, const Vec3& ws, const Vec3& normal) {
    constexpr int kRays = 64;
    scene.camera = Camera();
    scene.camera.wsPosition = ws;
    scene.camera.wsFromCamera = frameAround(-normal);
    scene.camera.fov = 90;
    scene.camera.resolution = {kRays, kRays};
    scene.region = scene.picture = {0, 0, kRays, kRays};
    const Frame frame = renderScene(scene);
    double sum = 0;
    for (int y = 0; y < kRays; ++y)
        for (int x = 0; x < kRays; ++x) {
            const double u = (2 * x + 1.0) / kRays - 1, v = (2 * y + 1.0) / kRays - 1;
            const double cosine2 = 1 / (1 + u * u + v * v);  // the solid angle of a pixel has its power 3/2
            sum += pixelOf(frame, x, y)[0] * cosine2 * cosine2 * 4 / (kRays * kRays);
        }
    return sum;
}

TEST(VolumeShine, IsWhatACameraAtTheSurfaceSees) {
    for (const double sigma : {0.02, 0.1}) {
        for (const bool full : {false, true}) {
            ViewScene scene = litBall(sigma, Rgb(0.9));
            if (full) scene.volumes[0].medium.scattering = Scattering::full;
            scene.volumes[0].emission = {{{scene.volumes[0].field, Mat4(1.0)}, Rgb(0.002)}};
            for (const Vec3& side : {Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(0, 0.6, 0.8)}) {
                const Vec3 ws = 2.5 * kRadius * side;
                // Cones blur what is dense, and so the dark side of a ball that is 4 mean free paths thick.
                const double most = sigma < 0.05 ? 0.06 : side.z < -0.5 ? 0.3 : 0.14;
                EXPECT_NEAR(irradiance(scene, ws, -side).x / seenFrom(scene, ws, -side), 1, most)
                    << sigma << " " << full << " " << side.z;
            }
        }
    }
}

TEST(VolumeShine, IsHeldBackBySolidsAndByOtherVolumes) {
    ViewScene scene = glowing(ball(), Rgb(1));
    const Vec3 ws(0, 0, -100), up(0, 0, 1);
    const double open = irradiance(scene, ws, up).x;
    scene.solids = std::make_shared<Solids>(std::vector{
        Solid{"shade", squareMesh({0, 0, -50}, {0, 0, 1}, 100), Mat4(1.0), true, true, false, Rgb(0), Rgb(1)}});
    EXPECT_EQ(irradiance(scene, ws, up), Rgb(0));
    EXPECT_GT(irradiance(scene, -ws, -up).x, 0.9 * open);
    scene.solids = nullptr;
    ViewVolume haze;
    haze.field = boxField(Int3(-30), Int3(30));
    haze.wsFromIs = glm::translate(Mat4(1.0), Vec3(0, 0, -60));
    haze.medium.densityScale = 0.02;
    haze.medium.albedo = Rgb(0);
    scene.volumes.push_back(haze);
    // 60 units of it, and those of it that are in the ball.
    EXPECT_NEAR(irradiance(scene, ws, up).x / open, std::exp(-0.02 * 61), 0.1 * std::exp(-0.02 * 61));
}

// A surface shows its colour of it, as the picture of a glowing ball over a floor has it.
TEST(Backdrop, IsLitByVolumesThatGlow) {
    ViewScene scene = haze(0.0);
    scene.lights.clear();
    const auto field = ball();
    scene.volumes[0].medium.albedo = Rgb(0);
    ViewVolume volume = glowing(field, Rgb(1)).volumes[0];
    volume.wsFromIs = glm::translate(Mat4(1.0), Vec3(100, 0, 60));  // beside what is seen
    volume.emission[0].field.wsFromIs = volume.wsFromIs;
    scene.volumes.push_back(volume);
    scene.layers = {Layer::backdrop};
    const Rgb red(0.8, 0.3, 0.1);
    scene.solids = std::make_shared<Solids>(
        std::vector{Solid{"floor", squareMesh(Vec3(0), {0, 0, 1}, 300), Mat4(1.0), true, true, false, Rgb(0), red}});
    const auto seen = pixelOf(renderScene(scene), 10, 10);
    const double r2 = 100 * 100 + 60 * 60, true_ = sizeOf(*field) / r2 * 60 / std::sqrt(r2) / kPi;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[std::size_t(c)] / (red[c] * true_), 1, 0.08) << c;
    EXPECT_EQ(seen[3], 1);
}

}  // namespace
}  // namespace scrim::test
