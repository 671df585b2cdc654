// SPDX-License-Identifier: Apache-2.0
#include "scenes.h"
#include "support/luminaires.h"

#include <scrim/base/parallel.h>
#include <scrim/verify/path_tracer.h>
#include <scrim/volume/field_sampler.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr int kRadius = 20;

Medium& medium(ViewScene& scene) {
    return scene.volumes.front().medium;
}

ViewField scaled(const ViewVolume& volume, const std::function<double(const Vec3&)>& factor) {
    const FieldSampler probe(*volume.field, Kernel::linear);
    return {
        makeField(Int3(-kRadius), Int3(kRadius), 1, [&](const Vec3& is) { return factor(is) * probe.voxel(Int3(is)); }),
        volume.wsFromIs};
}

}  // namespace

ViewScene plainScene() {
    Medium medium;
    medium.densityScale = 0.12;
    medium.albedo = Rgb(0.8, 0.7, 0.9);
    ViewScene scene = orthographicScene(smokeField(kRadius), medium, 44, 48);
    scene.lights = {distantLight({-1, -1, -0.5}, 5), distantLight({1, 0.2, 0.8}, 2)};
    scene.lights[0].name = "key";
    scene.lights[1].name = "fill";
    return scene;
}

ViewField flameField() {
    return {makeField(Int3(-12), Int3(12), 1,
                      [](const Vec3& is) { return std::max(0.0, 1 - glm::length(is - Vec3(2, -3, 1)) / 11); }),
            Mat4(1.0)};
}

std::vector<ViewField> colouredScatter(const ViewVolume& volume) {
    std::vector<ViewField> channels;
    for (int c = 0; c < 3; ++c)
        channels.push_back(scaled(volume, [c](const Vec3& is) { return 0.5 + 0.4 * std::sin(0.2 * is[c] + c); }));
    return channels;
}

const std::vector<EffectCase>& effectCases() {
    static const std::vector<EffectCase> cases{
        {"coloured extinction",
         [](ViewScene& s) {
             medium(s).extinctionTint = {1, 0.6, 0.3};
         }},
        {"two tints",
         [](ViewScene& s) {
             medium(s).extinctionTint = {1, 0.6, 0.3};
             s.volumes.push_back(s.volumes.front());
             s.volumes.back().medium.extinctionTint = {0.2, 0.5, 1};
             s.volumes.back().wsFromIs[3] = {9, 4, -6, 1};
         }},
        {"tints in each other's shadow",
         [](ViewScene& s) {
             s.camera.height = 80;
             s.lights[0].wsDirection = glm::normalize(Vec3(-1, 0.1, -0.3));
             s.volumes.push_back(s.volumes.front());
             s.volumes.back().wsFromIs[3] = {34, -3, 8, 1};
             medium(s).extinctionTint = {1, 0.6, 0.3};
         }},
        {"four tints",
         [](ViewScene& s) {
             medium(s).extinctionTint = {1, 0.6, 0.3};
             for (int i = 1; i < 4; ++i) {
                 s.volumes.push_back(s.volumes.front());
                 s.volumes.back().medium.extinctionTint = {0.2 * i, 1 - 0.2 * i, 1};
                 s.volumes.back().wsFromIs[3] = {4 * i, 3 - 2 * i, -3 * i, 1};
             }
         }},
        {"albedo grid", [](ViewScene& s) { s.volumes.front().scatter = colouredScatter(s.volumes.front()); }},
        {"emission",
         [](ViewScene& s) {
             s.volumes.front().emission = {{flameField(), {0.4, 0.2, 0.05}}};
         }},
        {"two-lobe phase",
         [](ViewScene& s) {
             medium(s).phase = {0.7, PhaseType::twoLobe, -0.3, 0.4};
         }},
        {"rayleigh phase", [](ViewScene& s) { medium(s).phase.type = PhaseType::rayleigh; }},
        {"octaves",
         [](ViewScene& s) {
             medium(s).phase.g = 0.5;
             medium(s).octaves.count = 5;
         }},
        {"light linking",
         [](ViewScene& s) {
             s.volumes.push_back(s.volumes.front());
             s.volumes.back().wsFromIs[3] = {6, -5, 4, 1};
             s.volumes.back().lights = {false, true};
         }},
        {"shadow linking",
         [](ViewScene& s) {
             s.volumes.push_back(s.volumes.front());
             s.volumes.back().wsFromIs[3] = {6, -5, 4, 1};
             s.volumes.front().shadows = {true, false};
             s.volumes.push_back(s.volumes.front());
             s.volumes.back().wsFromIs[3] = {-8, 7, 9, 1};
             s.volumes.back().shadows = {false, false};
         }},
        {"shadow linking of two tints",
         [](ViewScene& s) {
             medium(s).extinctionTint = {1, 0.6, 0.3};
             s.volumes.push_back(s.volumes.front());
             s.volumes.back().wsFromIs[3] = {6, -5, 4, 1};
             s.volumes.back().medium.extinctionTint = {0.2, 0.5, 1};
             s.volumes.back().shadows = {false, true};
             s.volumes.push_back(s.volumes.front());
             s.volumes.back().wsFromIs[3] = {-8, 7, 9, 1};
             s.volumes.back().shadows = {true, false};
         }},
        {"two interpolations",
         [](ViewScene& s) {
             s.volumes.front().kernel = Kernel::bspline;
             s.volumes.push_back(s.volumes.front());
             s.volumes.back().kernel.reset();
             s.volumes.back().wsFromIs[3] = {6, -5, 4, 1};
         }},
        {"luminaire",
         [](ViewScene& s) {
             Light& light = s.lights[0];
             light.kind = Light::Point{};
             light.wsPosition = -60.0 * light.wsDirection;
             light.intensity *= 3600.0;
             light.luminaire = luminaireOf("batwing");
         }},
        {"ambient",
         [](ViewScene& s) {
             s.ambient = {0.1, 0.2, 0.3};
         }},
        {"all at once", [](ViewScene& s) {
             medium(s).extinctionTint = {1, 0.6, 0.3};
             medium(s).phase = {0.7, PhaseType::twoLobe, -0.3, 0.4};
             medium(s).octaves.count = 3;
             s.volumes.front().scatter = colouredScatter(s.volumes.front());
             s.volumes.front().emission = {{flameField(), {0.4, 0.2, 0.05}}};
             s.volumes.push_back(s.volumes.front());
             s.volumes.back().medium.extinctionTint = Rgb(1);
             s.volumes.back().emission.clear();
             s.volumes.back().wsFromIs[3] = {6, -5, 4, 1};
             for (ViewField& f : s.volumes.back().scatter) f.wsFromIs = s.volumes.back().wsFromIs;
             s.volumes.back().lights = {false, true};
             s.ambient = {0.1, 0.2, 0.3};
         }}};
    return cases;
}

