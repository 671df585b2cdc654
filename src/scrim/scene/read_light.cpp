// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/read_sections.h>

#include <scrim/base/error.h>
#include <scrim/image/blackbody.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace scrim {

Slide readPicture(TomlTable& table, const Key& fileKey, const Key& spaceKey, const ReadContext& context) {
    Slide slide;
    const TomlValue file = table.require(fileKey);
    slide.where = file.where();
    slide.file = context.path(file).at(context.fileFrame());
    if (const auto space = table.find(spaceKey)) {
        try {
            slide.colorspace = context.colour.resolve(space->string());
        } catch (const Error& error) {
            space->fail(error.what());
        }
    }
    return slide;
}

namespace {

const LightKeys& k = keysOf<LightKeys>();

enum class Type { distant, point, spot, projector, area, dome };  // in the order of the key's words

/// Reads colour * intensity * 2^exposure.
Rgb readIntensity(TomlTable& table, const ReadContext& context) {
    const auto colour = table.find(k.color);
    const Rgb rgb = colour ? colour->colourAt(context.frame, context.colour) : Rgb(1);
    const double intensity = table.numberAt(context.frame, k.intensity);
    Rgb tint(1);
    if (const auto value = table.find(k.temperature)) {
        const double kelvin = value->numberAt(context.frame);
        tint = located(*value, [&] { return Blackbody(context.colour).colour(kelvin); });
    }
    return rgb * tint * intensity * std::exp2(table.numberAt(context.frame, k.exposure));
}

/// Reads the axis of a cone or a slide.
Vec3 readAxis(TomlTable& table, const Light& light, const ReadContext& context) {
    const auto direction = table.find(k.direction), target = table.find(k.target);
    if (direction) return readDirection(*direction, context.frame);
    if (!target) table.require(k.direction, fmt::format("{}, or {}, {}", k.direction.form, k.target, k.target.form));
    return directionBetween(light.wsPosition, target->vec3At(context.frame), *target,
                            fmt::format("the light is at the same point as its {}", k.target), context.frame);
}

/// Reads the size of the slide's picture: an angle, or the width and height of a distant light's slide.
void readSlideSize(TomlTable& table, const Light& light, const ReadContext& context, Slide& slide) {
    const SlideKeys& s = keysOf<SlideKeys>();
    const auto fov = table.find(s.fov), width = table.find(s.width), height = table.find(s.height);
    if (!light.distant()) {
        if (const auto& length = width ? width : height)
            length->fail(fmt::format("{} has '{}'; expected {}, since its light comes from a point",
                                     table.description(), length->name(), s.fov));
        // A spot's picture fills its cone unless the scene states an angle.
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
    Slide slide = readPicture(table, s.file, s.colorspace, context);
    if (light.area()) {
        table.finish();  // no further keys: the picture fills the rectangle
        return slide;
    }
    readSlideSize(table, light, context, slide);
    slide.roll = table.numberAt(context.frame, s.roll);
    if (const auto outside = table.find(s.outside)) {
        // Outside of its picture a projector sends no light.
        const std::vector<std::string> black{s.outside.words.front()};
        slide.outside = static_cast<SlideOutside>(type == Type::projector ? outside->choice(black) : outside->choice());
    }
    table.finish();
    return slide;
}

/// Reads the angle under which the sun's disk is seen.
void readAngle(TomlTable& table, const std::optional<TomlValue>& slide, const ReadContext& context, Light& light) {
    light.kind = Light::Distant{table.numberAt(context.frame, k.angle)};
    if (light.extended() && slide)
        slide->fail(fmt::format("{} has both {} and {}; expected one of them: the light of a slide is parallel",
                                table.description(), k.angle, k.slide));
}

/// Reads the direction of a distant light and the centre of its slide.
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

/// Reads the place of a light that is not distant. Returns the centre of its orbit, if it has one.
std::optional<Vec3> readPlace(TomlTable& table, const std::optional<TomlValue>& orbit, const ReadContext& context,
                              Light& light) {
    if (!orbit) {
        light.wsPosition = table.require(k.position).vec3At(context.frame);
        return std::nullopt;
    }
    const Orbit o = readOrbit(*orbit, table.description(), light.wsUp, true, context);
    light.wsPosition = o.wsCenter + o.radius * o.toPlace;
    return o.wsCenter;
}

/// Reads the direction that the light faces: the one stated, or else towards the centre of its orbit.
void readFacing(TomlTable& table, const std::optional<TomlValue>& orbit, const std::optional<Vec3>& wsCenter,
                const ReadContext& context, Light& light) {
    const bool aimed = table.find(k.direction).has_value() || table.find(k.target).has_value();
    light.wsDirection = orbit && !aimed ? directionBetween(light.wsPosition, *wsCenter, *orbit,
                                                           "the light is at the center of its orbit", context.frame)
                                        : readAxis(table, light, context);
}

/// Reads the photometric file of the luminaire around a point or a spot.
void readLuminaire(TomlTable& table, const ReadContext& context, Light& light) {
    const auto file = table.find(k.ies);
    if (!file) return;
    light.luminaire = Luminaire{context.path(*file).at(context.fileFrame()), file->where()};
    if (const auto up = table.find(k.up)) light.wsUp = readDirection(*up, context.frame);
    light.wsDirection = Vec3(0, -1, 0);  // hanging upright
}

/// Reads a point, spot or projector.
void readNear(TomlTable& table, Type type, bool hasSlide, const ReadContext& context, Light& light) {
    const auto orbit = table.find(k.orbit);
    const std::optional<Vec3> wsCenter = readPlace(table, orbit, context, light);
    Light::Spot spot;
    spot.radius = table.numberAt(context.frame, k.radius);
    spot.decay = table.choice(k.decay) == 0;
    if (type != Type::projector) readLuminaire(table, context, light);
    const bool aimed = light.luminaire && (orbit || table.find(k.direction) || table.find(k.target));
    if (type == Type::spot || hasSlide || aimed) readFacing(table, orbit, wsCenter, context, light);
    if (type != Type::spot) {
        light.kind = Light::Point(spot);
        return;
    }
    spot.coneAngle = table.numberAt(context.frame, k.cone);
    spot.blend = table.numberAt(context.frame, k.blend);
    light.kind = spot;
}

double readLength(TomlTable& table, const Key& key, const ReadContext& context) {
    const TomlValue length = table.require(key, "a length above 0");
    const double value = length.numberAt(context.frame);
    if (!(value > 0)) length.failExpecting("a length above 0");
    return value;
}

void readArea(TomlTable& table, const std::optional<TomlValue>& slide, const ReadContext& context, Light& light) {
    Light::Area area;
    table.require(k.shape);
    area.shape = static_cast<AreaShape>(table.choice(k.shape));
    table.describe(fmt::format("{} and shape '{}'", table.description(), k.shape.words[std::size_t(area.shape)]));
    light.visible = table.boolean(k.visible);
    if (slide && area.shape != AreaShape::rectangle)
        slide->fail(fmt::format("{} has a {}; only a rectangle can have one", table.description(), k.slide));
    if (area.shape == AreaShape::mesh) {  // its place is that of the mesh
        area.mesh = nameAmong(table.require(k.mesh), keysOf<SceneKeys>().mesh, context.meshes);
        area.normalize = table.boolean(k.normalize);
        light.kind = area;
        return;
    }
    const auto orbit = table.find(k.orbit);
    const std::optional<Vec3> wsCenter = readPlace(table, orbit, context, light);
    if (area.shape == AreaShape::rectangle) {
        area.width = readLength(table, k.width, context);
        area.height = readLength(table, k.height, context);
    } else {
        if (area.shape == AreaShape::cylinder) area.width = readLength(table, k.width, context);
        area.radius = readLength(table, k.radius, context);
    }
    if (area.shape == AreaShape::rectangle || area.shape == AreaShape::disk)
        area.spread = table.numberAt(context.frame, k.spread);
    if (area.shape != AreaShape::sphere) readFacing(table, orbit, wsCenter, context, light);
    light.kind = area;
}

/// Reads a clear sky, whose picture is made later.
Slide readSky(const TomlValue& value, const std::string& of, const ReadContext& context) {
    Slide slide;
    slide.where = value.where();
    TomlTable table = value.table(fmt::format("{} of {}", k.sky, of));
    ClearSky sky;
    table.read(keysOf<SkyKeys>(), context.frame, sky);
    table.finish();
    slide.sky = std::make_shared<const ClearSky>(sky);
    return slide;
}

/// Reads a dome, which has one colour, a picture or a clear sky.
void readDome(TomlTable& table, const ReadContext& context, Light& light) {
    const TextureKeys& t = keysOf<TextureKeys>();
    light.kind = Light::Dome{table.numberAt(context.frame, k.rotation)};
    light.visible = table.boolean(k.visible);
    const auto texture = table.find(k.texture), sky = table.find(k.sky);
    if (sky) light.slide = readSky(*sky, table.description(), context);
    if (!texture) return;
    TomlTable picture = texture->table(fmt::format("{} of {}", k.texture, table.description()));
    light.slide = readPicture(picture, t.file, t.colorspace, context);
    light.slide->split = picture.boolean(t.split);
    picture.finish();
}

/// Reads all that is specific to the light's type except for its slide.
void readKind(TomlTable& table, Type type, const std::optional<TomlValue>& slide, const ReadContext& context,
              Light& light) {
    switch (type) {
        case Type::distant:
            readAngle(table, slide, context, light);
            return readDistant(table, slide.has_value(), light.wsUp, context, light);
        case Type::area:
            return readArea(table, slide, context, light);
        case Type::dome:
            return readDome(table, context, light);
        default:
            return readNear(table, type, slide.has_value(), context, light);
    }
}

/// Reads the number of sub-lights; 0 stands for "auto".
int readSamples(TomlTable& table) {
    const auto samples = table.find(k.samples);
    if (!samples) return 0;
    if (!samples->isString()) return samples->integer();
    if (samples->string() != "auto") samples->failExpecting(k.samples.form);
    return 0;
}

}  // namespace

Light readLight(TomlTable table, const std::string& defaultName, const ReadContext& context) {
    Light light;
    light.name = readName(table, k.name, defaultName);
    if (const auto group = table.find(k.group)) light.group = nameIn(*group);
    table.require(k.type);
    const auto type = static_cast<Type>(table.choice(k.type));
    table.describe(fmt::format("{} of type '{}'", table.description(), k.type.words[std::size_t(type)]));

    if (type == Type::projector) table.require(k.slide, "a table { file = \"...\" }: what it projects");
    const auto slide = type == Type::dome ? std::nullopt : table.find(k.slide);
    if (slide || table.find(k.orbit) || type == Type::area || type == Type::dome)
        if (const auto up = table.find(k.up)) light.wsUp = readDirection(*up, context.frame);
    readKind(table, type, slide, context, light);
    if (slide)
        light.slide =
            readSlide(slide->table(fmt::format("{} of {}", k.slide, table.description())), light, type, context);
    light.intensity = readIntensity(table, context);
    if (light.area() && !light.area()->normalize && table.boolean(k.normalize)) light.intensity /= light.area()->area();
    if (light.area() || light.dome() || light.distant()) light.samples = readSamples(table);
    light.shadows = table.boolean(k.shadows);
    light.shadow = static_cast<ShadowMethod>(table.choice(k.shadow));
    table.finish();
    return light;
}

Rgb readAmbient(TomlTable table, const ReadContext& context) {
    const AmbientKeys& a = keysOf<AmbientKeys>();
    const auto colour = table.find(a.color), intensity = table.find(a.intensity);
    table.finish();
    // An empty [ambient] is no light. Colour defaults to white beside an intensity, intensity to 1 beside a colour.
    if (!colour && !intensity) return Rgb(0);
    const Rgb rgb = colour ? colour->colourAt(context.frame, context.colour) : Rgb(1);
    return rgb * (intensity ? intensity->numberAt(context.frame) : 1.0);
}

}  // namespace scrim
