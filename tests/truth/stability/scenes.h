// SPDX-License-Identifier: Apache-2.0
// What the hard cases share: a small scene rendered in every way the engine knows, the same scene elsewhere, and how
// far two pictures are apart.
#pragma once

#include "support/fields.h"

#include <scrim/geometry/camera.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include <gtest/gtest.h>

namespace scrim::test {

/// A way through the engine: which splats, where light is added up, and what kind of volume.
struct Way {
    const char* name;
    SplatMode splat;
    ShadeMode shade;
    bool classified;
};
inline void PrintTo(const Way& way, std::ostream* out) {
    *out << way.name;
}

inline constexpr Way kTexels{"texels", SplatMode::shared, ShadeMode::texel, false};
inline constexpr Way kPixels{"pixels", SplatMode::shared, ShadeMode::pixel, false};
inline constexpr Way kAutomatic{"automatic", SplatMode::shared, ShadeMode::automatic, false};
inline constexpr Way kPerView{"perView", SplatMode::perView, ShadeMode::automatic, false};
inline constexpr Way kSurface{"classified", SplatMode::shared, ShadeMode::automatic, true};
inline constexpr Way kSurfacePerView{"classifiedPerView", SplatMode::perView, ShadeMode::automatic, true};

inline std::string nameOfWay(const testing::TestParamInfo<Way>& info) {
    return info.param.name;
}

/// A medium's scene on this way.
inline void take(const Way& way, ViewScene& scene) {
    scene.dials.splat = way.splat;
    scene.dials.shade = way.shade;
    if (!way.classified) return;
    for (ViewVolume& volume : scene.volumes) {
        Classified look;
        look.transfer = {{0.05, Rgb(0.3, 0.5, 1), 0}, {0.6, Rgb(1, 0.8, 0.4), 1}, {1, Rgb(1), 1}};
        look.densityScale = 2 * volume.medium.densityScale;
        volume.classified = std::make_shared<const Classified>(look);
    }
}

inline void look(ViewScene& scene, const Vec3& from, const Vec3& to, double fov) {
    scene.camera.type = CameraType::perspective;
    scene.camera.wsPosition = from;
    scene.camera.wsFromCamera = lookAt(from, to, {0, 1, 0});
    scene.camera.fov = fov;
}

/// Three soft balls of no symmetry within 21 voxels: so smooth that one texel a voxel resolves them well.
inline std::shared_ptr<SparseField> smoothField() {
    return makeField(Int3(-10), Int3(10), 1, [](const Vec3& is) {
        const auto ball = [&](const Vec3& middle, double width) {
            return std::exp(-glm::dot(is - middle, is - middle) / (2 * width * width));
        };
        const double sum = ball({-3, 2, 1}, 2.5) + 0.7 * ball({3, -2, 2}, 2.2) + 0.5 * ball({1, 3, -4}, 2);
        return sum > 1e-3 ? sum : 0;
    });
}

/// Smoke of 19 voxels (rough: of details as large as a voxel), or another field, seen in perspective, under a distant
/// light and a lamp that is so far away that its light is of one piece.
inline ViewScene smallScene(const Way& way, int resolution = 32,
                            std::shared_ptr<const SparseField> field = smokeField(9)) {
    Medium medium;
    medium.densityScale = 0.3;
    medium.phase.g = 0.2;
    ViewScene scene = orthographicScene(std::move(field), medium, 24, resolution);
    look(scene, {9.1, 13.3, 42.7}, {0.1, 0, 0}, 32);
    scene.lights = {distantLight({-1, -0.6, -0.7}, 2), lamp({40.3, 50.1, 30.7}, 6000)};
    scene.ambient = Rgb(0.05);
    take(way, scene);
    return scene;
}

/// The whole scene under p -> scale * rotation * p + shift, with what makes it look the same: extinction over `scale`,
/// intensities of lamps times its square. `rotation` is orthonormal and right-handed.
inline ViewScene moved(ViewScene scene, double scale, const Mat3& rotation, const Vec3& shift) {
    const auto place = [&](const Vec3& p) { return scale * (rotation * p) + shift; };
    Mat4 ws(rotation * scale);
    ws[3] = glm::dvec4(shift, 1);
    for (ViewVolume& volume : scene.volumes) {
        volume.wsFromIs = ws * volume.wsFromIs;
        volume.medium.densityScale /= scale;
        if (!volume.classified) continue;
        Classified look = *volume.classified;
        look.densityScale /= scale;
        volume.classified = std::make_shared<const Classified>(look);
    }
    for (Light& light : scene.lights) {
        light.wsPosition = place(light.wsPosition);
        light.wsDirection = rotation * light.wsDirection;
        light.wsUp = rotation * light.wsUp;
        if (light.distant()) continue;
        light.point().radius *= scale;
        if (light.point().decay) light.intensity *= scale * scale;
    }
    scene.camera.wsPosition = place(scene.camera.wsPosition);
    scene.camera.wsFromCamera = rotation * scene.camera.wsFromCamera;
    scene.camera.height *= scale;
    scene.camera.near *= scale;
    return scene;
}

inline double brightest(const Image& image) {
    return *std::max_element(image.rgba.begin(), image.rgba.end());
}

inline double largestDifference(const Image& a, const Image& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i) {
        const double difference = std::abs(double(a.rgba[i]) - double(b.rgba[i]));
        if (std::isnan(difference)) return difference;
        most = std::max(most, difference);
    }
    return most;
}

/// The largest difference over the brightest value of `a`; also in the test's report.
inline double changeOf(const std::string& what, const Image& a, const Image& b) {
    const double change = largestDifference(a, b) / brightest(a);
    testing::Test::RecordProperty(what, std::to_string(change * 1e6) + " millionths");
    return change;
}

/// Is every value finite, colour not negative, and alpha in [0, 1] to the rounding of its sum over sweeps?
inline testing::AssertionResult sane(const Image& image) {
    for (std::size_t i = 0; i < image.rgba.size(); ++i) {
        const float v = image.rgba[i];
        if (!std::isfinite(v) || v < 0 || (i % 4 == 3 && v > 1 + 3e-7f))
            return testing::AssertionFailure()
                   << "channel " << i % 4 << " of pixel " << i / 4 % static_cast<std::size_t>(image.window.width())
                   << "," << i / 4 / static_cast<std::size_t>(image.window.width()) << " is " << v;
    }
    return testing::AssertionSuccess();
}

}  // namespace scrim::test
