// SPDX-License-Identifier: Apache-2.0
// Fuzz target: any text either gives a scene, which is then within bounds, or an Error of one line that says where.
// Input: the text of a scene; what follows a NUL is an override (--set), and so on.
#include "require.h"

#include <scrim/base/error.h>
#include <scrim/image/colour.h>
#include <scrim/scene/scene_reader.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim::fuzz {
namespace {

constexpr std::size_t kLongestMessage = 4000;

void checkError(const Error& error, const std::string& what) {
    const std::string message = error.what();
    require(error.kind() == ErrorKind::input, "{}: an error of kind {}: {}", what, int(error.kind()), message);
    require(message.starts_with("fuzz.toml") || message.starts_with("--set "), "{}: no place: {}", what, message);
    require(message.find('\n') == std::string::npos, "{}: more than one line: {}", what, message);
    require(message.size() < kLongestMessage, "{}: a message of {} bytes", what, message.size());
}

bool finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool isUnit(const Vec3& v) {
    return std::abs(glm::length(v) - 1) < 1e-6;
}

void checkEmission(const Emission& emission) {
    require(!emission.grid.empty(), "emission without a grid");
    require(std::isfinite(emission.scale) && emission.scale >= 0, "emission times {}", emission.scale);
    for (std::size_t i = 0; i < emission.ramp.size(); ++i) {
        const auto& [value, colour] = emission.ramp[i];
        require(std::isfinite(value) && (i == 0 || emission.ramp[i - 1].first < value), "a ramp that does not ascend");
        require(finite(colour) && colour.r >= 0 && colour.g >= 0 && colour.b >= 0, "emission of {}, {}, {}", colour.r,
                colour.g, colour.b);
    }
}

void checkVolume(const SceneVolume& volume) {
    require(volume.file.empty() != volume.source.empty(), "a volume with both or neither of file and source");
    require(std::isfinite(volume.densityScale) && volume.densityScale >= 0, "density {}", volume.densityScale);
    for (int c = 0; c < 3; ++c) {
        require(volume.medium.albedo[c] >= 0 && volume.medium.albedo[c] <= 1, "albedo {}", volume.medium.albedo[c]);
        require(finite(volume.wsFromAsset[c]), "a transform that is not finite");
    }
    const double volumeOfUnit = glm::determinant(volume.wsFromAsset);
    require(std::isfinite(volumeOfUnit) && volumeOfUnit != 0, "a transform of determinant {}", volumeOfUnit);
    const Phase& phase = volume.medium.phase;
    require(std::abs(phase.g) < 1 && std::abs(phase.g2) < 1, "g {}, {}", phase.g, phase.g2);
    require(phase.blend >= 0 && phase.blend <= 1, "blend {}", phase.blend);
    require(finite(volume.medium.extinctionTint), "a tint that is not finite");
    require(volume.medium.octaves.count >= 1, "{} octaves", volume.medium.octaves.count);
    for (int c = 0; c < 3 && volume.albedoGrid; ++c)
        require(finite(volume.albedoGrid->workingFromGrid[c]), "a matrix of colours that is not finite");
    for (const Emission& emission : volume.emission) checkEmission(emission);
    for (std::size_t i = 0; i < volume.ramp.size(); ++i) {
        require(std::isfinite(volume.ramp[i].second) && volume.ramp[i].second >= 0, "ramp to {}",
                volume.ramp[i].second);
        require(i == 0 || volume.ramp[i - 1].first <= volume.ramp[i].first, "a ramp that descends");
    }
}

void checkLight(const Light& light) {
    require(isUnit(light.wsDirection), "a light's direction of length {}", glm::length(light.wsDirection));
    require(finite(light.wsPosition) && finite(light.wsUp), "a light that is nowhere");
    require(finite(light.intensity) && light.intensity.x >= 0 && light.intensity.y >= 0 && light.intensity.z >= 0,
            "intensity {} {} {}", light.intensity.x, light.intensity.y, light.intensity.z);
    if (light.distant()) return;
    const double radius = light.point().radius;
    require(radius >= 0 && std::isfinite(radius), "radius {}", radius);
}

void checkScene(const Scene& scene) {
    const Camera& camera = scene.camera;
    require(camera.resolution.x > 0 && camera.resolution.y > 0, "a picture without pixels");
    require(camera.fov > 0 && camera.fov < 180 && camera.height > 0 && std::isfinite(camera.height),
            "fov {}, height {}", camera.fov, camera.height);
    require(finite(camera.wsPosition), "a camera that is nowhere");
    for (int c = 0; c < 3; ++c) require(isUnit(camera.wsFromCamera[c]), "a camera's axis that is no unit vector");
    require(std::abs(glm::determinant(camera.wsFromCamera) - 1) < 1e-6, "a camera's frame that is no rotation");
    require(!scene.volumes.empty(), "no volume");
    for (const SceneVolume& volume : scene.volumes) checkVolume(volume);
    for (const Light& light : scene.lights) checkLight(light);
    require(finite(scene.ambient), "ambient light that is not finite");
}

}  // namespace
}  // namespace scrim::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace scrim;
    using namespace scrim::fuzz;
    static const ColourConfig colour = ColourConfig::open("");
    constexpr double kFrame = 7;
    std::vector<std::string> parts(1);
    for (std::size_t i = 0; i < size; ++i) {
        if (data[i] == 0)
            parts.emplace_back();
        else
            parts.back() += static_cast<char>(data[i]);
    }
    const SceneText text{"fuzz.toml", "", parts.front()};
    const std::vector<std::string> overrides(parts.begin() + 1, parts.end());
    try {
        checkScene(readScene(text, kFrame, overrides, colour));
    } catch (const Error& error) {
        checkError(error, "readScene");
        return 0;
    }
    // A scene that is read with its overrides can be printed with them, and that can be read, too.
    const std::string printed = sceneAsToml(text, overrides);
    try {
        readScene({"fuzz.toml", "", printed}, kFrame, {}, colour);
    } catch (const Error& error) {
        require(false, "printed, the scene is refused: {}\n{}", error.what(), printed);
    }
    return 0;
}
