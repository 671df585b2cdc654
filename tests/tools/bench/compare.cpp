// SPDX-License-Identifier: Apache-2.0
// Error against time, Scrim beside its peers: a table for each asset. All settings are measured in turn, round after
// round, so that a machine whose speed drifts does not favour one of them; what counts are the ratios.
//
//     scrim_compare [--pixels N] [--rounds N] ASSET...      an ASSET is a .vdb or noise:RESOLUTION
#include "bench_scene.h"
#include "dense_marcher.h"

#include <scrim/base/parallel.h>
#include <scrim/engine/sweep.h>
#include <scrim/verify/verify.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace scrim::bench {
namespace {

double seconds(const std::function<void()>& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

struct Candidate {
    std::string tool, setting;
    std::function<Image()> render;
    std::vector<double> times;
    double error = 0;

    double median() {
        std::sort(times.begin(), times.end());
        return times[times.size() / 2];
    }
};

double errorOf(const Image& image, std::vector<VerifiedPixel> pixels) {
    setRendered(pixels, image);
    return summarise(pixels).error;
}

std::vector<Candidate> candidates(const ViewScene& scene, const DenseMarcher& dense) {
    std::vector<Candidate> all;
    for (const double texel : {0.5, 0.7, 1.0, 1.4})
        for (const double thickness : {1.0, 1.5, 2.0, 3.0}) {
            ViewScene turned = scene;
            turned.dials.texel = texel;
            turned.dials.sheetThickness = thickness;
            turned.dials.footprintSteps = texel < 1 ? 16 : 8;
            all.push_back({"scrim",
                           fmt::format("texel {} thickness {}", texel, thickness),
                           [turned] { return render(turned, makePlan(turned, threadCount())).image; },
                           {},
                           0});
        }
    for (const double step : {0.75, 1.0, 1.5})
        for (const auto& [coarseness, shadow] : {std::pair{1, 1.0}, {1, 2.0}, {2, 1.0}, {2, 2.0}, {3, 2.0}})
            all.push_back(
                {"light volume",
                 fmt::format("step {} cell {} ray {}", step, coarseness, shadow),
                 [&dense, step, cell = coarseness, ray = shadow] { return dense.withLightVolume(step, cell, ray); },
                 {},
                 0});
    for (const double step : {0.75, 1.0, 1.5})
        for (const double shadow : {1.0, 2.0, 3.0})
            all.push_back({"shadow rays",
                           fmt::format("step {} shadow {}", step, shadow),
                           [&dense, step, shadow] { return dense.withShadowRays(step, shadow); },
                           {},
                           0});
    return all;
}

void printCheapest(std::vector<Candidate>& all, double tolerance) {
    fmt::print("  cheapest at {:.1f} %:", 100 * tolerance);
    double own = 0;
    for (const char* tool : {"scrim", "light volume", "shadow rays"}) {
        Candidate* best = nullptr;
        for (Candidate& c : all)
            if (c.tool == tool && c.error <= tolerance && (!best || c.median() < best->median())) best = &c;
        if (!best) {
            fmt::print("  {}: none", tool);
            continue;
        }
        if (own == 0) own = best->median();
        fmt::print("  {}: {:.1f} ms ({}; {:.2f} %)", tool, 1e3 * best->median(), best->setting, 100 * best->error);
        if (best->tool != "scrim") fmt::print(" = {:.1f}x", best->median() / own);
    }
    fmt::print("\n");
}

void compare(const std::string& asset, int pixelCount, int rounds) {
    const ViewScene scene = benchScene(asset);
    const DenseMarcher dense(scene);
    std::vector<Candidate> all = candidates(scene, dense);
    const Image first = all.front().render();
    const std::vector<VerifiedPixel> pixels = samplePixels(scene, first, pixelCount, 1).pixels;
    for (Candidate& c : all) c.error = errorOf(c.render(), pixels);
    for (int round = 0; round < rounds; ++round)
        for (Candidate& c : all) c.times.push_back(seconds([&] { c.render(); }));

    fmt::print("\n{}: {} voxels, {} threads, {} reference pixels, median of {} rounds\n", assetLabel(asset),
               scene.volumes[0].field->activeVoxels, threadCount(), pixels.size(), rounds);
    fmt::print("  {:<14}{:<28}{:>10}{:>10}\n", "tool", "setting", "error %", "ms");
    for (Candidate& c : all)
        fmt::print("  {:<14}{:<28}{:>10.3f}{:>10.1f}\n", c.tool, c.setting, 100 * c.error, 1e3 * c.median());
    for (const double tolerance : {0.05, 0.02, 0.01, 0.005, 0.003}) printCheapest(all, tolerance);
}

}  // namespace
}  // namespace scrim::bench

int main(int argc, char** argv) {
    int pixels = 400, rounds = 5;
    std::vector<std::string> assets;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--pixels" && i + 1 < argc)
            pixels = std::stoi(argv[++i]);
        else if (argument == "--rounds" && i + 1 < argc)
            rounds = std::stoi(argv[++i]);
        else
            assets.push_back(argument);
    }
    if (assets.empty()) assets = {"noise:350"};
    for (const std::string& asset : assets) scrim::bench::compare(asset, pixels, rounds);
    return 0;
}
