// SPDX-License-Identifier: Apache-2.0
// [volume.medium]: what scatters, takes and sends out light.
#include <scrim/scene/read_sections.h>

#include <scrim/image/blackbody.h>
#include <scrim/scene/read_ramp.h>

#include <fmt/format.h>

#include <algorithm>

namespace scrim {
namespace {

constexpr double kMostTint = 1e6, kMostLight = 1e30;
constexpr double kFarthestOffset = 1e6;  // Kelvin: keeps single Kelvin apart in grids of floats

/// A colour with components from 0 to `most` in the working space, too. Conversions may miss the limits by their
/// rounding.
Rgb readBounded(const TomlValue& value, const ReadContext& context, double most) {
    constexpr double kRounding = 1e-6;
    Rgb colour = value.colour(context.colour);
    for (int c = 0; c < 3; ++c) {
        if (!(colour[c] >= -kRounding && colour[c] <= most + kRounding))  // NaN neither
            value.fail(fmt::format("'{}' is {}, {}, {} in the working space; expected numbers from 0 to {:g}",
                                   value.name(), colour.x, colour.y, colour.z, most));
        colour[c] = std::clamp(colour[c], 0.0, most);
    }
    return colour;
}

Phase readPhase(TomlTable table) {
    static const std::vector<std::string> types{"isotropic", "hg", "two-lobe", "rayleigh"};
    table.require("type", choices(types));
    const std::string type = types[table.choice("type", types, 0)];
    table.describe(fmt::format("{} of type '{}'", table.description(), type));
    const auto cosine = [&](const char* key, const std::string& what) {
        return table.require(key, what).number(Range::between(-1, 1));
    };
    Phase phase;
    if (type == "hg") phase.g = cosine("g", "the mean cosine");
    if (type == "two-lobe") {
        phase.type = PhaseType::twoLobe;
        phase.g = cosine("g1", "the mean cosine of the first lobe");
        phase.g2 = cosine("g2", "the mean cosine of the second lobe");
        phase.blend = table.number("blend", phase.blend, Range::fromTo(0, 1));
    }
    if (type == "rayleigh") phase.type = PhaseType::rayleigh;
    table.finish();
    return phase;
}

Octaves readOctaves(TomlTable table) {
    constexpr int kMostOctaves = 16;
    const Range share = Range::fromTo(0, 1);
    Octaves octaves;
    octaves.count = table.integer("count", 8, 1, kMostOctaves);
    octaves.extinction = table.number("extinction", octaves.extinction, share);
    octaves.contribution = table.number("contribution", octaves.contribution, share);
    octaves.phase = table.number("phase", octaves.phase, share);
    table.finish();
    return octaves;
}

ColourGrid readColourGrid(TomlTable table, const ReadContext& context) {
    const TomlValue grid = table.require("grid", "the name of a grid of colours");
    ColourGrid out;
    out.grid = grid.string();
    out.where = grid.where();
    out.scale = table.numberAt(context.frame, "scale", 1, Range::fromTo(0, kMostLight));
    if (const auto space = table.find("colorspace"))
        out.workingFromGrid = located(*space, [&] { return context.colour.workingFrom(space->string()); });
    table.finish();
    return out;
}

void readAlbedo(const TomlValue& value, const std::string& of, const ReadContext& context, SceneVolume& volume) {
    // A table is a colour and its space, or a grid of colours.
    if (value.isTable()) {
        TomlTable table = value.table("'albedo' of " + of);
        if (table.find("grid")) {
            volume.albedoGrid = readColourGrid(std::move(table), context);
            return;
        }
    }
    volume.medium.albedo = readBounded(value, context, 1);
}

/// What emission and black bodies have in common.
Emission readEmissionGrid(TomlTable& table) {
    const TomlValue grid = table.require("grid", "the name of a grid");
    Emission emission;
    emission.grid = grid.string();
    emission.where = grid.where();
    return emission;
}

Emission readEmission(TomlTable table, const ReadContext& context) {
    Emission emission = readEmissionGrid(table);
    emission.scale = table.numberAt(context.frame, "scale", 1, Range::fromTo(0, kMostLight));
    if (const auto ramp = table.find("ramp")) {
        emission.ramp = readRamp<Rgb>(*ramp, "[grid value, colour]",
                                      [&](const TomlValue& y) { return readBounded(y, context, kMostLight); });
        if (!keepsZero(emission.ramp))
            ramp->fail("'ramp' maps 0 to light; expected black, since empty space, which is 0, is never looked at");
    }
    table.finish();
    return emission;
}

Emission readBlackbody(const TomlValue& value, const std::string& of, const ReadContext& context) {
    TomlTable table = value.table("'blackbody' of " + of);
    Emission emission = readEmissionGrid(table);
    emission.blackbody = true;
    const double scale = table.numberAt(context.frame, "scale", 1, Range::fromTo(1e-9, 1e9, "Kelvin"));
    const double offset =
        table.numberAt(context.frame, "offset", 0, Range::fromTo(-kFarthestOffset, kFarthestOffset, "Kelvin"));
    emission.scale = table.numberAt(context.frame, "intensity", 1, Range::fromTo(0, kMostLight));
    const bool normalize = table.boolean("normalize", true);
    table.finish();
    emission.ramp = located(value, [&] { return Blackbody(context.colour).ramp(scale, offset, normalize); });
    return emission;
}

}  // namespace

void readMedium(TomlTable table, const ReadContext& context, SceneVolume& volume) {
    const std::string of = table.description();
    Medium& medium = volume.medium;
    if (const auto albedo = table.find("albedo")) readAlbedo(*albedo, of, context, volume);
    if (const auto tint = table.find("extinction_tint")) medium.extinctionTint = readBounded(*tint, context, kMostTint);
    if (const auto phase = table.find("phase")) medium.phase = readPhase(phase->table("'phase' of " + of));
    if (const auto octaves = table.find("octaves")) medium.octaves = readOctaves(octaves->table("'octaves' of " + of));
    if (const auto emission = table.find("emission"))
        volume.emission.push_back(readEmission(emission->table("'emission' of " + of), context));
    if (const auto blackbody = table.find("blackbody"))
        volume.emission.push_back(readBlackbody(*blackbody, of, context));
    table.finish();
}

}  // namespace scrim
