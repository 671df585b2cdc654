// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/turntable.h>

#include "unit/scene/read_scene.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

const std::string kScene =
    "[camera]\nposition = [4, 5, 3]\ntarget = [1, 2, 3]\nup = [0, 0, 2]\n[[volume]]\nfile = \"a.vdb\"\n";

std::vector<std::string> turn(const std::string& text, int frames, const std::vector<std::string>& given = {}) {
    std::vector<std::string> all = given;
    for (const std::string& more : turntableOverrides({"scene.toml", "/shots", text}, given, frames))
        all.push_back(more);
    return all;
}

TEST(Turntable, IsATrueCircleInEqualStepsAboutUp) {
    constexpr int kFrames = 24;
    const std::vector<std::string> overrides = turn(kScene, kFrames);
    const Vec3 target(1, 2, 3);
    const double radius = glm::length(Vec3(3, 3, 0));
    Vec3 before(0);
    for (int frame = 1; frame <= kFrames; ++frame) {
        const Camera camera = test::read(kScene, overrides, frame).camera;
        const Vec3 arm = camera.wsPosition - target;
        EXPECT_NEAR(glm::length(arm), radius, 1e-4) << frame;
        EXPECT_NEAR(arm.z, 0, 1e-9) << frame;
        EXPECT_NEAR(glm::length(viewingAxis(camera) + glm::normalize(arm)), 0, 1e-9) << "it looks at the target";
        if (frame > 1) {
            EXPECT_NEAR(glm::length(arm - before), 2 * radius * std::sin(M_PI / kFrames), 1e-4) << frame;
        }
        before = arm;
    }
    EXPECT_NEAR(glm::length(before - Vec3(3, 3, 0)), 2 * radius * std::sin(M_PI / kFrames), 1e-4) << "and closes";
}

TEST(Turntable, BeginsWhereTheCameraIsAndGoesToTheRight) {
    const Scene scene = test::read(kScene), first = test::read(kScene, turn(kScene, 4), 1);
    EXPECT_LT(glm::distance(scene.camera.wsPosition, first.camera.wsPosition), 1e-6);
    const Vec3 second = test::read(kScene, turn(kScene, 4), 2).camera.wsPosition;
    EXPECT_GT(glm::dot(second - scene.camera.wsPosition, scene.camera.wsFromCamera[0]), 0);
    EXPECT_TRUE(first.moves);
}

TEST(Turntable, GoesByWhatWasOverridden) {
    const std::vector<std::string> overrides = turn(kScene, 2, {"camera.target=[4, 5, 0]"});
    const Vec3 second = test::read(kScene, overrides, 2).camera.wsPosition;
    EXPECT_NEAR(glm::length(second - Vec3(4, 5, 3)), 0, 1e-4) << "above its target it only turns";
}

TEST(Turntable, TurnsAnOrbit) {
    const std::string orbit =
        "[camera]\norbit = { radius = 3, elevation = 20, azimuth = 10 }\n[[volume]]\nfile = \"a.vdb\"\n";
    const Camera turned = test::read(orbit, turn(orbit, 4), 2).camera;
    const Camera expected = test::read(orbit, {"camera.orbit.azimuth=100"}).camera;
    EXPECT_LT(glm::distance(turned.wsPosition, expected.wsPosition), 1e-12);
}

TEST(Turntable, NeedsATarget) {
    try {
        turn("[camera]\nposition = [0, 0, 1]\n", 4);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()),
                  "scene.toml:1:1: [camera] lacks 'target'; expected a point [x, y, z], to turn the camera about its "
                  "target");
    }
}

}  // namespace
}  // namespace scrim
