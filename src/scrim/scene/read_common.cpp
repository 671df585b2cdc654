// SPDX-License-Identifier: Apache-2.0
// Readers that several sections of a scene share: paths, directions, names.
#include <scrim/scene/read_sections.h>

#include <scrim/scene/nearest_name.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#define GLM_ENABLE_EXPERIMENTAL  // glm::rotation
#include <glm/geometric.hpp>
#include <glm/gtx/quaternion.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

/// The unit vector along `v`. It is scaled first, so that squares neither underflow nor overflow.
Vec3 unit(const Vec3& v) {
    return glm::normalize(v / largest(glm::abs(v)));
}

}  // namespace

FramePath ReadContext::path(const TomlValue& value, const std::string& pattern) const {
    return {folder, expandVariables(pattern, variables, value.where())};
}

int ReadContext::fileFrame() const {
    return static_cast<int>(std::lround(wholeFrame));
}

Vec3 readDirection(const TomlValue& value, double frame) {
    const Vec3 v = value.vec3At(frame);
    if (v == Vec3(0)) value.fail(fmt::format("'{}' is 0, 0, 0 at frame {}; expected a direction", value.name(), frame));
    return unit(v);
}

Vec3 directionBetween(const Vec3& from, const Vec3& to, const TomlValue& value, const std::string& problem,
                      double frame) {
    const Vec3 v = to - from;
    if (v == Vec3(0)) value.fail(fmt::format("{} at frame {} ({}, {}, {})", problem, frame, from.x, from.y, from.z));
    return unit(v);
}

Mat3 wsFromOrbit(const Vec3& up) {
    return glm::mat3_cast(glm::rotation(Vec3(0, 1, 0), up));  // the shortest rotation
}

Orbit readOrbit(const TomlValue& value, const std::string& of, const Vec3& up, bool needsRadius,
                const ReadContext& context) {
    const OrbitKeys& k = keysOf<OrbitKeys>();
    TomlTable table = value.table(fmt::format("'{}' of {}", value.name(), of));
    Orbit orbit;
    if (const auto center = table.find(k.center)) orbit.wsCenter = center->vec3At(context.frame);
    if (needsRadius) orbit.radius = table.require(k.radius).numberAt(context.frame);
    table.find(k.radius);
    const double elevation = glm::radians(table.numberAt(context.frame, k.elevation));
    const double azimuth = glm::radians(table.numberAt(context.frame, k.azimuth));
    table.finish();
    const Vec3 local(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                     std::cos(elevation) * std::cos(azimuth));
    orbit.toPlace = wsFromOrbit(up) * local;
    return orbit;
}

std::string nameIn(const TomlValue& value) {
    const std::string name = value.string();
    const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
    if (std::any_of(name.begin(), name.end(), control)) value.failExpecting("a name without control characters");
    return name;
}

std::string nameAmong(const TomlValue& value, const Key& key, const std::vector<std::string>& names) {
    std::string name = value.string();
    if (std::find(names.begin(), names.end(), name) == names.end())
        value.fail(fmt::format("there is no {} '{}'{}; expected {}", key.name, shortened(name, 60),
                               didYouMean(name, names), shortened(choices(names))));
    return name;
}

std::string readName(TomlTable& table, const Key& key, const std::string& defaultName) {
    const auto value = table.find(key);
    const std::string name = value ? nameIn(*value) : defaultName;
    table.describe(fmt::format("{} '{}'", table.description(), name));
    return name;
}

}  // namespace scrim
