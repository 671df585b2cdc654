// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/read_sections.h>

#include <scrim/base/error.h>
#include <scrim/scene/read_ramp.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace scrim {
namespace {

const VolumeKeys& k = keysOf<VolumeKeys>();

/// Reads the parameters of a source as text, without `others`. A source does not know the scene's folder, so its
/// parameter `file` is expanded here like all other paths: relative to the scene, with variables and the frame put in.
std::vector<std::pair<std::string, std::string>> readParameters(TomlTable table, const ReadContext& context,
                                                                const std::vector<std::string>& others) {
    std::vector<std::pair<std::string, std::string>> parameters;
    for (const TomlValue& value : table.all()) {
        if (std::find(others.begin(), others.end(), value.name()) != others.end()) continue;
        std::string text;
        if (value.isString())
            text = value.name() == k.file.name ? context.path(value).at(context.fileFrame()) : value.string();
        else if (value.isBoolean())
            text = value.boolean() ? "true" : "false";
        else if (value.isNumber())
            text = fmt::format("{}", value.number(Range()));
        else if (value.isArray()) {
            const Vec3 v = value.vec3();
            text = fmt::format("{}, {}, {}", v.x, v.y, v.z);
        } else
            value.failExpecting("a number, a string, true or false, or three numbers");
        parameters.emplace_back(value.name(), text);
    }
    return parameters;
}

/// Reads the number of the file at this frame.
void readFrame(TomlTable table, const ReadContext& context, SceneVolume& volume) {
    const FrameKeys& f = keysOf<FrameKeys>();
    FrameMap& map = volume.frameMap;
    table.read(f, context.frame, volume);
    if (const auto keys = table.find(f.keys)) {
        map.keys.keys = readRamp<double>(
            *keys, "[frame, file number]", [](const TomlValue& y) { return y.number(); }, 1);
    }
    const double frame = context.wholeFrame, number = map.fileAt(frame);
    if (!(std::abs(number) <= 2.0 * kLastFrame))
        table.fail(fmt::format("{} is file {:g} at frame {}; expected one of at most {}", table.description(), number,
                               context.wholeFrame, 2 * kLastFrame));
    volume.frame = static_cast<int>(number);
    volume.beyond = map.beyondAt(frame);
    table.finish();
}

void readDensity(TomlTable table, const ReadContext& context, SceneVolume& volume) {
    const DensityKeys& d = keysOf<DensityKeys>();
    volume.densityGrid = table.string(d.grid);
    if (const auto grid = table.find(d.grid)) volume.densityWhere = grid->where();
    table.read(d, context.frame, volume);
    readDensityShading(table, context, volume.shading);
    if (const auto ramp = table.find(d.ramp)) {
        volume.ramp = readRamp<double>(*ramp, "[grid value, value]", [](const TomlValue& y) { return y.number(); });
        if (!keepsZero(volume.ramp))
            ramp->fail(
                fmt::format("{} is above 0 at grid value 0; expected 0 there, because empty space is skipped", d.ramp));
    }
    table.finish();
}

Velocity readVelocity(TomlTable table, const ReadContext& context) {
    const VelocityKeys& v = keysOf<VelocityKeys>();
    Velocity velocity;
    const TomlValue grid = table.require(v.grid);
    velocity.where = grid.where();
    if (grid.isString())
        velocity.grids = {grid.string()};
    else
        for (const TomlValue& item : grid.items(3)) velocity.grids.push_back(item.string());
    table.read(v, context.frame, velocity);
    table.finish();
    return velocity;
}

/// Reads a list of names of lights.
std::vector<std::string> readLightNames(const TomlValue& value, const ReadContext& context) {
    std::vector<std::string> names;
    for (const TomlValue& item : value.items(0)) {
        const std::string name = nameAmong(item, keysOf<SceneKeys>().light, context.lights);
        if (std::find(names.begin(), names.end(), name) != names.end())
            item.fail(fmt::format("'{}' is named twice; expected each light once", shortened(name, 60)));
        names.push_back(name);
    }
    return names;
}

/// Reads a table inside `table`; its description names both.
TomlTable inner(const TomlValue& value, const TomlTable& table) {
    return value.table(fmt::format("'{}' of {}", value.name(), table.description()));
}

/// Reads what the volume is made of: a file, grids of several, or a source with its parameters.
void readAsset(TomlTable& table, const ReadContext& context, SceneVolume& volume) {
    const auto file = table.find(k.file), grids = table.find(k.grids), source = table.find(k.source);
    if (!file && !grids && !source && !context.gridsFromCode) table.require(k.file);
    volume.frame = context.fileFrame();
    if (!file && !grids && !source) {
        table.describe(table.description() + " with grids of its own");
        volume.where = table.where();
        return;
    }
    if (source) {
        table.describe(table.description() + " with a source");
        volume.where = source->where();
        volume.source = source->string();
        if (const auto parameters = table.find(k.parameters))
            volume.parameters = readParameters(inner(*parameters, table), context, variablesOf(table, context));
        return;
    }
    table.describe(table.description() + (file ? " with a file" : " with grids of files"));
    volume.where = (file ? file : grids)->where();
    if (const auto frame = table.find(k.frame)) readFrame(inner(*frame, table), context, volume);
    if (file) {
        volume.sequence = context.path(*file);
    } else {
        GridEdit edit;
        edit.where = volume.where;
        edit.grids = readGrids(*grids, context, volume.sequences);
        for (const FramePath& path : volume.sequences) edit.files.push_back(path.at(volume.frame));
        volume.sequence = volume.sequences.front();
        volume.edit = std::make_shared<const GridEdit>(std::move(edit));
    }
    volume.file = volume.sequence.at(volume.frame);
}

}  // namespace

