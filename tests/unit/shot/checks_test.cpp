// SPDX-License-Identifier: Apache-2.0
// What a program puts into a scene by itself is held to the ranges of files, and whatever fails is an Error.
#include <scrim/scrim.h>

#include <scrim/shot/bake_shot.h>

#include "support/expect_error.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace scrim::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Change = std::function<void(Scene&)>;

SparseField fog() {
    FieldBuilder builder("density", Mat4(1.0));
    builder.addBlock(Int3(0), std::vector<float>(kBlockVoxels, 1.0f).data());
    return builder.finish();
}

Scene plainScene() {
    Scene scene;
    scene.camera.wsPosition = {0, 0, 30};
    scene.camera.resolution = {16, 12};
    scene.volumes.resize(1);
    scene.volumes[0].name = "fog";
    scene.lights.resize(1);
    scene.lights[0].name = "key";
    return scene;
}

Shot plainShot() {
    Shot shot = Shot::make(plainScene());
    shot.setVolume("fog", {fog()});
    return shot;
}

/// Both ways into the library: a scene that is built so, and one that is changed so while it renders.
void expectRefused(const std::string& message, const Change& change) {
    Scene built = plainScene();
    change(built);
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { Shot::make(built); }), message);
    Shot shot = plainShot();
    RenderOptions options;
    options.change = change;
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { shot.render(1, options); }), message);
}

Change dials(const std::function<void(Dials&)>& change) {
    return [=](Scene& scene) { change(scene.dials); };
}
Change light(const std::function<void(Light&)>& change) {
    return [=](Scene& scene) { change(scene.lights[0]); };
}
Change volume(const std::function<void(SceneVolume&)>& change) {
    return [=](Scene& scene) { change(scene.volumes[0]); };
}

TEST(Checks, DialsAreHeldToTheirTable) {
    expectRefused("[render]: 'antialias' is 0; expected a whole number from 1 to 16 (rays a pixel's edge)",
                  dials([](Dials& d) { d.antialias = 0; }));
    expectRefused("[render]: 'antialias' is 100000; expected a whole number from 1 to 16 (rays a pixel's edge)",
                  dials([](Dials& d) { d.antialias = 100000; }));
    expectRefused("[render]: 'sheet_thickness' is -1; expected a number from 0.01 to 64 (voxels)",
                  dials([](Dials& d) { d.sheetThickness = -1; }));
    expectRefused("[render]: 'footprint_steps' is 1048576; expected a power of two from 2 to 128 (steps a voxel)",
                  dials([](Dials& d) { d.footprintSteps = 1 << 20; }));
    expectRefused("[render]: 'texel' is nan; expected a number from 0.05 to 64 (voxels)",
                  dials([](Dials& d) { d.texel = kNan; }));
    expectRefused("[render]: 'lod' is inf; expected 'auto', or a number from 0 to 64 (pixels)",
                  dials([](Dials& d) { d.lod = kInfinity; }));
    expectRefused("[render]: 'shutter_samples' is 0; expected 'auto', or a whole number from 1 to 1024 (renders)",
                  dials([](Dials& d) { d.shutterSamples = 0; }));
    expectRefused("[render]: 'simd' is 'mmx'; expected 'auto', 'sse4', 'avx2' or 'avx512'",
                  dials([](Dials& d) { d.simd = "mmx"; }));
}

TEST(Checks, CamerasAreHeldToTheirKeys) {
    expectRefused("[camera]: 'fov' is 180; expected a number greater than 0 and less than 180 degrees",
                  [](Scene& s) { s.camera.fov = 180; });
    expectRefused(
        "[camera]: 'position' is 0, nan, 0; expected a point [x, y, z], each from -1e+15 to 1e+15 world units",
        [](Scene& s) {
            s.camera.wsPosition = {0, kNan, 0};
        });
    expectRefused("[camera]: 'matrix' is not orthonormal; expected three perpendicular axes of length 1",
                  [](Scene& s) { s.camera.wsFromCamera[0] *= 2.0; });
    expectRefused("[camera]: 'matrix' is mirrored; expected a right-handed frame",
                  [](Scene& s) { s.camera.wsFromCamera[0] *= -1.0; });
    expectRefused("[camera]: 'resolution' is 16, 0; expected [width, height] in pixels, each from 1 to 65536 pixels",
                  [](Scene& s) { s.camera.resolution.y = 0; });
    expectRefused("[camera]: 'overscan' is -20; expected a number from 0 to 65536 pixels",
                  [](Scene& s) { s.overscan = -20; });
    expectRefused("[camera]: 'shutter' is [0.5, 0]; expected [open, close] with open < close", [](Scene& s) {
        s.shutter = Shutter{0.5, 0};
    });
    expectRefused("[camera]: 'height' is 0; expected a number greater than 0 and of at most 1e+15 world units",
                  [](Scene& s) {
                      s.camera.type = CameraType::orthographic;
                      s.camera.height = 0;
                  });
}

