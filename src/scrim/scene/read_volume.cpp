// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/read_sections.h>

#include <scrim/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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

/// The field's remap: it must leave 0 alone, since space without voxels is 0 and is never looked at.
std::vector<std::pair<double, double>> readRamp(const TomlValue& value) {
    std::vector<std::pair<double, double>> ramp;
    for (const TomlValue& point : value.items(0, "a list of [grid value, value]")) {
        const auto pair = point.items(2, "[grid value, value]");
        const double x = pair[0].number(), y = pair[1].number(Range::atLeast(0));
        if (!ramp.empty() && x <= ramp.back().first)
            pair[0].fail(
                fmt::format("'ramp': {} does not come after {}; expected ascending grid values", x, ramp.back().first));
        ramp.emplace_back(x, y);
    }
    if (ramp.size() < 2) value.failExpecting("at least two [grid value, value]");
    const auto next = std::find_if(ramp.begin(), ramp.end(), [](const auto& point) { return point.first >= 0; });
    const auto last = next == ramp.begin() ? next : next - 1;
    const auto& a = *last;
    const auto& b = next == ramp.end() ? *last : *next;
    const bool zero = b.first == 0 ? b.second == 0 : a.second == 0 && b.second == 0;
    if (!zero)
        value.fail("'ramp' maps 0 to more than 0; expected 0, since empty space, which is 0, is never looked at");
    return ramp;
}

void readDensity(TomlTable table, SceneVolume& volume) {
    volume.densityGrid = table.string("grid", "");
    volume.densityScale = table.number("scale", 1, Range::fromTo(0, 1e30, "per world unit"));
    if (const auto ramp = table.find("ramp")) volume.ramp = readRamp(*ramp);
    table.finish();
}

Phase readPhase(TomlTable table) {
    Phase phase;
    table.require("type", "'isotropic' or 'hg'");
    const bool isotropic = table.choice("type", {"isotropic", "hg"}, 0) == 0;
    table.describe(fmt::format("{} of type '{}'", table.description(), isotropic ? "isotropic" : "hg"));
    if (!isotropic) phase.g = table.require("g", "the mean cosine").number(Range::between(-1, 1));
    table.finish();
    return phase;
}

Medium readMedium(TomlTable table, const ReadContext& context) {
    Medium medium;
    if (const auto albedo = table.find("albedo")) {
        medium.albedo = albedo->colour(context.colour);
        // A conversion from another space may miss the limits by its rounding only.
        constexpr double kRounding = 1e-6;
        for (int c = 0; c < 3; ++c) {
            double& value = medium.albedo[c];
            if (value < -kRounding || value > 1 + kRounding)
                albedo->fail(fmt::format("'albedo' is {}, {}, {} in the working space; expected numbers from 0 to 1",
                                         medium.albedo.x, medium.albedo.y, medium.albedo.z));
            value = std::clamp(value, 0.0, 1.0);
        }
    }
    if (const auto phase = table.find("phase"))
        medium.phase = readPhase(phase->table("'phase' of " + table.description()));
    table.finish();
    return medium;
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
    const auto medium = table.find("medium"), classified = table.find("classified");
    if (classified) {
        Classified c = readClassified(classified->table("[volume.classified] of " + description), context);
        c.densityScale = volume.densityScale;
        volume.classified = std::make_shared<const Classified>(std::move(c));
        if (medium)
            classified->fail(fmt::format("{} has both 'medium' and 'classified'; expected one of them", description));
    }
    if (medium) volume.medium = readMedium(medium->table("[volume.medium] of " + description), context);
    volume.medium.densityScale = volume.densityScale;
    table.finish();
    return volume;
}

}  // namespace scrim