ViewScene sceneWith(const std::string& effect) {
    for (const EffectCase& c : effectCases())
        if (c.name == effect) {
            ViewScene scene = plainScene();
            c.add(scene);
            return scene;
        }
    throw std::logic_error("no effect case '" + effect + "'");
}

ViewScene haze(double sigma) {
    Medium medium;
    medium.densityScale = sigma;
    medium.albedo = Rgb(1);
    ViewScene scene = orthographicScene(boxField({-40, -40, -10}, {39, 39, 9}), medium, 20, 20);
    scene.dials.sheetThickness = 1.3;
    return scene;
}

BlockError blockError(const ViewScene& scene, int paths) {
    constexpr int kBlock = 8;
    ViewScene once = scene;
    for (ViewVolume& volume : once.volumes) {
        volume.medium.scattering = Scattering::single;
        if (!volume.classified) continue;
        Classified look = *volume.classified;
        look.scatters = false;
        volume.classified = std::make_shared<const Classified>(look);
    }
    once.ambient = Rgb(0);
    const Frame full = renderScene(scene), single = renderScene(once);
    const PathTracer tracer(scene);
    const int size = scene.camera.resolution.x;
    std::vector<Estimate> pixels(std::size_t(size) * std::size_t(size));
    parallelFor(pixels.size(), [&](std::size_t i) {
        pixels[i] = tracer.pixel(static_cast<int>(i) % size, static_cast<int>(i) / size, paths);
    });
    double square = 0, variance = 0, all = 0, multiple = 0, blocks = 0;
    for (int y = 0; y < size; y += kBlock)
        for (int x = 0; x < size; x += kBlock, ++blocks) {
            double difference = 0, noise = 0;
            for (int i = 0; i < kBlock * kBlock; ++i) {
                const int px = x + i % kBlock, py = y + i / kBlock;
                const Estimate& truth = pixels[std::size_t(py) * std::size_t(size) + std::size_t(px)];
                const double rendered = pixelOf(full, px, py)[1], before = pixelOf(single, px, py)[1];
                difference += (rendered - before - truth.mean.y) / (kBlock * kBlock);
                noise += truth.variance.y / std::pow(kBlock * kBlock, 2);
                all += rendered / (kBlock * kBlock);
                multiple += truth.mean.y / (kBlock * kBlock);
            }
            square += difference * difference - noise;
            variance += noise;
        }
    return {std::sqrt(std::max(square, 0.0) / blocks) / (all / blocks), std::sqrt(variance / blocks) / (all / blocks),
            multiple / all};
}

}  // namespace scrim::test
