// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/shot_steadiness.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/base/system_error.h>
#include <scrim/base/timed.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/scene/quality.h>
#include <scrim/shot/shot_content.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace scrim {
namespace {

// True if frames may differ: by keys, a sequence of files, or a source that is told the frame.
bool changes(const Scene& scene) {
    return scene.moves || std::any_of(scene.volumes.begin(), scene.volumes.end(),
                                      [](const SceneVolume& volume) { return leadingSequence(volume).hasFrame(); });
}

// Layers whose values are no colours have no mean that errors are relative to.
void keepColours(Scene& scene) {
    const auto keep = [](std::vector<Layer>& layers) {
        std::erase_if(layers, [](Layer layer) {
            return layer == Layer::depth || layer == Layer::motion || layer == Layer::cryptomatte;
        });
    };
    keep(scene.output.layers);
    for (OutputFile& file : scene.output.files) keep(file.layers);
    scene.output.deep.file.clear();
}

// The first three of `channels` values a pixel.
std::vector<float> coloursOf(const std::vector<float>& data, std::size_t channels) {
    std::vector<float> rgb;
    rgb.reserve(data.size() / channels * 3);
    for (std::size_t i = 0; i + channels <= data.size(); i += channels)
        rgb.insert(rgb.end(), data.begin() + std::ptrdiff_t(i), data.begin() + std::ptrdiff_t(i + 3));
    return rgb;
}

}  // namespace

std::vector<std::string> ShotSteadinessResult::restless() const {
    std::vector<std::string> names;
    for (const LayerSteadiness& layer : layers)
        if (layer.all.excess > promised) names.push_back(layer.name);
    return names;
}

Dials convergedDials(const Dials& dials, double lightCell) {
    // From this error of lights on, their cells are half as large (engine/plan/transport_plan.cpp).
    constexpr double kFinestTexel = 0.05, kFinestSheet = 0.01, kFinestCell = 0.25, kFinestLights = 1e-4;
    constexpr double kFinestSweeps = 1e-6, kLessCutOff = 0.1, kLessSweeps = 0.25;
    constexpr int kMostDirections = 256, kMostSteps = 128;
    Dials finer = dials;
    finer.texel = std::max(0.5 * dials.texel, std::min(kFinestTexel, dials.texel));
    finer.sheetThickness = std::max(0.5 * dials.sheetThickness, std::min(kFinestSheet, dials.sheetThickness));
    finer.footprintSteps = std::min(2 * dials.footprintSteps, kMostSteps);
    finer.opacityCutoff = kLessCutOff * dials.opacityCutoff;
    finer.lightError = std::max(0.5 * dials.lightError, kFinestLights);
    if (lightCell > 0) finer.lightCell = std::max(0.5 * lightCell, kFinestCell);
    finer.lightCellOthers = std::max(0.5 * dials.lightCellOthers.value_or(1), kFinestCell);
    finer.scatterCell = std::max(0.5 * dials.scatterCell.value_or(kScatterCell), kFinestCell);
    if (dials.scatterDirections) finer.scatterDirections = std::min(2 * *dials.scatterDirections, kMostDirections);
    finer.scatterError = std::max(kLessSweeps * dials.scatterError, kFinestSweeps);
    finer.lod = 0;
    return finer;
}

ShotSteadiness::ShotSteadiness(Shot& shot, int frame, const RenderOptions& rendering, const Options& options)
    : m_shot(shot), m_rendering(rendering) {
    m_rendering.missing = MissingPolicy::error;
    m_rendering.verify = 0;
    withErrors([&] {
        Shot::Content& content = *shot.m_content;
        Scene scene = withOptions(content.sceneAt(frame, m_rendering), m_rendering, *content.stores);
        if (!changes(scene))
            throw Error(ErrorKind::usage,
                        fmt::format("{}: nothing in the scene is keyed, and no volume is a sequence of files, so all "
                                    "frames are equal",
                                    shot.path()));
        if (scene.tolerance > 0)
            throw Error(ErrorKind::usage, fmt::format("{}: a tolerance chooses other texels and sheets for each frame; "
                                                      "--quality chooses them once",
                                                      shot.path()));
        content.keepPromise(scene, m_rendering, ShotUse::plan);
        const Int2 size = scene.camera.resolution;
        const int longest = std::max(size.x, size.y);
        double part = 1;
        if (options.mostPixels > 0 && !m_rendering.crop && longest > options.mostPixels) {
            part = double(options.mostPixels) / longest;
            m_resolution = {std::max(1, int(std::lround(part * size.x))), std::max(1, int(std::lround(part * size.y)))};
        }
        m_result.quality = scene.quality;
        const auto loaded =
            loadShot(*content.stores, content.load, std::move(scene), m_rendering, VolumesOf::picture, ShotUse::plan);
        // The levels of grids that the whole picture has, whose pixels are smaller.
        Dials dials = loaded->scene.dials;
        const ViewScene view = loaded->view(m_rendering, dials.lod.value_or(0), VolumesOf::picture);
        if (dials.lod) dials.lod = part * *dials.lod;
        const CellLightPlan lights = makePlan(view, threadCount()).cellLights;
        const double smallest = lights.lights.empty() ? 0 : smallestCell(view, lights);  // 0: there are no cells
        m_result.promised = promisedError(m_result.quality, anyClassified(view));
        if (anyScattersFully(view))
            m_result.promised = std::max(m_result.promised, promisedScatteringError(m_result.quality));
        m_result.dials = dials;
        m_result.converged = convergedDials(dials, smallest);
        m_result.threads = threadCount();
    });
}

std::vector<SteadyLayer> ShotSteadiness::rendered(int frame, bool converged, RenderOptions options) {
    options.change = [&](Scene& scene) {
        if (m_rendering.change) m_rendering.change(scene);
        if (m_resolution.x > 0) scene.camera.resolution = m_resolution;
        // A scene that keeps its promise may still choose coarser texels for the renders that motion blur averages.
        scene.dials = converged ? m_result.converged : m_result.dials;
        scene.keepsPromise = scene.keepsPromise && !converged;
        keepColours(scene);
    };
    const ShotFrame shown = m_shot.render(frame, options);
    const Image& image = shown.image();
    m_result.resolution = {image.window.width(), image.window.height()};
    std::vector<SteadyLayer> layers{{"beauty", coloursOf(image.rgba, 4)}};
    for (const std::string& name : shown.layerNames()) {
        const ShotLayer& layer = shown.layer(name);
        if (layer.channels.size() >= 3) layers.push_back({name, coloursOf(layer.data, layer.channels.size())});
    }
    return layers;
}

void ShotSteadiness::add(int frame, const ProgressSink& progress) {
    constexpr double kPartOfFrame = 0.15;  // of the time of both
    timed(m_result.seconds, [&] {
        RenderOptions options = m_rendering;
        options.progress = partOf(progress, 0, kPartOfFrame);
        std::vector<SteadyLayer> shown = rendered(frame, false, options);
        options.progress = partOf(progress, kPartOfFrame, 1);
        options.messages = {};  // they would say the same again
        std::vector<SteadyLayer> truth = rendered(frame, true, options);
        if (!m_meter) m_meter.emplace(m_result.resolution.x);
        m_meter->add(frame, std::move(shown), std::move(truth));
    });
    m_result.frames.push_back(frame);
}

ShotSteadinessResult ShotSteadiness::result() const {
    ShotSteadinessResult out = m_result;
    if (m_meter) out.layers = m_meter->layers();
    return out;
}

}  // namespace scrim
