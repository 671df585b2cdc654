// SPDX-License-Identifier: Apache-2.0
// Reads [volume.medium]: how a medium scatters, absorbs and emits light.
#include <scrim/scene/read_sections.h>

#include <scrim/image/blackbody.h>
#include <scrim/scene/read_ramp.h>

#include <fmt/format.h>

#include <algorithm>

namespace scrim {

Rgb readBounded(const TomlValue& value, const ReadContext& context, double most) {
    constexpr double kRounding = 1e-6;
    Rgb colour = value.colour(context.colour);
    for (int c = 0; c < 3; ++c) {
        if (!(colour[c] >= -kRounding && colour[c] <= most + kRounding))  // written so that NaN fails, too
            value.fail(fmt::format("'{}' is {}, {}, {} in the working space; expected numbers from 0 to {:g}",
                                   value.name(), colour.x, colour.y, colour.z, most));
        colour[c] = std::clamp(colour[c], 0.0, most);
    }
    return colour;
}

namespace {

Phase readPhase(TomlTable table, double frame) {
    const PhaseKeys& k = keysOf<PhaseKeys>();
    table.require(k.type);
    enum { isotropic, hg, twoLobe, rayleigh, draine, droplets };  // as k.type has them
    const std::size_t type = table.choice(k.type);
    table.describe(fmt::format("{} of type '{}'", table.description(), k.type.words[type]));
    Phase phase;
    if (type == hg || type == draine) table.read(k.g, frame, phase);
    if (type == draine) phase = drainePhase(phase.g, table.numberAt(frame, k.alpha));
    if (type == twoLobe) {
        phase.type = PhaseType::twoLobe;
        for (const Key* key : {&k.g1, &k.g2, &k.blend}) table.read(*key, frame, phase);
    }
    if (type == rayleigh) phase.type = PhaseType::rayleigh;
    if (type == droplets) phase = dropletPhase(table.require(k.dropletSize).numberAt(frame));
    table.finish();
    return phase;
}

Octaves readOctaves(TomlTable table, double frame) {
    Octaves octaves;
    table.read(keysOf<OctavesKeys>(), frame, octaves);
    table.finish();
    return octaves;
}

// A table of octaves alone means that scattering is octaves; beside another word it is a contradiction.
void readScattering(TomlTable& table, const MediumKeys& k, const ReadContext& context, Medium& medium) {
    const auto octaves = table.find(k.octaves);
    const auto word = table.find(k.scattering);
    medium.scattering = word      ? static_cast<Scattering>(table.choice(k.scattering))
                        : octaves ? Scattering::octaves
                                  : Scattering::single;
    if (octaves) {
        if (medium.scattering != Scattering::octaves)
            octaves->fail(fmt::format("{} has {} = \"{}\" and {}; expected one of them", table.description(),
                                      k.scattering, k.scattering.words[std::size_t(medium.scattering)], k.octaves));
        medium.octaves =
            readOctaves(octaves->table(fmt::format("'{}' of {}", octaves->name(), table.description())), context.frame);
    } else if (medium.scattering == Scattering::octaves) {
        medium.octaves.count = static_cast<int>(*keysOf<OctavesKeys>().count.value);
    }
}

ColourGrid readColourGrid(TomlTable table, const ReadContext& context) {
    const AlbedoGridKeys& k = keysOf<AlbedoGridKeys>();
    const TomlValue grid = table.require(k.grid);
    ColourGrid out;
    out.grid = grid.string();
    out.where = grid.where();
    table.read(k, context.frame, out);
    if (const auto space = table.find(k.colorspace))
        out.workingFromGrid = located(*space, [&] { return context.colour.workingFrom(space->string()); });
    if (const auto ramp = table.find(k.ramp))
        out.ramp = readRamp<Rgb>(*ramp, "[grid value, colour]",
                                 [&](const TomlValue& y) { return readBounded(y, context, 1); });
    table.finish();
    return out;
}

void readAlbedo(const TomlValue& value, const std::string& of, const ReadContext& context, SceneVolume& volume) {
    // A table is either a colour with its space or a grid of colours.
    if (value.isTable()) {
        TomlTable table = value.table(fmt::format("'{}' of {}", value.name(), of));
        if (table.find(keysOf<AlbedoGridKeys>().grid)) {
            volume.albedoGrid = readColourGrid(std::move(table), context);
            return;
        }
    }
    volume.medium.albedo = readBounded(value, context, 1);
}

/// Reads the keys that emission and blackbodies share.
Emission readEmissionGrid(TomlTable& table, const Key& key) {
    const TomlValue grid = table.require(key);
    Emission emission;
    emission.grid = grid.string();
    emission.where = grid.where();
    return emission;
}

/// Reads a ramp over the grid's values. Its places 0 and 1 are the ends of `range`.
std::vector<std::pair<double, Rgb>> readGlow(const TomlValue& value, const std::array<double, 2>& range,
                                             const ReadContext& context) {
    const auto emitted = [&](const TomlValue& y) {
        if (!y.isNumber()) return readBounded(y, context, kMostLight);
        const double kelvin = y.number(keysOf<LightKeys>().temperature.range);
        return located(y, [&] { return Blackbody(context.colour).colour(kelvin); });
    };
    auto ramp = readRamp<Rgb>(value, "[grid value, colour or Kelvin] or [grid value, colour or Kelvin, strength]",
                              emitted, 2, true);
    for (auto& [x, rgb] : ramp) x = range[0] + x * (range[1] - range[0]);
    return ramp;
}

/// One source of emission, or one for each channel of a grid of colours.
std::vector<Emission> readEmission(TomlTable table, const ReadContext& context) {
    const EmissionKeys& k = keysOf<EmissionKeys>();
    Emission emission = readEmissionGrid(table, k.grid);
    table.read(k, context.frame, emission);
    const std::array<double, 2> range = readPair(table, k.range, true);
    if (const auto ramp = table.find(k.ramp)) {
        emission.ramp = readGlow(*ramp, range, context);
        if (!keepsZero(emission.ramp))
            ramp->fail(fmt::format(
                "{} is not black at grid value 0; expected black there, because empty space is skipped", k.ramp));
    } else if (const auto alone = table.find(k.range)) {
        alone->fail(fmt::format("{} has {} without {}", table.description(), k.range, k.ramp));
    }
    if (const auto mask = table.find(k.mask)) emission.mask = readMask(*mask, table.description());
    const bool colors = table.boolean(k.colors);
    if (colors && !emission.ramp.empty())
        table.fail(fmt::format("{} has {} and {}; expected one of them", table.description(), k.colors, k.ramp));
    table.finish();
    if (!colors) return {emission};
    std::vector<Emission> channels;
    for (const char* const part : {".r", ".g", ".b"}) {
        Rgb only(0);
        only[static_cast<int>(channels.size())] = 1;
        channels.push_back(emission);
        channels.back().grid += part;
        channels.back().color = only;
    }
    return channels;
}

/// Reads the temperatures of grid values 0 and 1, which replace scale and offset.
void readKelvin(TomlTable& table, const BlackbodyKeys& k, Emission& emission) {
    const auto kelvin = table.find(k.kelvin);
    if (!kelvin) return;
    const auto ends = kelvin->items(2);
    const double cold = ends[0].number(), hot = ends[1].number();
    if (!(hot - cold >= 1e-3))
        kelvin->fail(
            fmt::format("{} is [{}, {}]; expected the second temperature above the first", k.kelvin, cold, hot));
    emission.kelvinScale = hot - cold;
    emission.kelvinOffset = cold;
}

Emission readBlackbody(const TomlValue& value, const std::string& of, const ReadContext& context) {
    const BlackbodyKeys& k = keysOf<BlackbodyKeys>();
    TomlTable table = value.table(fmt::format("'{}' of {}", value.name(), of));
    Emission emission = readEmissionGrid(table, k.grid);
    emission.blackbody = true;
    table.read(k, context.frame, emission);
    readKelvin(table, k, emission);
    const auto normalize = table.find(k.normalize);
    if (normalize && normalize->boolean()) emission.physicalIntensity = 0;
    const auto tint = table.find(k.tint);
    const Rgb factor = tint ? readBounded(*tint, context, kMostTint) : Rgb(1);
    if (const auto mask = table.find(k.mask)) emission.mask = readMask(*mask, table.description());
    table.finish();
    if (!normalize && !table.find(k.physicalIntensity) && context.version < 2)
        context.warnings->push_back(
            fmt::format("{}: {} of the blackbody now defaults to false; before scene_version 2 it was true, which "
                        "makes all temperatures equally bright. Set it, or set {} = {}",
                        value.where(), k.normalize, keysOf<SceneKeys>().sceneVersion.name, kSceneVersion));
    emission.ramp = located(value, [&] {
        return Blackbody(context.colour).ramp(emission.kelvinScale, emission.kelvinOffset, emission.physicalIntensity);
    });
    if (tint)
        for (auto& [kelvin, colour] : emission.ramp) colour *= factor;
    return emission;
}

/// Reads the colour that white light has after `depth` of a density of 1; returns the extinction of that density.
Rgb readTransparency(const TomlValue& value, double depth, const ReadContext& context) {
    const Rgb left = readBounded(value, context, 1);
    if (!(smallest(left) > 0))
        value.failExpecting("a colour of which some of each channel is left: above 0, at most 1");
    const Rgb extinction = glm::log(1.0 / left) / depth;
    if (!(largest(extinction) <= kMostTint))
        value.fail(fmt::format("'{}' is reached so soon that extinction is above {:g}; expected a greater {}",
                               value.name(), kMostTint, keysOf<MediumKeys>().transparencyDepth));
    return extinction;
}

}  // namespace

void readMedium(TomlTable table, const ReadContext& context, SceneVolume& volume) {
    const MediumKeys& k = keysOf<MediumKeys>();
    const std::string of = table.description();
    const auto inner = [&](const TomlValue& value) { return value.table(fmt::format("'{}' of {}", value.name(), of)); };
    Medium& medium = volume.medium;
    if (const auto albedo = table.find(k.albedo)) readAlbedo(*albedo, of, context, volume);
    if (const auto tint = table.find(k.extinctionTint)) medium.extinctionTint = readBounded(*tint, context, kMostTint);
    const double depth = table.number(k.transparencyDepth);
    if (const auto colour = table.find(k.transparency))
        medium.extinctionTint = readTransparency(*colour, depth, context);
    else if (const auto alone = table.find(k.transparencyDepth))
        alone->fail(fmt::format("{} has {} without {}", of, k.transparencyDepth, k.transparency));
    if (const auto phase = table.find(k.phase)) medium.phase = readPhase(inner(*phase), context.frame);
    readScattering(table, k, context, medium);
    if (const auto emission = table.find(k.emission)) volume.emission = readEmission(inner(*emission), context);
    if (const auto blackbody = table.find(k.blackbody))
        volume.emission.push_back(readBlackbody(*blackbody, of, context));
    table.finish();
}

}  // namespace scrim
