// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/read_sections.h>

#include <fmt/format.h>

#include <cmath>

namespace scrim {
namespace {

const std::vector<std::string> kTypes{"distant", "point", "spot"};  // in the order of LightType

/// Colour times intensity times 2^exposure.
Rgb readIntensity(TomlTable& table, const ReadContext& context) {
    const auto colour = table.find("color");
    const Rgb rgb = colour ? colour->colourAt(context.frame, context.colour) : Rgb(1);
    const double intensity = table.numberAt(context.frame, "intensity", 1, Range::fromTo(0, 1e30));
    const double exposure = table.numberAt(context.frame, "exposure", 0, Range::fromTo(-64, 64, "stops"));
    return rgb * intensity * std::exp2(exposure);
}

/// The axis of a spot light's cone.
Vec3 readAxis(TomlTable& table, const Light& light, const ReadContext& context) {
    const auto direction = table.find("direction"), target = table.find("target");
    if (direction && target)
        target->fail(fmt::format("{} has both 'direction' and 'target'; expected one of them", table.description()));
    if (direction) return readDirection(*direction, context.frame);
    if (!target) table.require("direction", "a direction [x, y, z], or 'target', a point");
    return directionBetween(light.wsPosition, target->vec3At(context.frame, Range::coordinate()), *target,
                            "the light stands at its own 'target'", context.frame);
}

}  // namespace

Light readLight(TomlTable table, const std::string& defaultName, const ReadContext& context) {
    Light light;
    light.name = readName(table, defaultName);
    table.require("type", "'distant', 'point' or 'spot'");
    light.type = static_cast<LightType>(table.choice("type", kTypes, 0));
    table.describe(fmt::format("{} of type '{}'", table.description(), kTypes[static_cast<std::size_t>(light.type)]));

    if (light.type == LightType::distant) {
        light.wsDirection =
            readDirection(table.require("direction", "the way the light travels [x, y, z]"), context.frame);
    } else {
        light.wsPosition = table.require("position", "a point [x, y, z]").vec3At(context.frame, Range::coordinate());
        light.radius = table.numberAt(context.frame, "radius", 0, Range::length());
        light.decay = table.choice("decay", {"inverse-square", "none"}, 0) == 0;
    }
    if (light.type == LightType::spot) {
        light.wsDirection = readAxis(table, light, context);
        light.coneAngle =
            table.numberAt(context.frame, "cone", light.coneAngle, {0, 180, true, false, "degrees (the full angle)"});
        light.blend = table.numberAt(context.frame, "blend", light.blend, Range::fromTo(0, 1));
    }
    light.intensity = readIntensity(table, context);
    light.shadows = table.boolean("shadows", true);
    table.finish();
    return light;
}

Rgb readAmbient(TomlTable table, const ReadContext& context) {
    const auto colour = table.find("color"), intensity = table.find("intensity");
    table.finish();
    // An empty [ambient] is no light; either of the two alone has a natural partner.
    if (!colour && !intensity) return Rgb(0);
    const Rgb rgb = colour ? colour->colourAt(context.frame, context.colour) : Rgb(1);
    return rgb * (intensity ? intensity->numberAt(context.frame, Range::fromTo(0, 1e30)) : 1.0);
}

}  // namespace scrim
