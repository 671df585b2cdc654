// SPDX-License-Identifier: Apache-2.0
// What each effect costs and how exact it is: put alone into a plain scene (key and fill, single scattering), and taken
// alone out of a scene that has them all. Settings are measured in turn, round after round; ratios are of medians.
//
//     scrim_effects [--rounds N] [--pixels N] ASSET...      an ASSET is a .vdb or noise:RESOLUTION
#include "bench_scene.h"

#include <scrim/shot/derived_fields.h>
#include <scrim/engine/sweep.h>
#include <scrim/verify/verify.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scrim::bench {
namespace {

struct BenchEffect {
    std::string name;
    std::function<void(ViewScene&)> add;
    bool inAll = true;  // whether it is one of those that are put together
};

Medium& medium(ViewScene& scene) {
    return scene.volumes.front().medium;
}

// A field of the same voxels with other values.
ViewField remapped(const ViewVolume& volume, const std::vector<std::pair<double, double>>& ramp) {
    std::vector<std::pair<double, double>> scaled = ramp;
    for (auto& point : scaled) point.first *= volume.field->maxValue;
    return {withRamp(*volume.field, scaled), volume.wsFromIs};
}

std::vector<BenchEffect> effects() {
    return {{"coloured extinction",
             [](ViewScene& s) {
                 medium(s).extinctionTint = {1, 0.7, 0.4};
             }},
            {"albedo grid",
             [](ViewScene& s) {
                 ViewVolume& v = s.volumes.front();
                 const double most = v.field->maxValue;
                 v.scatter = {remapped(v, {{0, 0}, {1, 0.9 * most}}), remapped(v, {{0, 0}, {1, 0.5 * most}}),
                              remapped(v, {{0, 0}, {0.5, 0.1 * most}, {1, 0.8 * most}})};
             }},
            {"emission, one field",
             [](ViewScene& s) {
                 ViewVolume& v = s.volumes.front();
                 v.emission = {{remapped(v, {{0, 0}, {0.5, 0}, {1, 1}}), {1, 0.5, 0.1}}};
             },
             false},
            {"emission, three fields",
             [](ViewScene& s) {
                 ViewVolume& v = s.volumes.front();
                 v.emission = {{remapped(v, {{0, 0}, {0.4, 0}, {1, 1}}), {1, 0, 0}},
                               {remapped(v, {{0, 0}, {0.5, 0}, {1, 1}}), {0, 0.5, 0}},
                               {remapped(v, {{0, 0}, {0.6, 0}, {1, 1}}), {0, 0, 0.1}}};
             }},
            {"phase, one lobe", [](ViewScene& s) { medium(s).phase.g = 0.6; }, false},
            {"phase, two lobes",
             [](ViewScene& s) {
                 medium(s).phase = {0.7, PhaseType::twoLobe, -0.3, 0.3};
             }},
            {"phase, Rayleigh", [](ViewScene& s) { medium(s).phase.type = PhaseType::rayleigh; }, false},
            {"octaves, 8", [](ViewScene& s) { medium(s).octaves.count = 8; }},
            {"light linking",
             [](ViewScene& s) {
                 s.volumes.front().lights = {true, false};
             },
             false},
            {"shadow linking",
             [](ViewScene& s) {
                 s.volumes.front().shadows = {true, false};
             },
             false},
            {"ambient",
             [](ViewScene& s) {
                 s.ambient = {0.1, 0.1, 0.2};
             }},
            {"layers, two lights", [](ViewScene& s) { s.layers = {Layer::light}; }, false},
            {"layers, all six kinds", [](ViewScene& s) {
                 s.layers = {Layer::light,  Layer::ambient, Layer::emission,
                             Layer::albedo, Layer::depth,   Layer::transmittance};
             }}};
}

struct Setting {
    ViewScene scene;
    std::vector<double> times = {};
    Frame frame = {};

    void round() {
        const auto begin = std::chrono::steady_clock::now();
        frame = render(scene, makePlan(scene, 2));
        times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
    double median() {
        std::sort(times.begin(), times.end());
        return times[times.size() / 2];
    }
};

void report(const std::string& asset, int rounds, int pixels) {
    ViewScene plain = benchScene(asset);
    plain.lights.push_back(plain.lights.front());
    plain.lights.back().name = "fill";
    plain.lights.back().intensity = Rgb(3);
    plain.lights.back().wsDirection =
        glm::normalize(plain.lights.front().wsDirection + 0.6 * Vec3(plain.camera.wsFromCamera[0]));
    const std::vector<BenchEffect> all = effects();
    const auto together = [&](const std::string& without) {
        ViewScene scene = plain;
        for (const BenchEffect& effect : all)
            if (effect.inAll && effect.name != without) effect.add(scene);
        return scene;
    };
    // Plain, all, and for each effect the one with it and the one without.
    std::vector<Setting> settings{{plain}, {together("")}};
    for (const BenchEffect& effect : all) {
        settings.push_back({plain});
        effect.add(settings.back().scene);
        settings.push_back({together(effect.name)});
    }
    for (Setting& s : settings) s.round();  // warm-up
    for (Setting& s : settings) s.times.clear();
    for (int r = 0; r < rounds; ++r)
        for (Setting& s : settings) s.round();

    const auto error = [&](const Setting& s) {
        if (pixels == 0) return std::string("-");
        return fmt::format("{:.2f}", 100 * summarise(samplePixels(s.scene, s.frame.image, pixels, 1)).error);
    };
    fmt::print("\n{}: {} voxels, 512 x 512, key and fill; plain {:.0f} ms ({} % error), all effects {:.0f} ms ({} %)\n",
               assetLabel(asset), plain.volumes[0].field->activeVoxels, 1e3 * settings[0].median(), error(settings[0]),
               1e3 * settings[1].median(), error(settings[1]));
    fmt::print("  {:<24}{:>8}{:>16}{:>9}{:>14}\n", "effect", "alone", "in company", "MB", "error, alone %");
    for (std::size_t i = 0; i < all.size(); ++i) {
        Setting &with = settings[2 + 2 * i], &without = settings[3 + 2 * i];
        const std::string company =
            all[i].inAll ? fmt::format("{:+.2f}", (settings[1].median() - without.median()) / settings[0].median())
                         : "";
        fmt::print("  {:<24}{:>+8.2f}{:>16}{:>9.0f}{:>14}\n", all[i].name, with.median() / settings[0].median() - 1,
                   company, static_cast<double>(with.frame.work.bytes.total()) / 1e6, error(with));
    }
    fmt::print("  (costs in plain pictures: +0.10 is a tenth of the plain one's time)\n");
}

}  // namespace
}  // namespace scrim::bench

int main(int argc, char** argv) {
    int rounds = 5, pixels = 0;
    std::vector<std::string> assets;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--rounds" && i + 1 < argc)
            rounds = std::stoi(argv[++i]);
        else if (argument == "--pixels" && i + 1 < argc)
            pixels = std::stoi(argv[++i]);
        else
            assets.push_back(argument);
    }
    for (const std::string& asset : assets) scrim::bench::report(asset, rounds, pixels);
    return assets.empty() ? 2 : 0;
}
