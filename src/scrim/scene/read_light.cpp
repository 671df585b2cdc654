// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/read_sections.h>

#include <scrim/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace scrim {
namespace {

const LightKeys& k = keysOf<LightKeys>();

enum class Type { distant, point, spot, projector };  // in the order of the key's words

/// Colour times intensity times 2^exposure.
Rgb readIntensity(TomlTable& table, const ReadContext& context) {
    const auto colour = table.find(k.color);
    const Rgb rgb = colour ? colour->colourAt(context.frame, context.colour) : Rgb(1);
    const double intensity = table.numberAt(context.frame, k.intensity);
    return rgb * intensity * std::exp2(table.numberAt(context.frame, k.exposure));
}

/// The axis of a cone or a slide.
Vec3 readAxis(TomlTable& table, const Light& light, const ReadContext& context) {
    const auto direction = table.find(k.direction), target = table.find(k.target);
    if (direction) return readDirection(*direction, context.frame);
    if (!target) table.require(k.direction, fmt::format("{}, or {}, {}", k.direction.form, k.target, k.target.form));
    return directionBetween(light.wsPosition, target->vec3At(context.frame), *target,
                            fmt::format("the light stands at its own {}", k.target), context.frame);
}

/// How large the slide's picture is: an angle, or the length of a distant light's.
void readSlideSize(TomlTable& table, const Light& light, const ReadContext& context, Slide& slide) {
    const SlideKeys& s = keysOf<SlideKeys>();
    const auto fov = table.find(s.fov), width = table.find(s.width), height = table.find(s.height);
    if (!light.distant()) {
        if (const auto& length = width ? width : height)
            length->fail(fmt::format("{} has '{}'; expected {}, since its light comes from a point",
                                     table.description(), length->name(), s.fov));
        // A spot's picture fills its cone unless it says otherwise.
        if (const Light::Spot* spot = light.spot()) slide.fov = std::min(spot->coneAngle, 179.0);
        if (fov) slide.fov = fov->numberAt(context.frame);
        return;
    }
    if (fov)
        fov->fail(fmt::format("{} has {}; expected {} in world units, since its light is parallel", table.description(),
                              s.fov, s.width));
    if (!width) table.require(s.width);
    slide.width = width->numberAt(context.frame);
    if (height) slide.height = height->numberAt(context.frame);
}

Slide readSlide(TomlTable table, const Light& light, Type type, const ReadContext& context) {
    const SlideKeys& s = keysOf<SlideKeys>();
    Slide slide;
    const TomlValue file = table.require(s.file);
    slide.where = file.where();
    slide.file = context.path(file).at(context.fileFrame());
    if (const auto space = table.find(s.colorspace)) {
        try {
            slide.colorspace = context.colour.resolve(space->string());
        } catch (const Error& error) {
            space->fail(error.what());
        }
    }
    readSlideSize(table, light, context, slide);
    slide.roll = table.numberAt(context.frame, s.roll);
    if (const auto outside = table.find(s.outside)) {
        // A projector has no light but its picture's.
        const std::vector<std::string> black{s.outside.words.front()};
        slide.outside = static_cast<SlideOutside>(type == Type::projector ? outside->choice(black) : outside->choice());
    }
    table.finish();
    return slide;
}

/// Where a distant light comes from, and the middle of its slide.
void readDistant(TomlTable& table, bool hasSlide, const Vec3& up, const ReadContext& context, Light& light) {
    const auto direction = table.find(k.direction), orbit = table.find(k.orbit);
    if (!orbit) {
        light.wsDirection = readDirection(table.require(k.direction), context.frame);
        if (hasSlide) light.wsPosition = table.require(k.position).vec3At(context.frame);
        return;
    }
    if (direction)
        direction->fail(
            fmt::format("{} has both {} and {}; expected one of them", table.description(), k.direction, k.orbit));
    const Orbit o = readOrbit(*orbit, table.description(), up, false, context);
    light.wsDirection = -o.toPlace;
    light.wsPosition = o.wsCenter;
}

/// Point, spot and projector.
void readNear(TomlTable& table, Type type, bool hasSlide, const Vec3& up, const ReadContext& context, Light& light) {
    const auto orbit = table.find(k.orbit);
    Vec3 wsCenter(0);
    if (orbit) {
        const Orbit o = readOrbit(*orbit, table.description(), up, true, context);
        wsCenter = o.wsCenter;
        light.wsPosition = o.wsCenter + o.radius * o.toPlace;
    } else {
        light.wsPosition = table.require(k.position).vec3At(context.frame);
    }
    Light::Spot spot;
    spot.radius = table.numberAt(context.frame, k.radius);
    spot.decay = table.choice(k.decay) == 0;
    if (type == Type::spot || hasSlide) {
        const bool aimed = table.find(k.direction).has_value() || table.find(k.target).has_value();
        light.wsDirection = orbit && !aimed
                                ? directionBetween(light.wsPosition, wsCenter, *orbit,
                                                   "the light stands in the middle of its orbit", context.frame)
                                : readAxis(table, light, context);
    }
    if (type != Type::spot) {
        light.kind = Light::Point(spot);
        return;
    }
    spot.coneAngle = table.numberAt(context.frame, k.cone);
    spot.blend = table.numberAt(context.frame, k.blend);
    light.kind = spot;
}

}  // namespace

Light readLight(TomlTable table, const std::string& defaultName, const ReadContext& context) {
    Light light;
    light.name = readName(table, k.name, defaultName);
    table.require(k.type);
    const auto type = static_cast<Type>(table.choice(k.type));
    table.describe(fmt::format("{} of type '{}'", table.description(), k.type.words[std::size_t(type)]));

    if (type == Type::projector) table.require(k.slide, "a table { file = \"...\" }: what it projects");
    const auto slide = table.find(k.slide), orbit = table.find(k.orbit);
    if (slide || orbit)
        if (const auto up = table.find(k.up)) light.wsUp = readDirection(*up, context.frame);
    if (type == Type::distant)
        readDistant(table, slide.has_value(), light.wsUp, context, light);
    else
        readNear(table, type, slide.has_value(), light.wsUp, context, light);
    if (slide)
        light.slide =
            readSlide(slide->table(fmt::format("{} of {}", k.slide, table.description())), light, type, context);
    light.intensity = readIntensity(table, context);
    light.shadows = table.boolean(k.shadows);
    table.finish();
    return light;
}

Rgb readAmbient(TomlTable table, const ReadContext& context) {
    const AmbientKeys& a = keysOf<AmbientKeys>();
    const auto colour = table.find(a.color), intensity = table.find(a.intensity);
    table.finish();
    // An empty [ambient] is no light; either of the two alone has a natural partner.
    if (!colour && !intensity) return Rgb(0);
    const Rgb rgb = colour ? colour->colourAt(context.frame, context.colour) : Rgb(1);
    return rgb * (intensity ? intensity->numberAt(context.frame) : 1.0);
}

}  // namespace scrim
