// SPDX-License-Identifier: Apache-2.0
// Reads [output], [render] and [variables].
#include <scrim/scene/read_sections.h>

#include <scrim/base/error.h>
#include <scrim/base/letter_case.h>
#include <scrim/image/exr.h>
#include <scrim/image/known_spaces.h>
#include <scrim/scene/layer_names.h>
#include <scrim/scene/quality.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace scrim {
namespace {

/// Reads one of `names`, in any letter case. Throws for any other text.
std::string readOneOf(const TomlValue& value, const std::vector<std::string>& names) {
    const std::string text = value.string();
    for (const std::string& name : names)
        if (equalIgnoringCase(name, text)) return name;
    value.failExpecting(choices(names));
}

/// Reads a list of layers without repetitions and returns them in the order of Layer.
std::vector<Layer> readLayers(const TomlValue& value, const OutputFile& output, const ColourConfig& colour) {
    const std::vector<std::string>& names = layerNames();
    std::vector<Layer> layers;
    for (const TomlValue& item : value.items(0)) {
        const auto layer = static_cast<Layer>(item.choice(names));
        if (std::find(layers.begin(), layers.end(), layer) != layers.end())
            item.fail(fmt::format("'{}' repeats '{}'; expected each layer once", item.name(), item.string()));
        layers.push_back(layer);
    }
    std::sort(layers.begin(), layers.end());
    if (!layers.empty() && output.half && colour.isAces2065(output.colorspace))
        value.fail(
            fmt::format("'{}' cannot be written to an ACES container (half floats in ACES2065-1); expected another {}, "
                        "or {} = \"float\"",
                        value.name(), keysOf<OutputKeys>().colorspace, keysOf<OutputKeys>().type.name));
    if (std::ranges::find(layers, Layer::cryptomatte) != layers.end() && output.compression == "dwaa")
        value.fail(
            fmt::format("'cryptomatte' needs exact numbers, which {} = \"dwaa\" does not keep; expected another {}",
                        keysOf<OutputKeys>().compression.name, keysOf<OutputKeys>().compression));
    return layers;
}

void requireExr(const Key& key, const TomlValue& path, const ReadContext& context) {
    if (!equalIgnoringCase(std::filesystem::path(context.path(path).pattern).extension().string(), ".exr"))
        path.fail(fmt::format("{} is '{}'; expected a name that ends in '.exr'", key, path.string()));
}

/// The keys that [output] and its further files share, but for `type`. `file` has the defaults.
template <typename Keys>
void readFile(TomlTable& table, const Keys& k, const ReadContext& context, OutputFile& file) {
    if (const auto path = table.find(k.file)) {
        file.path = context.path(*path);
        file.where = path->where();
        file.file = file.path.at(context.fileFrame());
    }
    if (const auto space = table.find(k.colorspace)) {
        file.colorspace = located(*space, [&] { return context.colour.resolve(space->string()); });
        if (!located(*space, [&] { return context.colour.isLinear(file.colorspace); }))
            context.warnings->push_back(fmt::format(
                "{}: {} is '{}', which is not linear: programs expect linear colours in EXR, and premultiplied ones "
                "that are encoded cannot be composited; expected a linear space, such as '{}', and {} for a picture to "
                "look at",
                space->where(), space->name(), space->string(), context.colour.workingSpace(),
                keysOf<OutputKeys>().preview));
    }
    if (const auto compression = table.find(k.compression))
        file.compression = k.compression.words[compression->choice(k.compression.words)];
    if (const auto layers = table.find(k.layers)) file.layers = readLayers(*layers, file, context.colour);
}

OutputFile readFurtherFile(TomlTable table, const ReadContext& context, const OutputFile& main) {
    const FileKeys& k = keysOf<FileKeys>();
    OutputFile file = main;
    file.layers.clear();
    requireExr(k.file, table.require(k.file), context);
    file.picture = table.boolean(k.picture);
    if (const auto type = table.find(k.type)) file.half = type->choice(k.type.words) == 0;
    readFile(table, k, context, file);
    if (file.layers.empty() && !file.picture)
        table.fail(
            fmt::format("{} would hold nothing; expected {}, or {} = true", table.description(), k.layers, k.picture));
    table.finish();
    return file;
}

ScenePreview readPreview(const TomlValue& value, const ReadContext& context) {
    ScenePreview preview;
    if (value.isString()) {
        preview.path = context.path(value);
    } else {
        const PreviewKeys& k = keysOf<PreviewKeys>();
        if (!value.isTable()) value.failExpecting(keysOf<OutputKeys>().preview.form);
        TomlTable table = value.table(fmt::format("'{}' of [output]", value.name()));
        preview.path = context.path(table.require(k.file));
        if (const auto display = table.find(k.display))
            preview.display = readOneOf(*display, context.colour.displays());
        const std::string display = preview.display.empty() ? context.colour.defaultDisplay() : preview.display;
        if (const auto view = table.find(k.view)) preview.view = readOneOf(*view, context.colour.views(display));
        if (table.find(k.backplate))
            preview.backplate = readPicture(table, k.backplate, k.backplateColorspace, context);
        if (const auto annotate = table.find(k.annotate)) preview.annotate = annotate->boolean();
        table.finish();
    }
    preview.file = preview.path.at(context.fileFrame());
    return preview;
}

void readDeep(TomlTable& table, const ReadContext& context, SceneOutput& output) {
    const OutputKeys& k = keysOf<OutputKeys>();
    const auto path = table.find(k.deep);
    for (const Key* key : {&k.deepTolerance, &k.deepType})
        if (const auto value = table.find(*key); value && !path && !context.deepFromCode)
            value->fail(fmt::format("{} is set without {}; expected the path of the deep picture, too", *key, k.deep));
    if (!path) return;
    output.deep.path = context.path(*path);
    output.deep.file = output.deep.path.at(context.fileFrame());
    requireExr(k.deep, *path, context);
}

SceneHoldout readHoldout(TomlTable table, const ReadContext& context) {
    const HoldoutKeys& k = keysOf<HoldoutKeys>();
    SceneHoldout holdout;
    const TomlValue depth = table.require(k.depth);
    holdout.where = depth.where();
    holdout.file = context.path(depth).at(context.fileFrame());
    holdout.channel = table.string(k.channel);
    table.read(k, context.frame, holdout);
    table.finish();
    return holdout;
}

}  // namespace

