// SPDX-License-Identifier: Apache-2.0
// [output], [render] and [variables].
#include <scrim/scene/read_sections.h>

#include <scrim/base/error.h>
#include <scrim/image/exr.h>
#include <scrim/image/known_spaces.h>
#include <scrim/scene/layer_names.h>
#include <scrim/scene/quality.h>

#include <fmt/format.h>

#include <algorithm>

namespace scrim {
namespace {

/// Throws where `value` is none of `names`, letter case aside.
std::string readOneOf(const TomlValue& value, const std::vector<std::string>& names) {
    const std::string text = value.string();
    for (const std::string& name : names)
        if (equalIgnoringCase(name, text)) return name;
    value.failExpecting(choices(names));
}

/// Each at most once, in the order of Layer.
std::vector<Layer> readLayers(const TomlValue& value, const SceneOutput& output, const ColourConfig& colour) {
    const std::vector<std::string>& names = layerNames();
    std::vector<Layer> layers;
    for (const TomlValue& item : value.items(0, "a list of layers: " + choices(names))) {
        const auto layer = static_cast<Layer>(item.choice(names));
        if (std::find(layers.begin(), layers.end(), layer) != layers.end())
            item.fail(fmt::format("'{}' is '{}' again; expected each layer once", item.name(), item.string()));
        layers.push_back(layer);
    }
    std::sort(layers.begin(), layers.end());
    if (!layers.empty() && output.half && colour.isAces2065(output.colorspace))
        value.fail(
            "'layers' do not fit into an ACES container, which half floats in ACES2065-1 make; expected another "
            "'colorspace', or type = \"float\"");
    return layers;
}

ScenePreview readPreview(const TomlValue& value, const ReadContext& context) {
    ScenePreview preview;
    if (value.isString()) {
        preview.path = context.path(value);
    } else {
        if (!value.isTable()) value.failExpecting("a path, or a table with 'file', 'display' and 'view'");
        TomlTable table = value.table("'preview' of [output]");
        preview.path = context.path(table.require("file", "a path such as \"plume.####.png\""));
        if (const auto display = table.find("display"))
            preview.display = readOneOf(*display, context.colour.displays());
        const std::string display = preview.display.empty() ? context.colour.defaultDisplay() : preview.display;
        if (const auto view = table.find("view")) preview.view = readOneOf(*view, context.colour.views(display));
        table.finish();
    }
    preview.file = preview.path.at(context.fileFrame());
    return preview;
}

}  // namespace

SceneOutput defaultOutput(const ReadContext& context) {
    SceneOutput output;
    output.colorspace = context.colour.workingSpace();
    return output;
}

SceneOutput readOutput(TomlTable table, const ReadContext& context) {
    SceneOutput output = defaultOutput(context);
    if (const auto file = table.find("file")) {
        output.path = context.path(*file);
        output.file = output.path.at(context.fileFrame());
    }
    if (const auto space = table.find("colorspace"))
        output.colorspace = located(*space, [&] { return context.colour.resolve(space->string()); });
    output.half = table.choice("type", {"half", "float"}, 0) == 0;
    if (const auto layers = table.find("layers")) output.layers = readLayers(*layers, output, context.colour);
    const std::vector<std::string>& compressions = exrCompressions();
    if (const auto compression = table.find("compression"))
        output.compression = compressions[compression->choice(compressions)];
    output.fps = table.number("fps", output.fps, {0, 1e6, true, false, "frames a second"});
    if (const auto preview = table.find("preview")) output.preview = readPreview(*preview, context);
    table.finish();
    return output;
}

RenderSection readRender(TomlTable table) {
    RenderSection out;
    if (const auto quality = table.find("quality")) out.quality = presetNames()[quality->choice(presetNames())];
    out.dials = *presetDials(out.quality);
    if (const auto tolerance = table.find("tolerance"))
        out.tolerance = tolerance->number({0, 1, false, false, "as relative RMSE; 0 for none"});
    for (const DialInfo& dial : dialTable()) {
        const auto value = table.find(dial.name);
        if (!value) continue;
        if (out.tolerance > 0 && (dial.name == "texel" || dial.name == "sheet_thickness"))
            value->fail("'" + dial.name + "' cannot be given beside 'tolerance', which chooses it");
        if (value->isString())
            setDial(out.dials, dial.name, value->string(), value->where());
        else if (value->isNumber())
            setDial(out.dials, dial.name, value->number(), value->where());
        else
            value->failExpecting(dial.allowed);
    }
    table.finish();
    return out;
}

std::vector<std::pair<std::string, std::string>> readVariables(TomlTable table) {
    std::vector<std::pair<std::string, std::string>> variables;
    for (const TomlValue& value : table.all()) {
        if (value.isNumber())
            variables.emplace_back(value.name(), fmt::format("{}", value.number()));
        else if (value.isString())
            variables.emplace_back(value.name(), value.string());
        else
            value.failExpecting("a string or a number");
    }
    return variables;
}

}  // namespace scrim
