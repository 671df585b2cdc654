// SPDX-License-Identifier: Apache-2.0
// Fuzz target: every scene that is not refused gives a picture that obeys physics (finite, no negative light, alpha
// from 0 to 1, no brighter than its lights can make it) and is the same, bit by bit, on one thread and on two.
#include "require.h"
#include "scene_of_bytes.h"

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/engine/sweep.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>

namespace scrim::fuzz {
namespace {

constexpr double kRounding = 1e-5;  // of sums of floats
constexpr double kSums = 1.02;      // a wide light is a sum over few directions, between which lobes are narrow
constexpr double kMostWork = 3e6;   // of whatever the plan counts: larger scenes teach no more
constexpr double kLargest = 1e30;   // beyond this floats may overflow, and need not be right

/// The most irradiance that `light` gives anywhere; infinite where nothing bounds it.
double mostOf(const Light& light, int c) {
    if (light.dome() || light.area()) return std::numbers::pi * light.intensity[c];
    if (light.distant() || !light.point().decay) return light.intensity[c];
    return light.intensity[c] == 0 ? 0 : light.intensity[c] / (light.point().radius * light.point().radius);
}

/// The radiance in front of a medium or surface that lets nothing through, if all light reached it unshadowed and was
/// scattered towards the eye as well as can be: with it the furnace test bounds every ray, since what scatters on the
/// way adds up to alpha.
double brightest(const ViewScene& scene, const ViewVolume& volume, int c) {
    double most = 0;
    if (const Classified* look = volume.classified.get()) {
        double colour = 0, light = 0;
        for (const TransferPoint& point : look->transfer) colour = std::max(colour, point.color[c]);
        for (const Light& l : scene.lights) light += mostOf(l, c) / std::numbers::pi;
        return colour * (look->ambient * scene.ambient[c] + look->diffuse * light) + look->specular * light;
    }
    if (!volume.emission.empty()) return std::numeric_limits<double>::infinity();
    // Every phase function is convex in the cosine: it is largest straight on or straight back.
    double phaseMost = 0, scattered = 0;
    for (int n = 0; n < volume.medium.octaves.count; ++n) {
        const Phase phase = flattened(volume.medium.phase, std::pow(volume.medium.octaves.phase, n));
        const double contribution = std::pow(volume.medium.octaves.contribution, n);
        phaseMost += contribution * std::max(phaseValue(phase, 1), phaseValue(phase, -1));
        scattered += contribution;
    }
    for (const Light& light : scene.lights)
        most += light.dome() || light.area() ? kSums * light.intensity[c] * scattered : mostOf(light, c) * phaseMost;
    return (volume.scatter.empty() ? volume.medium.albedo[c] : 1.0) * (most + scene.ambient[c]);
}

// Alpha is the mean over the channels: one of them may hide three times as much.
double channelAlpha(const ViewScene& scene, double alpha) {
    for (const ViewVolume& volume : scene.volumes)
        if (volume.medium.relativeTint() != Rgb(1)) return std::min(1.0, 3 * alpha);
    return alpha;
}

/// Tables of footprints, one a view and sweep, are work that plans do not count.
bool isSmall(const Plan& plan) {
    const RenderWork& work = plan.work;
    return double(work.footprints) + double(work.texelsShaded) + double(work.lightSamples) + double(work.pixelSheets) <=
               kMostWork &&
           plan.groups.size() <= (plan.perView ? 2 : 20);
}

void checkPicture(const ByteScene& scene, const Plan& plan, const Image& image) {
    require(image.window == scene.view.region, "another window");
    double most[3] = {0, 0, 0};
    for (const ViewVolume& volume : scene.view.volumes)
        for (int c = 0; c < 3; ++c) most[c] = std::max(most[c], brightest(scene.view, volume, c));
    // Light that comes from one side and scatters again is nowhere this much brighter.
    constexpr double kAgain = 10;
    // Nothing bounds it where light without shadows feeds the depth of a volume, in which it stays.
    if (anyScattersFully(scene.view))
        for (const Light& light : scene.view.lights)
            for (int c = 0; c < 3 && !light.shadows; ++c)
                if (light.intensity[c] > 0) most[c] = std::numeric_limits<double>::infinity();
    // Lamps are a few points each, next to which it is brighter than next to the lamp.
    const auto& lights = scene.view.lights;
    if (anyScattersFully(scene.view) || std::any_of(lights.begin(), lights.end(), std::mem_fn(&Light::area)))
        for (double& value : most) value *= kAgain;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        const float* rgba = image.rgba.data() + i;
        require(rgba[3] >= 0 && rgba[3] <= 1, "alpha {} at {}\n{}", rgba[3], i / 4, scene.toml);
        // Each sweep has its own sheets, and an alpha that differs a little from the picture's.
        const double alpha = plan.groups.size() > 1 ? 1 : channelAlpha(scene.view, rgba[3] + kRounding);
        for (int c = 0; c < 3; ++c) {
            if (!(most[c] <= kLargest)) continue;
            require(std::isfinite(rgba[c]) && rgba[c] >= 0, "radiance {} at {}\n{}", rgba[c], i / 4, scene.toml);
            require(rgba[c] <= alpha * most[c] * (1 + 1e-3), "radiance {} at {} (alpha {}), no more than {}\n{}",
                    rgba[c], i / 4, rgba[3], alpha * most[c], scene.toml);
        }
    }
}

}  // namespace
}  // namespace scrim::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace scrim;
    using namespace scrim::fuzz;
    try {
        const ByteScene scene = sceneOfBytes(data, size);
        const auto rendered = [&](int threads) {
            const Plan plan = makePlan(scene.view, threads);
            if (!isSmall(plan)) return emptyImage({});
            Image image = render(scene.view, plan).image;
            checkPicture(scene, plan, image);
            return image;
        };
        const Image one = rendered(1), two = rendered(2);
        require(one.rgba.empty() || std::memcmp(one.rgba.data(), two.rgba.data(), one.rgba.size() * sizeof(float)) == 0,
                "threads change the picture\n{}", scene.toml);
    } catch (const Error&) {  // refused: too wide a view, too little memory
    }
    return 0;
}
