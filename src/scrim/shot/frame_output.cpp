// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/frame_output.h>

#include <scrim/base/error.h>
#include <scrim/base/finite.h>
#include <scrim/base/version.h>
#include <scrim/image/known_spaces.h>
#include <scrim/image/backplate.h>
#include <scrim/image/cryptomatte.h>
#include <scrim/image/exr.h>
#include <scrim/image/exr_deep.h>
#include <scrim/image/preview.h>
#include <scrim/scene/layer_names.h>
#include <scrim/scene/plate_camera.h>
#include <scrim/shot/assemble.h>
#include <scrim/shot/frame_report.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace scrim {
namespace {

bool holds(const std::vector<Layer>& layers, Layer layer) {
    return std::find(layers.begin(), layers.end(), layer) != layers.end();
}

ExrAttributes attributesOf(const ShotFrame::Content& content, bool mattes) {
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
    // The attribute is read when crops are merged (exr_merge.h).
    if (const PixelWindow whole = pictureOf(scene), &part = content.image.window; part != whole)
        attributes.emplace_back("scrim:crop", fmt::format("{},{},{},{} of {},{},{},{}", part.x0, part.y0, part.x1,
                                                          part.y1, whole.x0, whole.y0, whole.x1, whole.y1));
    if (mattes) {
        std::vector<std::string> names;
        for (const SceneVolume& volume : scene.volumes) names.push_back(volume.name);
        for (const auto& [name, text] : cryptomatteAttributes(names)) attributes.emplace_back(name, text);
    }
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
    if (layer.volume >= 0)
        return nameOf(layer.layer) + "." + channelName(scene.volumes[std::size_t(layer.volume)].name);
    if (layer.light < 0) return nameOf(layer.layer);
    const Light& light = scene.lights[std::size_t(layer.light)];
    const bool grouped = layer.layer == Layer::light && !light.group.empty();
    return nameOf(layer.layer) + "." + channelName(grouped ? light.group : light.name);
}

ShotLayer shotLayer(const Scene& scene, FrameLayer layer) {
    const std::string name = layerName(scene, layer);
    if (layer.layer == Layer::depth) return {name, {"Z", name + ".mean"}, std::move(layer.data)};
    if (layer.layer == Layer::motion) return {name, {name + ".u", name + ".v"}, std::move(layer.data)};
    return {name, {name + ".R", name + ".G", name + ".B"}, std::move(layer.data)};
}

/// The RGB or RGBA of a layer in the output's space, converted by way of a picture.
std::vector<float> converted(const ShotLayer& layer, const PixelWindow& window, const ColourConfig& colour,
                             const std::string& space) {
    const std::size_t channels = layer.channels.size();
    Image image = emptyImage(window);
    for (std::size_t i = 0; i < layer.data.size(); ++i) image.rgba[i / channels * 4 + i % channels] = layer.data[i];
    colour.convert(image, colour.workingSpace(), space);
    std::vector<float> data(layer.data.size());
    for (std::size_t i = 0; i < data.size(); ++i) data[i] = image.rgba[i / channels * 4 + i % channels];
    return data;
}

/// Gives the layer of a volume its opacity as a fourth channel.
void addAlpha(ShotLayer& volume, const std::vector<float>& opacity) {
    std::vector<float> rgba(4 * opacity.size());
    for (std::size_t i = 0; i < opacity.size(); ++i) {
        std::copy_n(volume.data.begin() + std::ptrdiff_t(3 * i), 3, rgba.begin() + std::ptrdiff_t(4 * i));
        rgba[4 * i + 3] = opacity[i];
    }
    volume.data = std::move(rgba);
    volume.channels.push_back(volume.name + ".A");
}

/// Adds Cryptomatte, which is made from the opacities of the volumes.
void addMattes(ShotFrame::Content& content, std::vector<FrameLayer> opacities) {
    std::vector<MatteObject> objects;
    for (FrameLayer& opacity : opacities)
        objects.push_back({content.scene.volumes[std::size_t(opacity.volume)].name, std::move(opacity.data)});
    for (MatteLevel& level : cryptomatteLevels(objects)) {
        content.kinds.push_back(Layer::cryptomatte);
        content.layers.push_back({level.name, level.channels, std::move(level.data)});
    }
}

/// True for layers that hold a fraction of light in each working-space channel: 1 where nothing is
/// in the way. They are not colours and are not converted.
bool isShare(Layer layer) {
    return layer == Layer::transmittance || layer == Layer::shadow;
}

/// Depth, motion and mattes are not colours, either.
ExrLayer exrLayer(const ShotFrame::Content& content, std::size_t i, const std::string& space) {
    const ShotLayer& layer = content.layers[i];
    if (content.kinds[i] == Layer::depth || content.kinds[i] == Layer::motion || content.kinds[i] == Layer::cryptomatte)
        return {layer.channels, layer.data, true};
    if (isShare(content.kinds[i])) return {layer.channels, layer.data};
    return {layer.channels, converted(layer, content.image.window, content.colour, space)};
}

[[noreturn]] void refuseValue(int frame, float value, const std::string& channel, int x, int y) {
    throw Error(ErrorKind::render,
                fmt::format("frame {}: '{}' is {} at pixel {},{}; nothing is written. A light that is too bright for "
                            "floats can cause this; if no light is, please report a bug",
                            frame, channel, std::isnan(value) ? "NaN" : "infinite", x, y));
}

/// `values` holds one value per channel for each pixel of `window`, interleaved.
void checkFinite(int frame, const PixelWindow& window, const std::vector<std::string>& channels,
                 const std::vector<float>& values) {
    if (allFinite(values)) return;
    const auto at = std::size_t(std::find_if_not(values.begin(), values.end(), isFinite) - values.begin());
    const std::size_t pixel = at / channels.size(), width = std::size_t(window.width());
    refuseValue(frame, values[at], channels[at % channels.size()], window.x0 + static_cast<int>(pixel % width),
                window.y0 + static_cast<int>(pixel / width));
}

const std::vector<std::string> kRgba{"R", "G", "B", "A"};

void checkFinite(int frame, const DeepImage& deep) {
    for (std::size_t y = 0; y < deep.rows.size(); ++y)
        for (std::size_t i = 0; i < deep.rows[y].pieces.size(); ++i)
            for (std::size_t c = 0; c < kRgba.size(); ++c) {
                const float value = deep.rows[y].pieces[i].shown[c];
                if (isFinite(value)) continue;
                const auto& first = deep.rows[y].first;
                const auto x = std::upper_bound(first.begin(), first.end(), i) - first.begin() - 1;
                refuseValue(frame, value, kRgba[c], deep.window.x0 + static_cast<int>(x),
                            deep.window.y0 + static_cast<int>(y));
            }
}

PixelWindow displayWindowOf(const Scene& scene) {
    return {0, 0, scene.camera.resolution.x, scene.camera.resolution.y};
}

// The header options that flat and deep pictures share.
ExrOptions headerOptions(const ShotFrame::Content& content, const std::string& space) {
    ExrOptions options;
    options.displayWindow = displayWindowOf(content.scene);
    options.pixelAspect = content.scene.camera.pixelAspect;
    options.colorInteropId = content.colour.interopId(space);
    const KnownSpace* const known = findKnownSpace(options.colorInteropId);
    if (known != nullptr && (content.scene.output.chromaticities || content.colour.isAces2065(space)))
        options.chromaticities = known->chromaticities;
    return options;
}

// Converts a row of the deep picture: the accumulated colours at the ends of all pieces are converted like pictures, so
// that the end of each pixel's curve equals the flat picture in every colour space.
void convertDeep(DeepImage& deep, const ColourConfig& colour, const std::string& space) {
    for (DeepImage::Row& row : deep.rows) {
        if (row.pieces.empty()) continue;
        Image image = emptyImage({0, 0, static_cast<int>(row.pieces.size()), 1});
        for (std::size_t i = 0; i < row.pieces.size(); ++i)
            std::copy(row.pieces[i].shown.begin(), row.pieces[i].shown.end(),
                      image.rgba.begin() + std::ptrdiff_t(4 * i));
        colour.convert(image, colour.workingSpace(), space);
        for (std::size_t i = 0; i < row.pieces.size(); ++i)
            std::copy_n(image.rgba.begin() + std::ptrdiff_t(4 * i), 4, row.pieces[i].shown.begin());
    }
}

}  // namespace

