// SPDX-License-Identifier: Apache-2.0
#include "frame_output.h"

#include <scrim/base/version.h>
#include <scrim/image/exr.h>
#include <scrim/image/preview.h>

#include <fmt/format.h>

#include <optional>

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
        attributes.emplace_back("scrim:verify:bias", report.verification->bias);
        attributes.emplace_back("scrim:verify:worst", report.verification->worst);
        attributes.emplace_back("scrim:verify:pixels", report.verification->pixels);
    }
    if (report.tolerance) {
        attributes.emplace_back("scrim:tolerance:wanted", report.tolerance->wanted);
        attributes.emplace_back("scrim:tolerance:predicted", report.tolerance->predicted);
    }
    return attributes;
}

}  // namespace

void writeFrame(const Scene& scene, const std::string& sceneToml, const ColourConfig& colour, Image image,
                const FrameReport& report, Console& console) {
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
    colour.convert(image, colour.workingSpace(), output.colorspace);
    const std::size_t clamped = writeExr(output.file, image, options, attributesOf(scene, sceneToml, colour, report));
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
