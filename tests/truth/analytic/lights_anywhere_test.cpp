// SPDX-License-Identifier: Apache-2.0
// Lights and eyes where the paper has none (its limits in sections 4 and 6): on both sides at once, inside, many; and
// fields of view too wide for one sweep. Where views are cut into parts, the cuts must not show.
#include "support/verified.h"

#include <scrim/engine/plan/sheet_stack.h>
#include <scrim/geometry/camera.h>
#include <scrim/verify/reference.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

ViewScene smokeScene() {
    Medium medium;
    medium.densityScale = 0.12;
    return orthographicScene(smokeField(22), medium, 54, 64);
}

TEST(LightsAnywhere, InFrontAndBehindAtOnceAgreeWithBruteForce) {
    ViewScene scene = smokeScene();
    scene.lights = {distantLight({0.3, -0.4, -1}, 2), distantLight({-0.4, -0.2, 1}, 3)};
    EXPECT_GE(makePlan(scene, 1).groups.size(), 2U);
    expectConvergence(scene, 60, 1, 0.008);
}

TEST(LightsAnywhere, NineAllRoundAreTheSumOfEachAlone) {
    ViewScene scene = smokeScene();
    const double golden = 2.399963;
    for (int i = 0; i < 9; ++i) {
        const double z = 1 - 2 * (i + 0.5) / 9, r = std::sqrt(1 - z * z);
        scene.lights.push_back(distantLight({r * std::cos(golden * i), r * std::sin(golden * i), z}, 1));
        scene.lights.back().name = "light" + std::to_string(i);
    }
    const Frame together = renderScene(scene);
    std::vector<double> sum(together.image.rgba.size());
    for (const Light& light : scene.lights) {
        ViewScene alone = scene;
        alone.lights = {light};
        const Frame frame = renderScene(alone);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += frame.image.rgba[i];
    }
    double squares = 0, total = 0, count = 0;
    for (std::size_t i = 0; i < sum.size(); ++i) {
        if (i % 4 == 3) continue;
        squares += std::pow(sum[i] - together.image.rgba[i], 2);
        total += sum[i];
        ++count;
    }
    // They differ by the errors of different axes only.
    EXPECT_LT(std::sqrt(squares / count) / (total / count), 0.03);
    expectConvergence(scene, 40, 1, 0.006);
}

TEST(LightsAnywhere, InsideTheSmokeAgreesWithBruteForce) {
    ViewScene scene = smokeScene();
    scene.lights = {lamp({2, 1, -1}, 300, 4)};
    expectConvergence(scene, 60, 1, 0.005);
}

TEST(LightsAnywhere, VeryNearTheSmokeAgreesWithBruteForce) {
    ViewScene scene = smokeScene();
    scene.lights = {lamp({0, 25, 0}, 1000, 2)};
    expectConvergence(scene, 60, 1, 0.01);
}

// Even fog around a lamp looks the same all round it: windows of directions that overlapped badly would show as spokes.
TEST(SplitLight, ShowsNoSeams) {
    Medium medium;
    medium.densityScale = 0.01;
    const auto ball =
        makeField(Int3(-26), Int3(26), 1, [](const Vec3& is) { return std::clamp(24.5 - glm::length(is), 0.0, 1.0); });
    ViewScene scene = orthographicScene(ball, medium, 54, 108);
    scene.lights = {lamp({0, 0, 0}, 1000, 3)};
    const Frame frame = renderScene(scene);
    for (const double radius : {6.0, 10.0, 15.0, 20.0}) {
        double sum = 0, least = 1e30, most = 0;
        constexpr int kAround = 90;
        for (int i = 0; i < kAround; ++i) {
            const double angle = 2 * std::acos(-1.0) * i / kAround;
            // Bilinear between pixels, whose centres are half a unit apart.
            const double x = 54 + 2 * radius * std::cos(angle) - 0.5, y = 54 + 2 * radius * std::sin(angle) - 0.5;
            const int ix = static_cast<int>(x), iy = static_cast<int>(y);
            const double fx = x - ix, fy = y - iy;
            const double value =
                (1 - fy) * ((1 - fx) * pixelOf(frame, ix, iy)[0] + fx * pixelOf(frame, ix + 1, iy)[0]) +
                fy * ((1 - fx) * pixelOf(frame, ix, iy + 1)[0] + fx * pixelOf(frame, ix + 1, iy + 1)[0]);
            sum += value;
            least = std::min(least, value);
            most = std::max(most, value);
        }
        RecordProperty("unevennessAt" + std::to_string(int(radius)), std::to_string((most - least) * kAround / sum));
        EXPECT_LT((most - least) * kAround / sum, 0.03) << "radius " << radius;
    }
}

ViewScene wideScene(double fov) {
    ViewScene scene = smokeScene();
    scene.camera.type = CameraType::perspective;
    scene.camera.wsPosition = {1, 2, 9};
    scene.camera.fov = fov;
    scene.volumes[0].medium.densityScale = 0.05;
    scene.lights = {distantLight({1, -1, -0.4}, 2)};
    scene.ambient = Rgb(0.1);
    return scene;
}

TEST(WideEye, IsSweptInPartsThatAgreeWithBruteForce) {
    ViewScene scene = wideScene(150);
    EXPECT_GT(makePlan(scene, 1).eyeParts.size(), 1U);
    expectConvergence(scene, 60, 1, kFloor);
}

TEST(WideEye, WeightsOfItsPartsSumToOne) {
    ViewScene scene = wideScene(140);
    const std::vector<EyePart> parts = eyeParts(scene, wsCorners(scene));
    ASSERT_GT(parts.size(), 1U);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            double sum = 0;
            for (const EyePart& part : parts)
                if (part.window.contains(x, y)) sum += part.weight(x + 0.5, y + 0.5);
            ASSERT_NEAR(sum, 1, 1e-12) << x << "," << y;
        }
}

// Even haze, seen from inside.
TEST(WideEye, ShowsNoSeams) {
    Medium medium;
    medium.densityScale = 0.05;
    ViewScene scene = orthographicScene(boxField(Int3(-40), Int3(39)), medium, 20, 96);
    scene.camera.type = CameraType::perspective;
    scene.camera.wsPosition = {0, 0, 0};
    scene.camera.fov = 150;
    scene.ambient = Rgb(1);
    const Frame frame = renderScene(scene);
    ASSERT_GT(makePlan(scene, 1).eyeParts.size(), 1U);
    // Errors change smoothly from pixel to pixel, across the cuts, too.
    const Reference reference(scene);
    double before = 0, largest = 0;
    for (int x = 0; x < 96; ++x) {
        const double error = pixelOf(frame, x, 48)[3] - reference.pixel(x, 48)[3];
        if (x > 0) largest = std::max(largest, std::abs(error - before));
        before = error;
    }
    EXPECT_LT(largest, 0.005);
    expectConvergence(scene, 40, 1, kFloor);
}

TEST(WideEye, CropsHaveThePixelsOfTheWholePicture) {
    ViewScene scene = wideScene(150);
    const Frame whole = renderScene(scene);
    scene.region = {20, 10, 50, 40};
    const Frame crop = renderScene(scene);
    for (int y = 10; y < 40; ++y)
        for (int x = 20; x < 50; ++x) ASSERT_EQ(pixelOf(crop, x, y), pixelOf(whole, x, y)) << x << "," << y;
}

}  // namespace
}  // namespace scrim::test