TEST(Checks, LightsAreHeldToTheirKeys) {
    expectRefused("light 'key': 'direction' is 0, 0, 0; expected a direction of length 1",
                  light([](Light& l) { l.wsDirection = Vec3(0); }));
    expectRefused("light 'key': 'up' is nan, 0, 0; expected a direction", light([](Light& l) {
                      l.wsUp = {kNan, 0, 0};
                  }));
    for (const double value : {kNan, kInfinity})
        expectRefused(
            fmt::format("light 'key': 'intensity' is 1, {}, 1; expected finite numbers with a sum of at least 0",
                        value),
            light([=](Light& l) { l.intensity.y = value; }));
    expectRefused("light 'key': 'angle' is 200; expected a number from 0 to 180 degrees",
                  light([](Light& l) { l.kind = Light::Distant(200); }));
    expectRefused("light 'key': 'cone' is 0; expected a number greater than 0 and of at most 180 degrees",
                  light([](Light& l) {
                      Light::Spot spot;
                      spot.coneAngle = 0;
                      l.kind = spot;
                  }));
    expectRefused("light 'key': 'samples' is -3; expected a number from 1 to 4096",
                  light([](Light& l) { l.samples = -3; }));
    expectRefused("[ambient]: 'color' is -1, -1, -1; expected finite numbers with a sum of at least 0",
                  [](Scene& s) { s.ambient = Rgb(-1); });
}

TEST(Checks, MeshesAreHeldToTheirKeys) {
    expectRefused("mesh 'card': 'albedo' is 0, 1.5, 0; expected numbers from 0 to 1", [](Scene& s) {
        s.meshes.push_back({});
        s.meshes.back().name = "card";
        s.meshes.back().albedo = {0, 1.5, 0};
    });
}

TEST(Checks, VolumesAreHeldToTheirKeys) {
    expectRefused("volume 'fog': 'scale' is nan; expected a number from 0 to 1e+30 per world unit",
                  volume([](SceneVolume& v) { v.densityScale = kNan; }));
    expectRefused("volume 'fog': 'albedo' is 2, 0, 0; expected numbers from 0 to 1", volume([](SceneVolume& v) {
                      v.medium.albedo = {2, 0, 0};
                  }));
    expectRefused("volume 'fog': 'g' is 1; expected a number greater than -1 and less than 1",
                  volume([](SceneVolume& v) { v.medium.phase.g = 1; }));
    expectRefused(
        "volume 'fog': 'matrix' is not an invertible affine matrix; expected a matrix with an inverse and the last row "
        "0, 0, 0, 1",
        volume([](SceneVolume& v) { v.wsFromAsset[1] = glm::dvec4(0); }));
    expectRefused("volume 'fog': 'ramp' is above 0 at grid value 0; expected 0 there, because empty space is skipped",
                  volume([](SceneVolume& v) {
                      v.ramp = {{0, 1}, {1, 2}};
                  }));
    expectRefused("volume 'fog': 'ramp' is 1 at its point 2; expected ascending values", volume([](SceneVolume& v) {
                      v.ramp = {{1, 0}, {1, 2}};
                  }));
    expectRefused("volume 'fog': 'transfer' is 0 points; expected at least two",
                  volume([](SceneVolume& v) { v.classified = std::make_shared<const Classified>(); }));
    expectRefused("volume 'fog': 'count' is 0; expected a number from 1 to 16",
                  volume([](SceneVolume& v) { v.medium.octaves.count = 0; }));
}

TEST(Checks, OutputsAreChecked) {
    expectRefused("[output]: 'fps' is 0; expected a number greater than 0 and of at most 1000000 frames a second",
                  [](Scene& s) { s.output.fps = 0; });
}

TEST(Checks, OptionsAreNumbers) {
    Shot shot = plainShot();
    RenderOptions options;
    options.verify = -1;
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { shot.render(1, options); }),
              "RenderOptions::verify is -1; expected a number of at least 0");
    options = {};
    options.previewExposure = kNan;
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { shot.plan(1, options); }),
              "RenderOptions::previewExposure is nan; expected a number");
    options = {};
    options.tolerance = kNan;
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { shot.render(1, options); }),
              "[render]: 'tolerance' is nan; expected a number from 0 to 1 as relative RMSE; 0 for none");
}

TEST(Checks, WantOfMemoryIsAnError) {
    Shot shot = plainShot();
    RenderOptions options;
    options.change = [](Scene&) { throw std::bad_alloc(); };
    EXPECT_EQ(errorOf(ErrorKind::memory, [&] { shot.render(1, options); }), "out of memory");
    EXPECT_EQ(errorOf(ErrorKind::memory, [&] { bakeShot(shot, 1, {}, options); }), "out of memory");
    options.change = [](Scene&) { std::vector<double>().reserve(std::vector<double>().max_size() + 1); };
    EXPECT_EQ(errorOf(ErrorKind::memory, [&] { shot.plan(1, options); }),
              "out of memory: a single allocation exceeds the address space");
}

TEST(Checks, LightBeyondFloatsIsAnError) {
    Shot shot = plainShot();
    RenderOptions options;
    options.change = [](Scene& scene) { scene.lights[0].intensity = Rgb(0, 1e45, 0); };
    const std::string message = errorOf(ErrorKind::render, [&] { shot.render(3, options); });
    EXPECT_EQ(message.rfind("frame 3: 'G' is ", 0), 0u) << message;
}

// The checks hold for what readers make, too: none of them may refuse what a scene usually is.
TEST(Checks, PlainScenesPass) {
    Shot shot = plainShot();
    const std::vector<float> pixels = shot.render(1).image().rgba;
    EXPECT_TRUE(std::all_of(pixels.begin(), pixels.end(), [](float v) { return std::isfinite(v); }));
    EXPECT_GT(*std::max_element(pixels.begin(), pixels.end()), 0.1f);
}

}  // namespace
}  // namespace scrim::test