void takeFrame(ShotFrame::Content& content, Frame frame) {
    const std::vector<Layer> wanted = content.scene.output.allLayers();
    if (!holds(wanted, Layer::indirect))
        std::erase_if(frame.layers, [](const FrameLayer& layer) { return layer.layer == Layer::indirect; });
    content.image = std::move(frame.image);
    content.deep = std::move(frame.deep);
    const auto first = std::stable_partition(frame.layers.begin(), frame.layers.end(),
                                             [](const FrameLayer& layer) { return layer.layer != Layer::cryptomatte; });
    std::vector<FrameLayer> opacities(std::make_move_iterator(first), std::make_move_iterator(frame.layers.end()));
    frame.layers.erase(first, frame.layers.end());
    for (FrameLayer& layer : frame.layers) {
        const int volume = layer.layer == Layer::volume ? layer.volume : -1;
        content.kinds.push_back(layer.layer);
        content.layers.push_back(shotLayer(content.scene, std::move(layer)));
        for (const FrameLayer& opacity : opacities)
            if (opacity.volume == volume) addAlpha(content.layers.back(), opacity.data);
    }
    if (holds(wanted, Layer::cryptomatte)) addMattes(content, std::move(opacities));
    // Values are checked here, and once more wherever they are converted, so that no file, preview
    // or array holds anything but finite numbers.
    const int number = content.report.frame;
    checkFinite(number, content.image.window, kRgba, content.image.rgba);
    for (const ShotLayer& layer : content.layers) checkFinite(number, content.image.window, layer.channels, layer.data);
    if (content.deep) checkFinite(number, *content.deep);
}

