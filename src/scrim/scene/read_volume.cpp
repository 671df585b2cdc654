// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/read_sections.h>

#include <scrim/base/error.h>
#include <scrim/scene/nearest_name.h>
#include <scrim/scene/read_ramp.h>

#include <fmt/format.h>

#include <algorithm>

namespace scrim {
namespace {

constexpr int kLargestOffset = 1'000'000'000;

/// Parameters as text. A source does not know where the scene is: its parameter `file` is a path like all others of the
/// scene, relative to it, with variables and the frame put in.
std::vector<std::pair<std::string, std::string>> readParameters(TomlTable table, const ReadContext& context) {
    std::vector<std::pair<std::string, std::string>> parameters;
    for (const TomlValue& value : table.all()) {
        std::string text;
        if (value.isString())
            text = value.name() == "file" ? context.path(value).at(context.fileFrame()) : value.string();
        else if (value.isBoolean())
            text = value.boolean() ? "true" : "false";
        else if (value.isNumber())
            text = fmt::format("{}", value.number());
        else if (value.isArray()) {
            const Vec3 v = value.vec3();
            text = fmt::format("{}, {}, {}", v.x, v.y, v.z);
        } else
            value.failExpecting("a number, a string, true or false, or three numbers");
        parameters.emplace_back(value.name(), text);
    }
    return parameters;
}

void readFrame(TomlTable table, const ReadContext& context, SceneVolume& volume) {
    volume.frame = context.fileFrame() + table.integer("offset", 0, -kLargestOffset, kLargestOffset, "frames");
    volume.outside = static_cast<OutsidePolicy>(table.choice("outside", {"error", "hold", "black"}, 0));
    table.finish();
}

void readDensity(TomlTable table, SceneVolume& volume) {
    volume.densityGrid = table.string("grid", "");
    volume.densityScale = table.number("scale", 1, Range::fromTo(0, 1e30, "per world unit"));
    if (const auto ramp = table.find("ramp")) {
        volume.ramp = readRamp<double>(*ramp, "[grid value, value]",
                                       [](const TomlValue& y) { return y.number(Range::atLeast(0)); });
        if (!keepsZero(volume.ramp))
            ramp->fail("'ramp' maps 0 to more than 0; expected 0, since empty space, which is 0, is never looked at");
    }
    table.finish();
}

/// The lights that light it, by name.
std::vector<std::string> readLightNames(const TomlValue& value, const ReadContext& context) {
    std::vector<std::string> names;
    for (const TomlValue& item : value.items(0, "a list of names of lights")) {
        const std::string name = item.string();
        if (std::find(context.lights.begin(), context.lights.end(), name) == context.lights.end())
            item.fail(fmt::format("there is no light '{}'{}; expected {}", shortened(name, 60),
                                  didYouMean(name, context.lights), shortened(choices(context.lights))));
        if (std::find(names.begin(), names.end(), name) != names.end())
            item.fail(fmt::format("'{}' is named twice; expected each light once", shortened(name, 60)));
        names.push_back(name);
    }
    return names;
}

/// What the volume is made of: a file, or a source with its parameters.
void readAsset(TomlTable& table, const ReadContext& context, SceneVolume& volume) {
    const auto file = table.find("file"), source = table.find("source");
    if (file && source)
        source->fail(fmt::format("{} has both 'file' and 'source'; expected one of them", table.description()));
    if (!file && !source) table.require("file", "a .vdb file, or 'source', the name of a volume source");
    volume.frame = context.fileFrame();
    if (source) {
        table.describe(table.description() + " with a source");
        volume.where = source->where();
        volume.source = source->string();
        if (const auto parameters = table.find("parameters"))
            volume.parameters = readParameters(parameters->table("'parameters' of " + table.description()), context);
        return;
    }
    table.describe(table.description() + " with a file");
    volume.where = file->where();
    volume.sequence = context.path(*file);
    if (const auto frame = table.find("frame"))
        readFrame(frame->table("'frame' of " + table.description()), context, volume);
    volume.file = volume.sequence.at(volume.frame);
}

}  // namespace

SceneVolume readVolume(TomlTable table, const std::string& defaultName, const ReadContext& context) {
    SceneVolume volume;
    volume.name = readName(table, defaultName);
    const std::string description = table.description();
    readAsset(table, context, volume);
    if (const auto transform = table.find("transform"))
        volume.wsFromAsset = readTransform(transform->table("'transform' of " + description), context);
    if (const auto density = table.find("density")) readDensity(density->table("'density' of " + description), volume);
    if (const auto lights = table.find("lights")) volume.lights = readLightNames(*lights, context);
    const auto medium = table.find("medium"), classified = table.find("classified");
    if (classified) {
        Classified c = readClassified(classified->table("[volume.classified] of " + description), context);
        c.densityScale = volume.densityScale;
        volume.classified = std::make_shared<const Classified>(std::move(c));
        if (medium)
            classified->fail(fmt::format("{} has both 'medium' and 'classified'; expected one of them", description));
    }
    if (medium) readMedium(medium->table("[volume.medium] of " + description), context, volume);
    volume.medium.densityScale = volume.densityScale;
    table.finish();
    return volume;
}

}  // namespace scrim