std::vector<Layer> SceneOutput::allLayers() const {
    std::vector<Layer> all = layers;
    for (const OutputFile& more : files) all.insert(all.end(), more.layers.begin(), more.layers.end());
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
}

SceneOutput defaultOutput(const ReadContext& context) {
    SceneOutput output;
    output.colorspace = context.colour.workingSpace();
    return output;
}

SceneOutput readOutput(TomlTable table, const ReadContext& context) {
    const OutputKeys& k = keysOf<OutputKeys>();
    SceneOutput output = defaultOutput(context);
    table.read(k, context.frame, output);
    readFile(table, k, context, output);
    for (const TomlTable& file : table.tables(k.files)) output.files.push_back(readFurtherFile(file, context, output));
    if (const auto preview = table.find(k.preview)) output.preview = readPreview(*preview, context);
    readDeep(table, context, output);
    if (const auto holdout = table.find(k.holdout))
        output.holdout = readHoldout(holdout->table(fmt::format("{} of [output]", k.holdout)), context);
    table.finish();
    return output;
}

void readRender(TomlTable table, const ReadContext& context, Scene& scene) {
    const RenderKeys& k = keysOf<RenderKeys>();
    scene.quality = k.quality.words[table.choice(k.quality)];
    scene.dials = *presetDials(scene.quality);
    table.read(k, context.frame, scene);
    scene.keepsPromise = scene.tolerance == 0;
    for (const DialInfo& dial : dialTable()) {
        const auto value = table.find(k.dial(dial.name));
        if (!value) continue;
        if (dial.chosen) scene.keepsPromise = false;
        if (scene.tolerance > 0 && dial.chosen)
            value->fail(fmt::format("'{}' cannot be combined with {}, which chooses it", dial.name, k.tolerance));
        if (value->isString())
            setDial(scene.dials, dial.name, value->string(), value->where());
        else if (value->isNumber())
            setDial(scene.dials, dial.name, value->number(), value->where());
        else
            value->failExpecting(dial.allowed);
    }
    table.finish();
}

std::vector<std::pair<std::string, std::string>> readVariables(TomlTable table) {
    std::vector<std::pair<std::string, std::string>> variables;
    for (const TomlValue& value : table.all()) {
        if (value.isNumber())
            variables.emplace_back(value.name(), fmt::format("{}", value.number(Range())));
        else if (value.isString())
            variables.emplace_back(value.name(), value.string());
        else
            value.failExpecting("a string or a number");
    }
    return variables;
}

}  // namespace scrim
