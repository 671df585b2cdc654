// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/read_sections.h>

#include <scrim/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace scrim {
namespace {

enum class Type { distant, point, spot, projector };
const std::vector<std::string> kTypes{"distant", "point", "spot", "projector"};  // in this order

/// Colour times intensity times 2^exposure.
Rgb readIntensity(TomlTable& table, const ReadContext& context) {
    const auto colour = table.find("color");
    const Rgb rgb = colour ? colour->colourAt(context.frame, context.colour) : Rgb(1);
    const double intensity = table.numberAt(context.frame, "intensity", 1, Range::fromTo(0, 1e30));
    const double exposure = table.numberAt(context.frame, "exposure", 0, Range::fromTo(-64, 64, "stops"));
    return rgb * intensity * std::exp2(exposure);
}

/// The axis of a cone or a slide.
Vec3 readAxis(TomlTable& table, const Light& light, const ReadContext& context) {
    const auto direction = table.find("direction"), target = table.find("target");
    if (direction && target)
        target->fail(fmt::format("{} has both 'direction' and 'target'; expected one of them", table.description()));
    if (direction) return readDirection(*direction, context.frame);
    if (!target) table.require("direction", "a direction [x, y, z], or 'target', a point");
    return directionBetween(light.wsPosition, target->vec3At(context.frame, Range::coordinate()), *target,
                            "the light stands at its own 'target'", context.frame);
}

/// How large the slide's picture is: an angle, or the length of a distant light's.
void readSlideSize(TomlTable& table, const Light& light, const ReadContext& context, Slide& slide) {
    const auto fov = table.find("fov"), width = table.find("width"), height = table.find("height");
    if (!light.distant()) {
        if (const auto& length = width ? width : height)
            length->fail(fmt::format("{} has '{}'; expected 'fov', since its light comes from a point",
                                     table.description(), length->name()));
        // A spot's picture fills its cone unless it says otherwise.
        if (const Light::Spot* spot = light.spot()) slide.fov = std::min(spot->coneAngle, 179.0);
        if (fov) slide.fov = fov->numberAt(context.frame, Range::between(0, 180, "degrees"));
        return;
    }
    if (fov)
        fov->fail(fmt::format("{} has 'fov'; expected 'width' in world units, since its light is parallel",
                              table.description()));
    if (!width) table.require("width", "the width of the picture in world units");
    slide.width = width->numberAt(context.frame, Range::positiveLength());
    if (height) slide.height = height->numberAt(context.frame, Range::positiveLength());
}

Slide readSlide(TomlTable table, const Light& light, Type type, const ReadContext& context) {
    Slide slide;
    const TomlValue file = table.require("file", "the slide's picture");
    slide.where = file.where();
    slide.file = context.path(file).at(context.fileFrame());
    if (const auto space = table.find("colorspace")) {
        try {
            slide.colorspace = context.colour.resolve(space->string());
        } catch (const Error& error) {
            space->fail(error.what());
        }
    }
    readSlideSize(table, light, context, slide);
    slide.roll = table.numberAt(context.frame, "roll", 0, Range::coordinate());
    // A projector has no light but its picture's.
    std::vector<std::string> outside{"black"};
    if (type != Type::projector) outside.insert(outside.end(), {"clamp", "repeat"});
    slide.outside = static_cast<SlideOutside>(table.choice("outside", outside, 0));
    table.finish();
    return slide;
}

}  // namespace

Light readLight(TomlTable table, const std::string& defaultName, const ReadContext& context) {
    Light light;
    light.name = readName(table, defaultName);
    table.require("type", choices(kTypes));
    const auto type = static_cast<Type>(table.choice("type", kTypes, 0));
    table.describe(fmt::format("{} of type '{}'", table.description(), kTypes[std::size_t(type)]));

    if (type == Type::projector) table.require("slide", "a table { file = \"...\" }: what it projects");
    const auto slide = table.find("slide");
    if (type == Type::distant) {
        light.wsDirection =
            readDirection(table.require("direction", "the way the light travels [x, y, z]"), context.frame);
        if (slide)
            light.wsPosition = table.require("position", "the centre of its slide [x, y, z]")
                                   .vec3At(context.frame, Range::coordinate());
    } else {
        light.wsPosition = table.require("position", "a point [x, y, z]").vec3At(context.frame, Range::coordinate());
        Light::Spot spot;
        spot.radius = table.numberAt(context.frame, "radius", 0, Range::length());
        spot.decay = table.choice("decay", {"inverse-square", "none"}, 0) == 0;
        if (type == Type::spot || slide) light.wsDirection = readAxis(table, light, context);
        if (type == Type::spot) {
            spot.coneAngle = table.numberAt(context.frame, "cone", spot.coneAngle,
                                            {0, 180, true, false, "degrees (the full angle)"});
            spot.blend = table.numberAt(context.frame, "blend", spot.blend, Range::fromTo(0, 1));
            light.kind = spot;
        } else {
            light.kind = Light::Point(spot);
        }
    }
    if (slide) {
        if (const auto up = table.find("up")) light.wsUp = readDirection(*up, context.frame);
        light.slide = readSlide(slide->table("'slide' of " + table.description()), light, type, context);
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
