// SPDX-License-Identifier: Apache-2.0
// The pictures that a shot keeps from frame to frame. Those of files are tested with the formats and with shots.
#include <scrim/shot/slide_store.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>

namespace scrim::test {
namespace {

Scene under(const ClearSky& sky, int lights = 1) {
    Scene scene;
    for (int i = 0; i < lights; ++i) {
        Light& light = scene.lights.emplace_back();
        light.kind = Light::Dome{};
        light.slide.emplace();
        light.slide->sky = std::make_shared<const ClearSky>(sky);
    }
    return scene;
}

TEST(SlideStore, MakesAClearSkyOnceForAllFramesThatShowIt) {
    ::unsetenv("OCIO");
    SlideStore store(ColourConfig::open(""));
    const auto load = [&](const ClearSky& sky, int lights = 1) {
        Scene scene = under(sky, lights);
        store.loadInto(scene, {}, {}, {});
        EXPECT_EQ(scene.lights.front().slide->image, scene.lights.back().slide->image);
        EXPECT_EQ(scene.lights.front().slide->parts, scene.lights.back().slide->parts);
        EXPECT_EQ(scene.lights.front().slide->parts->suns.size(), 1u);
        return scene.lights.front().slide->image;
    };
    ClearSky sky;
    const auto first = load(sky, 2);
    EXPECT_EQ(store.bytes(), first->bytes());
    EXPECT_EQ(load(sky), first);
    sky.sunElevation = 20;
    const auto second = load(sky);
    EXPECT_NE(second, first);
    EXPECT_EQ(store.bytes(), second->bytes());  // the first is forgotten
    EXPECT_EQ(load(sky), second);
}

}  // namespace
}  // namespace scrim::test