std::size_t writeFrame(const ShotFrame::Content& content, const OutputFile& output, const std::string& path) {
    const ColourConfig& colour = content.colour;
    ExrOptions options = headerOptions(content, output.colorspace);
    options.picture = output.picture;
    options.half = output.half;
    options.compression = output.compression;
    options.acesContainer =
        output.picture && output.half && output.layers.empty() && colour.isAces2065(output.colorspace);
    const bool converts = output.colorspace != colour.workingSpace();
    std::vector<ExrLayer> layers;
    for (std::size_t i = 0; i < content.layers.size(); ++i) {
        if (!holds(output.layers, content.kinds[i])) continue;
        layers.push_back(exrLayer(content, i, output.colorspace));
        if (converts)
            checkFinite(content.report.frame, content.image.window, layers.back().channels, layers.back().data);
        // Where nothing is in the way the value is 1, but readers take pixels outside of the data
        // window for 0. Therefore the whole window is written.
        options.wholeWindow = options.wholeWindow || isShare(content.kinds[i]);
    }
    const ExrAttributes attributes = attributesOf(content, holds(output.layers, Layer::cryptomatte));
    if (!output.picture) return writeExr(path, content.image, options, attributes, layers);
    Image image = content.image;
    colour.convert(image, colour.workingSpace(), output.colorspace);
    if (converts) checkFinite(content.report.frame, image.window, kRgba, image.rgba);
    return writeExr(path, image, options, attributes, layers);
}

std::size_t writeFrameDeep(const ShotFrame::Content& content, const std::string& path) {
    const SceneOutput& output = content.scene.output;
    ExrOptions options = headerOptions(content, output.colorspace);
    options.half = output.deep.half;
    if (output.colorspace == content.colour.workingSpace())
        return writeDeepExr(path, *content.deep, options, attributesOf(content, false));
    DeepImage deep = *content.deep;
    convertDeep(deep, content.colour, output.colorspace);
    checkFinite(content.report.frame, deep);
    return writeDeepExr(path, deep, options, attributesOf(content, false));
}

namespace {

void writePreviewOf(const ShotFrame::Content& content, const Image& image, const PixelWindow& window,
                    const std::string& path) {
    const ScenePreview& preview = content.scene.output.preview;
    PreviewLook look{preview.display, preview.view, content.previewExposure};
    if (preview.annotate) look.marks = {content.scene.camera, content.wsMiddle};
    const bool plate = preview.backplate && preview.backplate->image;
    writePreview(path, plate ? overPlate(image, *preview.backplate->image, window) : image, window, content.colour,
                 look);
}

}  // namespace

Image backplateOf(const ShotFrame::Content& content) {
    const auto& plate = content.scene.output.preview.backplate;
    const PixelWindow window = displayWindowOf(content.scene);
    return plate && plate->image ? overPlate(emptyImage(window), *plate->image, window) : Image{};
}

void writeFramePreview(const ShotFrame::Content& content, const std::string& path) {
    writePreviewOf(content, content.image, displayWindowOf(content.scene), path);
}

void writePreviewOfPicture(const ShotFrame::Content& content, FilePicture picture) {
    const SceneOutput& output = content.scene.output;
    if (!picture.problem.empty())
        throw Error(ErrorKind::input, fmt::format("cannot read '{}': {}", output.file, shortened(picture.problem)));
    Image image{{0, 0, picture.width, picture.height}, std::move(picture.rgba)};
    content.colour.convert(image, output.colorspace, content.colour.workingSpace());
    writePreviewOf(content, image, image.window, output.preview.file);
}

}  // namespace scrim
