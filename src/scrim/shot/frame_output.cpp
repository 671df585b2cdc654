// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/frame_output.h>

#include <scrim/base/error.h>
#include <scrim/base/version.h>
#include <scrim/image/exr.h>
#include <scrim/image/preview.h>
#include <scrim/scene/layer_names.h>
#include <scrim/scene/plate_camera.h>
#include <scrim/shot/frame_report.h>

#include <fmt/format.h>

#include <utility>

namespace scrim {
namespace {

ExrAttributes attributesOf(const ShotFrame::Content& content) {
    const Scene& scene = content.scene;
    const ShotReport& report = content.report;
    ExrAttributes attributes{
        {"software", "scrim " + scrimVersion()},
        {"worldToCamera", worldToCamera(scene.camera)},
        {"worldToNDC", worldToNdc(scene.camera)},
        {"scrim:camera", cameraText(scene.camera)},
        {"framesPerSecond", exactFrameRate(scene.output.fps)},
        {"imageCounter", report.frame},
        {"scrim:version", scrimVersion()},
        {"scrim:scene", content.sceneToml},
        {"scrim:ocio:config", content.colour.name()},
        {"scrim:plan", withoutThreads(report.planJson)},
        {"scrim:stats", withoutThreads(report.workJson)},
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
    if (layer.light < 0) return nameOf(layer.layer);
    return nameOf(layer.layer) + "." + channelName(scene.lights[std::size_t(layer.light)].name);
}

ShotLayer shotLayer(const Scene& scene, FrameLayer layer) {
    const std::string name = layerName(scene, layer);
    if (layer.layer == Layer::depth) return {name, {"Z", name + ".mean"}, std::move(layer.data)};
    return {name, {name + ".R", name + ".G", name + ".B"}, std::move(layer.data)};
}

/// The RGB of a layer in the output's space, by way of a picture.
std::vector<float> converted(const ShotLayer& layer, const PixelWindow& window, const ColourConfig& colour,
                             const std::string& space) {
    Image image = emptyImage(window);
    for (std::size_t i = 0; i < layer.data.size(); ++i) image.rgba[i / 3 * 4 + i % 3] = layer.data[i];
    colour.convert(image, colour.workingSpace(), space);
    std::vector<float> data(layer.data.size());
    for (std::size_t i = 0; i < data.size(); ++i) data[i] = image.rgba[i / 3 * 4 + i % 3];
    return data;
}

/// What each of the working space's channels leaves of something: 1 where nothing is in the way, and no colour.
bool isShare(Layer layer) {
    return layer == Layer::transmittance || layer == Layer::shadow;
}

/// Depth is no colour, either.
ExrLayer exrLayer(const ShotFrame::Content& content, std::size_t i) {
    const ShotLayer& layer = content.layers[i];
    if (content.kinds[i] == Layer::depth) return {layer.channels, layer.data, true};
    if (isShare(content.kinds[i])) return {layer.channels, layer.data};
    return {layer.channels, converted(layer, content.image.window, content.colour, content.scene.output.colorspace)};
}

PixelWindow displayWindowOf(const Scene& scene) {
    return {0, 0, scene.camera.resolution.x, scene.camera.resolution.y};
}

}  // namespace

void takeFrame(ShotFrame::Content& content, Frame frame) {
    content.image = std::move(frame.image);
    for (FrameLayer& layer : frame.layers) {
        content.kinds.push_back(layer.layer);
        content.layers.push_back(shotLayer(content.scene, std::move(layer)));
    }
}

std::size_t writeFrame(const ShotFrame::Content& content, const std::string& path) {
    const SceneOutput& output = content.scene.output;
    const ColourConfig& colour = content.colour;
    ExrOptions options;
    options.half = output.half;
    options.compression = output.compression;
    options.displayWindow = displayWindowOf(content.scene);
    options.pixelAspect = content.scene.camera.pixelAspect;
    options.colorInteropId = colour.interopId(output.colorspace);
    options.acesContainer = output.half && content.layers.empty() && colour.isAces2065(output.colorspace);
    std::vector<ExrLayer> layers;
    for (std::size_t i = 0; i < content.layers.size(); ++i) {
        layers.push_back(exrLayer(content, i));
        // Where nothing is everything comes through: readers take what lies beyond the data window for 0.
        options.wholeWindow = options.wholeWindow || isShare(content.kinds[i]);
    }
    Image image = content.image;
    colour.convert(image, colour.workingSpace(), output.colorspace);
    return writeExr(path, image, options, attributesOf(content), layers);
}

void writeFramePreview(const ShotFrame::Content& content, const std::string& path) {
    const ScenePreview& preview = content.scene.output.preview;
    writePreview(path, content.image, displayWindowOf(content.scene), content.colour, preview.display, preview.view,
                 content.previewExposure);
}

void writePreviewOfPicture(const SceneOutput& output, FilePicture picture, const ColourConfig& colour,
                           double exposure) {
    if (!picture.problem.empty())
        throw Error(ErrorKind::input, fmt::format("cannot read '{}': {}", output.file, shortened(picture.problem)));
    Image image{{0, 0, picture.width, picture.height}, std::move(picture.rgba)};
    colour.convert(image, output.colorspace, colour.workingSpace());
    writePreview(output.preview.file, image, image.window, colour, output.preview.display, output.preview.view,
                 exposure);
}

}  // namespace scrim
