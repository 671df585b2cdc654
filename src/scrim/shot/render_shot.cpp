// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/render_shot.h>

#include <scrim/base/parallel.h>
#include <scrim/base/timed.h>
#include <scrim/engine/plan/effects.h>
#include <scrim/engine/plan/expected_cost.h>
#include <scrim/engine/plan/report.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/sweep.h>
#include <scrim/shot/frame_report.h>
#include <scrim/shot/shot_motion.h>
#include <scrim/verify/moments_reference.h>
#include <scrim/verify/tolerance.h>
#include <scrim/verify/verify.h>

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace scrim {
namespace {

constexpr unsigned kVerifySeed = 1;  // any number will do, but a fixed one gives the same pixels in every run
// The fraction of a frame's progress at which rendering ends and verification begins.
constexpr double kRenderedOfVerified = 0.5;
static_assert(kVerifyAll == kAllPixels);

/// The origin of a volume's grids, for messages.
std::string originText(const SceneVolume& volume, const VolumeFile& file) {
    if (!volume.source.empty()) return "source '" + volume.source + "'";
    return file.path.empty() ? "volume '" + volume.name + "'" : file.path;
}

/// Warns of volumes of the picture that turn out to be empty.
void warnOfEmpty(const LoadedShot& shot, const MessageSink& messages) {
    const auto empty = [](const std::shared_ptr<const SparseField>& field) { return field && field->empty(); };
    for (std::size_t i = 0; i < shot.fields.size(); ++i) {
        const SceneVolume& volume = shot.scene.volumes[i];
        const VolumeFields& fields = shot.fields[i];
        const auto warn = [&](const char* what, const std::string& grid) {
            notify(messages, Severity::warning,
                   fmt::format("{}: {}: grid '{}' has no active voxels with values above 0 (below {:.2g} they count "
                               "as 0)",
                               originText(volume, shot.files[i]), what, grid, std::numeric_limits<float>::min()));
        };
        if (empty(fields.density) && (!fields.finer || empty(fields.finer)))
            warn(volume.emission.empty() ? "nothing to render" : "no density", fields.density->name);
        // A single empty channel is fine: colours without any red exist.
        if (std::all_of(fields.albedo.begin(), fields.albedo.end(), empty))
            warn("the albedo is black", volume.albedoGrid->grid);
        // Of colours a channel may be black.
        for (std::size_t k = 0; k < fields.emission.size(); ++k)
            if (empty(fields.emission[k]) && volume.emission[k].color == Rgb(1))
                warn("no emission", fields.emission[k]->name);
    }
}

/// The view with a deep picture if the scene asks for one.
ViewScene withDeep(ViewScene view, const SceneOutput& output) {
    if (!output.deep.file.empty()) view.deep = ViewDeep{output.deep.tolerance};
    return view;
}

/// "scene.toml:12:3: ", or "" for a scene without text.
std::string placeOf(const ViewScene& view, const std::string& key) {
    const std::string where = view.lines ? view.lines->of(key) : "";
    return where.empty() ? where : where + ": ";
}

// Warns of lights for which the preset's promise would need more sub-lights than are allowed.
void warnOfCappedLights(const ViewScene& view, const MessageSink& messages) {
    for (const Light& light : view.lights)
        if (light.extended() && light.samples == 0 && subLightCount(view, light) == kMostSubLights)
            notify(messages, Severity::warning,
                   fmt::format("light '{}' is rendered as {} lights, the maximum, but light_error = {:.2g} needs more; "
                               "samples = N sets another number",
                               light.name, kMostSubLights, view.dials.lightError));
}

/// Warns of skies whose detail is lost: multiply scattered light uses a few directions, and each
/// receives the mean of its part of the sky.
void warnOfBlurredSkies(const ViewScene& view, const Plan& plan, const MessageSink& messages) {
    if (const std::string skies = blurredSkies(view, plan.transport); !skies.empty())
        notify(messages, Severity::warning,
               "light " + skies + "; replace such a spot by a distant light with an angle to keep its shadows sharp");
}

/// Warns of shadows that are less sharp than the dials say.
void warnOfCoarserRasters(const ViewScene& view, const Plan& plan, const MessageSink& messages) {
    if (const std::string lights = coarserRasters(view, plan); !lights.empty())
        notify(messages, Severity::warning,
               fmt::format("shadow rasters have a largest size, so their cells are larger than shadow_texel says: {}",
                           lights));
}

/// Warns of lights that ask for cells and cannot have them.
void warnOfBuffers(const ViewScene& view, const Plan& plan, const MessageSink& messages) {
    for (std::size_t i = 0; i < view.lights.size(); ++i) {
        const Light& light = view.lights[i];
        if (light.shadow != ShadowMethod::cells || plan.cellLights.has(i) || !light.shadows) continue;
        notify(messages, Severity::warning,
               fmt::format("{}light '{}' uses shadow buffers instead of cells: {}",
                           placeOf(view, "light." + light.name + ".shadow"), light.name,
                           !plan.cellLights.unfit.empty() ? plan.cellLights.unfit
                                                          : "cells are for area lights, domes, suns with an angle and "
                                                            "points without a slide"));
    }
}

/// Warns of light on cells that the memory limit makes larger than they would be without it.
void warnOfLargerCells(const ViewScene& view, const Plan& plan, const MessageSink& messages) {
    const double coarser = plan.cellLights.coarser();
    if (view.memoryLimit == 0 || !(coarser > 1)) return;
    ViewScene free = view;
    free.memoryLimit = 0;
    const double without = makePlan(free, threadCount(), {}).cellLights.coarser();
    constexpr double kClearly = 1.01;
    if (coarser > kClearly * without)
        notify(messages, Severity::warning,
               fmt::format("the memory limit makes the cells that keep light {:.2g} times as large as they would be "
                           "without it, which blurs shadows",
                           coarser / without));
}

/// Warns of pictures that take long or much memory, before they do.
void warnOfCost(const LoadedShot& shot, const ViewScene& view, const Plan& plan, const MessageSink& messages) {
    const std::string cost = costWarning(view, plan, bytesOf(shot.fields), threadCount());
    if (!cost.empty()) notify(messages, Severity::warning, fmt::format("frame {:g}: {}", shot.scene.frame, cost));
}

/// Warns that a deep picture has one alpha, while the extinction of three channels differs.
void warnOfColouredDeep(const ViewScene& view, const MessageSink& messages) {
    if (view.deep && !greyExtinction(view))
        notify(messages, Severity::warning,
               fmt::format("{}extinction is coloured, but deep samples have one alpha for all channels: the deep "
                           "picture flattens to the flat one, but merging or inserting samples is approximate",
                           placeOf(view, "output.deep")));
}

/// Renders one frame, from its views to a picture.
class FrameRender {
  public:
    FrameRender(const LoadedShot& shot, const RenderOptions& options, ShotReport& report,
                const std::function<void(std::size_t)>& begins)
        : m_shot(shot), m_options(options), m_report(report), m_begins(begins), m_motion(shot, options) {}

    Frame run();

  private:
    Frame renderOnce(const ViewScene& view, const ViewScene& truth);
    Frame renderTolerance(const ViewScene& view, const ViewScene& truth);
    Frame renderPlanned(const ViewScene& view, const Plan& plan, const ProgressSink& progress) const;
    void keepPlan(const ViewScene& view, const Plan& plan);

    const LoadedShot& m_shot;
    const RenderOptions& m_options;
    ShotReport& m_report;
    const std::function<void(std::size_t)>& m_begins;
    const ShotMotion m_motion;
};

Frame FrameRender::run() {
    const Scene& scene = m_shot.scene;
    const ViewScene view = timed(m_report.seconds.plan, [&] { return withDeep(m_motion.view(), scene.output); });
    warnOfColouredDeep(view, m_options.messages);
    warnOfCappedLights(view, m_options.messages);
    // If nothing is visible, the reasons are worth a warning.
    if (view.volumes.empty())
        for (const auto& [name, reason] : view.culled)
            notify(m_options.messages, Severity::warning,
                   fmt::format("frame {}: volume '{}' is culled: {}", m_report.frame, name, reason));
    // The truth depends neither on culling nor on coarser levels.
    const ViewScene truth = isVerified(scene, m_options) ? m_motion.truth() : ViewScene{};
    checkVerifiable(truth);
    return scene.tolerance > 0 ? renderTolerance(view, truth) : renderOnce(view, truth);
}

void FrameRender::keepPlan(const ViewScene& view, const Plan& plan) {
    m_report.planJson = planAsJson(view, plan);
    warnOfCost(m_shot, view, plan, m_options.messages);
    if (m_options.planned)
        m_options.planned({false, m_report.planJson, planAsTable(view, plan), bytesOf(m_shot.fields),
                           roughPictureSeconds(view, plan, m_report.threads)});
    if (m_begins) m_begins(plan.bytes);
}

Frame FrameRender::renderPlanned(const ViewScene& view, const Plan& plan, const ProgressSink& progress) const {
    return m_motion.blurs() ? m_motion.render(view, plan, progress)
                            : scrim::render(view, plan, progress, m_options.shown);
}

Frame FrameRender::renderOnce(const ViewScene& view, const ViewScene& truth) {
    ShotTimes& seconds = m_report.seconds;
    const double rendered = m_options.verify > 0 ? kRenderedOfVerified : 1;
    const ProgressSink& progress = m_options.progress;
    const Plan plan = timed(seconds.plan, [&] { return makePlan(view, threadCount(), partOf(progress, 0, 0)); });
    keepPlan(view, plan);
    warnOfBlurredSkies(view, plan, m_options.messages);
    warnOfBuffers(view, plan, m_options.messages);
    warnOfLargerCells(view, plan, m_options.messages);
    warnOfCoarserRasters(view, plan, m_options.messages);
    Frame frame = timed(seconds.render, [&] { return renderPlanned(view, plan, partOf(progress, 0, rendered)); });
    if (m_options.verify > 0) {
        SampleOptions sampling;
        sampling.count = m_options.verify;
        sampling.seed = kVerifySeed;
        sampling.seconds = m_options.verifyLimit;
        sampling.progress = partOf(progress, rendered, 1);
        sampling.announce = m_options.announce;
        const PixelSample sample = timed(seconds.verify, [&] { return samplePixels(truth, frame.image, sampling); });
        m_report.verification = reportOf(summarise(sample), sample);
        if (!m_motion.blurs()) {
            const CaughtDifference caught =
                timed(seconds.verify, [&] { return differenceOfCaught(truth, frame, m_options.verify); });
            m_report.verification->caughtValues = caught.values;
            m_report.verification->caughtError = caught.rms;
            m_report.verification->caughtWorst = caught.worst;
        }
    }
    return frame;
}

Frame FrameRender::renderTolerance(const ViewScene& view, const ViewScene& truth) {
    ToleranceOptions options;
    options.tolerance = m_shot.scene.tolerance;
    if (m_options.verify > 0) options.pixels = m_options.verify;
    options.seed = kVerifySeed;
    options.seconds = m_options.verifyLimit;
    options.progress = m_options.progress;
    options.announce = m_options.announce;
    options.render = [&](const ViewScene& planned, const Plan& plan, const ProgressSink& progress) {
        return renderPlanned(planned, plan, progress);
    };
    bool warned = false;
    options.planned = [&](const ViewScene& planned, const Plan& plan) {
        keepPlan(planned, plan);
        if (!std::exchange(warned, true)) warnOfBlurredSkies(planned, plan, m_options.messages);
    };
    ToleranceResult result = renderWithin(view, truth, options);
    m_report.seconds.plan += result.seconds.pilots + result.seconds.plan;
    m_report.seconds.render += result.seconds.render;
    m_report.seconds.verify += result.seconds.verify;
    m_report.verification = reportOf(result.verification, result.sample);
    m_report.tolerance = {options.tolerance, result.predicted, result.dials.texel, result.dials.sheetThickness,
                          result.bound,      result.attempts,  result.met};
    return std::move(result.frame);
}

}  // namespace

bool isVerified(const Scene& scene, const RenderOptions& options) {
    return options.verify > 0 || scene.tolerance > 0;
}

PlannedShot planLoaded(const LoadedShot& shot, const RenderOptions& options) {
    const ViewScene view = withDeep(ShotMotion(shot, options).view(), shot.scene.output);
    const Plan plan = makePlan(view, threadCount(), partOf(options.progress, 0, 0));
    warnOfCost(shot, view, plan, options.messages);
    Dials dials = shot.scene.dials;
    const bool coarser = view.dials.texel != dials.texel || view.dials.sheetThickness != dials.sheetThickness;
    dials.texel = view.dials.texel;
    dials.sheetThickness = view.dials.sheetThickness;
    return {{false, planAsJson(view, plan), planAsTable(view, plan), bytesOf(shot.fields),
             roughPictureSeconds(view, plan, threadCount())},
            dials,
            coarser};
}

Frame renderLoaded(const LoadedShot& shot, const RenderOptions& options, ShotReport& report,
                   const std::function<void(std::size_t)>& begins) {
    report.threads = threadCount();
    warnOfEmpty(shot, options.messages);
    Frame frame = FrameRender(shot, options, report, begins).run();
    report.workJson = workAsJson(frame.work);
    if (frame.work.scatterSweeps > 0)
        report.scattering = {shot.scene.dials.scatterError, frame.scatterError, frame.scatterConverged};
    report.seconds.prepare = frame.times.prepare;
    report.seconds.scatter = frame.times.scatter;
    report.seconds.splat = frame.times.splat;
    report.seconds.attenuate = frame.times.attenuate;
    report.seconds.shade = frame.times.shade;
    report.seconds.composite = frame.times.composite;
    return frame;
}

}  // namespace scrim
