// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/turntable.h>

#include <scrim/scene/read_sections.h>
#include <scrim/scene/scene_keys.h>
#include <scrim/scene/toml_document.h>
#include <scrim/scene/toml_reader.h>
#include <scrim/scene/toml_text.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {

std::vector<std::string> turntableOverrides(const SceneText& text, const std::vector<std::string>& overrides,
                                            int frames) {
    toml::table root = parseToml(text.text, text.file);
    for (const std::string& assignment : overrides) applyOverride(root, assignment);
    const SceneKeys& scene = keysOf<SceneKeys>();
    const CameraKeys& k = keysOf<CameraKeys>();
    const OrbitKeys& o = keysOf<OrbitKeys>();
    TomlTable camera =
        TomlTable(root, "the scene's top level").require(scene.camera, "a table [camera]").table("[camera]");
    const auto turning = [&](double from) {
        const double begin = std::round(from * 1e6) / 1e6;  // degrees
        return fmt::format("{{ keys = [[1, {}], [{}, {}]] }}", begin, frames + 1, begin + 360);
    };
    const std::string orbitPath = fmt::format("{}.{}", scene.camera.name, k.orbit.name);
    if (const auto orbit = camera.find(k.orbit)) {
        const double azimuth = orbit->table("'orbit'").numberAt(1, o.azimuth);
        return {fmt::format("{}.{}={}", orbitPath, o.azimuth.name, turning(azimuth))};
    }
    const auto pointOf = [&](const Key& key) {
        return camera.require(key, key.form + ", to turn the camera about its target").vec3At(1);
    };
    const Vec3 position = pointOf(k.position), target = pointOf(k.target);
    const auto up = camera.find(k.up);
    // The way from the target to the camera, in the orbit's frame.
    const Vec3 arm = (position - target) * wsFromOrbit(up ? readDirection(*up, 1) : Vec3(0, 1, 0));
    const double radius = glm::length(arm);
    const double elevation = radius > 0 ? glm::degrees(std::asin(std::clamp(arm.y / radius, -1.0, 1.0))) : 0;
    return {fmt::format("{}={{ {} = [{}, {}, {}], {} = {}, {} = {}, {} = {} }}", orbitPath, o.center.name, target.x,
                        target.y, target.z, o.radius.name, tomlSignificant(radius, 9), o.elevation.name,
                        tomlSignificant(elevation, 9), o.azimuth.name,
                        turning(glm::degrees(std::atan2(arm.x, arm.z))))};
}

}  // namespace scrim