SceneVolume readVolume(TomlTable table, const std::string& defaultName, const ReadContext& context) {
    SceneVolume volume;
    volume.name = readName(table, k.name, defaultName);
    const std::string description = table.description();
    const auto of = [&](const TomlValue& value, const std::string& name) {
        return value.table(fmt::format("{} of {}", name, description));
    };
    readAsset(table, context, volume);
    if (const auto transform = table.find(k.transform))
        volume.wsFromAsset = readTransform(of(*transform, fmt::format("{}", k.transform)), context);
    if (const auto density = table.find(k.density))
        readDensity(of(*density, fmt::format("{}", k.density)), context, volume);
    volume.clip = readClip(table);
    if (const auto displacement = table.find(k.displacement))
        volume.displacement = readNoise(*displacement, table.description(), context);
    if (const auto velocity = table.find(k.velocity))
        volume.velocity = readVelocity(of(*velocity, fmt::format("{}", k.velocity)), context);
    if (volume.frameMap.between == BetweenFiles::advect && !volume.velocity)
        table.require(k.frame).fail(
            fmt::format("{} carries grids by their velocity, and {} has no {}; expected one "
                        "beside it",
                        keysOf<FrameKeys>().between, description, k.velocity));
    volume.edit = readEdit(table, context, volume);
    if (const auto lights = table.find(k.lights)) volume.lights = readLightNames(*lights, context);
    if (const auto shadows = table.find(k.shadows)) {
        if (!shadows->isBoolean())
            volume.shadows = readLightNames(*shadows, context);
        else if (!shadows->boolean())
            volume.shadows.emplace();
    }
    if (const auto classified = table.find(k.classified))
        volume.classified = std::make_shared<const Classified>(
            readClassified(of(*classified, keysOf<ClassifiedKeys>().title()), context));
    if (const auto medium = table.find(k.medium))
        readMedium(of(*medium, keysOf<MediumKeys>().title()), context, volume);
    table.read(k, context.frame, volume);
    table.finish();
    return volume;
}

}  // namespace scrim
