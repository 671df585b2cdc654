// SPDX-License-Identifier: Apache-2.0
// What things cost: a light, a further sweep, a second thread, each stage per unit of its work, and memory. Settings
// are measured in turn, round after round; ratios are of medians.
//
//     scrim_costs [--rounds N] ASSET...      an ASSET is a .vdb or noise:RESOLUTION
#include "bench_scene.h"

#include <scrim/base/simd.h>
#include <scrim/engine/sweep.h>

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <chrono>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scrim::bench {
namespace {

struct Setting {
    std::string label;
    ViewScene scene;
    int threads = 2;
    std::vector<double> times;
    Frame frame;  // of the fastest round
    double best = 1e9;

    void round() {
        const auto begin = std::chrono::steady_clock::now();
        Frame result = render(scene, makePlan(scene, threads));
        times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
        if (times.back() < best) {
            best = times.back();
            frame = std::move(result);
        }
    }
    double median() {
        std::sort(times.begin(), times.end());
        return times[times.size() / 2];
    }
};

// Distant lights spread evenly over the sphere (a Fibonacci lattice): the worst case for grouping.
void lightsAllRound(ViewScene& scene, int count) {
    const Light first = scene.lights.front();
    scene.lights.clear();
    for (int i = 0; i < count; ++i) {
        const double z = 1 - 2 * (i + 0.5) / count, r = std::sqrt(1 - z * z), angle = 2.399963 * i;
        Light light = first;
        light.name = fmt::format("light{}", i);
        light.wsDirection = {r * std::cos(angle), r * std::sin(angle), z};
        scene.lights.push_back(light);
    }
}

std::vector<Setting> settings(const ViewScene& one) {
    std::vector<Setting> all;
    const auto add = [&](const std::string& label, const ViewScene& scene, int threads = 2) {
        all.push_back({label, scene, threads, {}, {}, 1e9});
    };
    ViewScene unshadowed = one;
    unshadowed.lights[0].shadows = false;
    add("one light, no shadow", unshadowed);
    add("one light, shadow", one);
    for (const int count : {2, 4, 8, 16}) {
        ViewScene scene = one;
        addLights(scene, count);
        add(fmt::format("{} lights, one sweep", count), scene);
    }
    ViewScene behind = one;
    behind.lights.push_back(behind.lights.front());
    behind.lights.back().name = "behind";
    behind.lights.back().wsDirection = -one.lights.front().wsDirection;
    add("2 lights, two sweeps", behind);
    for (const int count : {4, 8, 16}) {
        ViewScene scene = one;
        lightsAllRound(scene, count);
        add(fmt::format("{} lights, all round", count), scene);
    }
    ViewScene perView = one;
    perView.dials.splat = SplatMode::perView;
    add("one light, shadow, per-view", perView);
    perView.lights[0].shadows = false;
    add("one light, no shadow, per-view", perView);
    add("one light, shadow, 1 thread", one, 1);
    return all;
}

void report(const std::string& asset, int rounds) {
    ViewScene scene = benchScene(asset);
    const auto& field = *scene.volumes[0].field;
    fmt::print("\n{}: {} voxels in {} blocks, 512 x 512, {}\n", assetLabel(asset), field.activeVoxels,
               field.blockCount(), Simd().target());
    std::vector<Setting> all = settings(scene);
    for (Setting& s : all) s.round();  // warm-up
    for (Setting& s : all) s.times.clear();
    for (int r = 0; r < rounds; ++r)
        for (Setting& s : all) s.round();

    const double base = all[0].median();
    fmt::print("  {:<32}{:>9}{:>12}{:>9}\n", "setting", "ms", "x unshadowed", "MB");
    for (Setting& s : all)
        fmt::print("  {:<32}{:>9.1f}{:>12.2f}{:>9.0f}\n", s.label, 1e3 * s.median(), s.median() / base,
                   static_cast<double>(s.frame.work.bytes.total()) / 1e6);
    fmt::print("  each further light, up to 8: +{:.3f} of the unshadowed picture\n",
               (all[4].median() - all[1].median()) / 7 / base);
    fmt::print("  two threads are {:.2f}x as fast as one\n", all.back().median() / all[1].median());

    const Setting& single = all.back();
    const RenderWork& w = single.frame.work;
    const StageTimes& t = single.frame.times;
    const auto blockVoxels = static_cast<double>(field.blockCount() * kBlockVoxels);
    fmt::print(
        "  stages on one core: splat {:.1f} ns a voxel ({:.1f} a voxel of its blocks), {:.1f} ns a footprint; "
        "attenuate {:.2f} ns a light sample; shade {:.2f} ns a texel; composite {:.2f} ns a pixel and sheet\n",
        1e9 * t.splat / static_cast<double>(w.voxelsFed), 1e9 * t.splat / blockVoxels,
        1e9 * t.splat / static_cast<double>(w.footprints), 1e9 * t.attenuate / static_cast<double>(w.lightSamples),
        1e9 * t.shade / static_cast<double>(w.texelsShaded), 1e9 * t.composite / static_cast<double>(w.pixelSheets));

    ViewScene large = benchScene(asset, {1920, 1080});
    addLights(large, 4);
    const Plan plan = makePlan(large, 2);
    const Frame frame = render(large, plan);
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    fmt::print("  1920 x 1080, 4 lights: buffers planned {:.0f} MB, grid {:.0f} MB, resident at most {:.0f} MB\n",
               static_cast<double>(plan.bytes) / 1e6, blockVoxels * 4 / 1e6,
               static_cast<double>(usage.ru_maxrss) / 1e3);
}

}  // namespace
}  // namespace scrim::bench

int main(int argc, char** argv) {
    int rounds = 9;
    std::vector<std::string> assets;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--rounds" && i + 1 < argc)
            rounds = std::stoi(argv[++i]);
        else
            assets.push_back(argument);
    }
    if (assets.empty()) assets = {"noise:350"};
    for (const std::string& asset : assets) scrim::bench::report(asset, rounds);
    return 0;
}
