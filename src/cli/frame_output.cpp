// SPDX-License-Identifier: Apache-2.0
#include "frame_output.h"

#include <scrim/base/version.h>
#include <scrim/image/exr.h>
#include <scrim/image/preview.h>
#include <scrim/scene/layer_names.h>

#include <fmt/format.h>

#include <optional>
#include <utility>
#include <vector>

namespace scrim::cli {
namespace {

ExrAttributes attributesOf(const Scene& scene, const std::string& sceneToml, const ColourConfig& colour,
                           const FrameReport& report) {
    ExrAttributes attributes{
        {"software", "scrim " + scrimVersion()},
        {"worldToCamera", worldToCamera(scene.camera)},
        {"worldToNDC", worldToNdc(scene.camera)},
        {"framesPerSecond", exactFrameRate(scene.output.fps)},
        {"imageCounter", report.frame},
        {"scrim:version", scrimVersion()},
        {"scrim:scene", sceneToml},
        {"scrim:ocio:config", colour.name()},
        {"scrim:plan", report.planJson},
        {"scrim:stats", workAsJson(report.work)},
    };
    if (report.verification) {
        attributes.emplace_back("scrim:verify:error", report.verification->error);
        attributes.emplace_back("scrim:verify:lower", report.verification->lower);
        attributes.emplace_back("scrim:verify:upper", report.verification->upper);
        attributes.emplace_back("scrim:verify:alpha", report.verification->alphaError);
        attributes.emplace_back("scrim:verify:bias", report.verification->bias);
        attributes.emplace_back("scrim:verify:worst", report.verification->worst);
        attributes.emplace_back("scrim:verify:pixels", report.verification->pixels);
    }
    if (report.tolerance) {
        attributes.emplace_back("scrim:tolerance:wanted", report.tolerance->wanted);
        attributes.emplace_back("scrim:tolerance:predicted", report.tolerance->predicted);
        attributes.emplace_back("scrim:tolerance:bound", report.tolerance->bound);
        attributes.emplace_back("scrim:tolerance:met", report.tolerance->met ? 1 : 0);
    }
    return attributes;
}

std::string layerName(const Scene& scene, const FrameLayer& layer) {
    if (layer.layer != Layer::light) return nameOf(layer.layer);
    return nameOf(layer.layer) + "." + scene.lights[static_cast<std::size_t>(layer.light)].name;
}

/// The RGB of a layer in the output's space, by way of a picture.
std::vector<float> converted(const FrameLayer& layer, const PixelWindow& window, const ColourConfig& colour,
                             const std::string& space) {
    Image image = emptyImage(window);
    for (std::size_t i = 0; i < layer.data.size(); ++i) image.rgba[i / 3 * 4 + i % 3] = layer.data[i];
    colour.convert(image, colour.workingSpace(), space);
    std::vector<float> data(layer.data.size());
    for (std::size_t i = 0; i < data.size(); ++i) data[i] = image.rgba[i / 3 * 4 + i % 3];
    return data;
}

/// Depth is no colour, and transmittance is what each of the working space's channels leaves of what lies behind.
ExrLayer exrLayer(const Scene& scene, FrameLayer& layer, const PixelWindow& window, const ColourConfig& colour) {
    const std::string name = layerName(scene, layer);
    if (layer.layer == Layer::depth) return {{"Z", name + ".mean"}, std::move(layer.data), true};
    const std::vector<std::string> channels{name + ".R", name + ".G", name + ".B"};
    if (layer.layer == Layer::transmittance) return {channels, std::move(layer.data)};
    return {channels, converted(layer, window, colour, scene.output.colorspace)};
}

}  // namespace

void writeFrame(const Scene& scene, const std::string& sceneToml, const ColourConfig& colour, Frame frame,
                const FrameReport& report, Console& console) {
    Image& image = frame.image;
    const SceneOutput& output = scene.output;
    const bool withPreview = !output.preview.file.empty();
    // The preview starts from the working space, and is written last: the picture is what matters.
    const std::optional<Image> working = withPreview ? std::optional<Image>(image) : std::nullopt;

    ExrOptions options;
    options.half = output.half;
    options.compression = output.compression;
    options.displayWindow = {0, 0, scene.camera.resolution.x, scene.camera.resolution.y};
    options.pixelAspect = scene.camera.pixelAspect;
    options.colorInteropId = colour.interopId(output.colorspace);
    options.acesContainer = output.half && colour.isAces2065(output.colorspace);
    std::vector<ExrLayer> layers;
    for (FrameLayer& layer : frame.layers) {
        layers.push_back(exrLayer(scene, layer, image.window, colour));
        // Where nothing is everything comes through: readers take what lies beyond the data window for 0.
        options.wholeWindow = options.wholeWindow || layer.layer == Layer::transmittance;
    }
    colour.convert(image, colour.workingSpace(), output.colorspace);
    const std::size_t clamped =
        writeExr(output.file, image, options, attributesOf(scene, sceneToml, colour, report), layers);
    if (clamped > 0)
        console.warning(
            fmt::format("{}: {} values beyond the range of half floats were clamped; type = \"float\" "
                        "keeps them",
                        output.file, clamped));
    if (withPreview)
        writePreview(output.preview.file, *working, options.displayWindow, colour, output.preview.display,
                     output.preview.view);
}

}  // namespace scrim::cli
