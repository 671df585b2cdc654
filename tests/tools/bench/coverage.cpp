// SPDX-License-Identifier: Apache-2.0
// Does a tolerance keep its word? Forty scenes that are small enough for the reference of every pixel are rendered
// within a tolerance under twenty seeds each; the bound that each run states is compared with the true error of its
// picture.
//   scrim_coverage [--seeds 20] [--scenes 40]
#include "support/fields.h"

#include <scrim/scene/quality.h>
#include <scrim/verify/tolerance.h>

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::bench {
namespace {

// Unlike ones: smoke, edges of boxes and thin walls; thin and dense; light from all sides, in perspective or not.
ViewScene sceneAt(int index) {
    const std::vector<double> densities{0.05, 0.2, 0.6, 2.0};
    const std::vector<Vec3> directions{{1, -0.5, -0.6}, {-1, -1, 0.8}, {0.1, 0.2, 1}, {0, -1, 0}, {0.3, 0.1, -1}};
    Medium medium;
    medium.densityScale = densities[static_cast<std::size_t>(index % 4)];
    medium.albedo = Rgb(0.9, 0.8, 0.7);
    if (index % 3 == 1) medium.phase.g = 0.6;
    std::shared_ptr<SparseField> field;
    switch (index % 5) {
        case 0:
            field = test::smokeField(10);
            break;
        case 1:
            field = test::smokeField(14);
            break;
        case 2:
            field = test::boxField({-6, -4, -5}, {5, 7, 4});
            break;
        case 3:
            field = test::makeField(Int3(-10), Int3(10), 1, [](const Vec3& p) {
                return std::abs(p.x + 0.5 * p.y) < 1.5 || glm::length(p) < 4 ? 1.0 : 0.0;
            });
            break;
        default:
            field = test::makeField(Int3(-9), Int3(9), 1,
                                    [](const Vec3& p) { return std::exp(-glm::dot(p, p) / 30) - 0.05; });
    }
    ViewScene scene = test::orthographicScene(field, medium, 32, 56);
    scene.lights = {test::distantLight(directions[static_cast<std::size_t>(index / 8)], 3)};
    if (index % 2 == 1) scene.lights.push_back(test::distantLight({-0.3, -0.2, -1}, 1));
    if (index % 4 == 2) {
        scene.camera.type = CameraType::perspective;
        scene.camera.wsPosition = {9, 6, 40};
        scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, Vec3(0), {0, 1, 0});
        scene.camera.fov = 36;
    }
    return scene;
}

double trueError(PixelSample& all, const Image& image) {
    setRendered(all.pixels, image);
    const Verification v = summarise(all);
    return std::max(v.error, v.alphaError);
}

void report(int scenes, int seeds) {
    int runs = 0, bounded = 0, met = 0, metTruly = 0, again = 0;
    double wide = 0;
    for (int i = 0; i < scenes; ++i) {
        const ViewScene scene = sceneAt(i);
        // Every pixel of the region: what a picture shows beyond the boxes counts, too.
        PixelSample all = samplePixels(scene, emptyImage(scene.region), kAllPixels, 1);
        int failed = 0, metHere = 0;
        for (int seed = 0; seed < seeds; ++seed) {
            ToleranceOptions options;
            options.tolerance = i % 2 == 0 ? 0.02 : 0.007;
            options.seed = 1000u * static_cast<unsigned>(i) + 17u * static_cast<unsigned>(seed) + 1;
            const ToleranceResult result = renderWithin(scene, scene, options);
            const double error = trueError(all, result.frame.image);
            ++runs;
            bounded += error <= result.bound ? 1 : 0;
            failed += error <= result.bound ? 0 : 1;
            met += result.met ? 1 : 0;
            metHere += result.met ? 1 : 0;
            metTruly += result.met && error <= options.tolerance ? 1 : 0;
            again += result.attempts > 1 ? 1 : 0;
            wide += result.bound / error;
        }
        fmt::print(
            "scene {:>2}: {} pixels, tolerance {}: bound below the error in {} of {} runs, tolerance met in {}\n", i,
            all.pixels.size(), i % 2 == 0 ? 0.02 : 0.007, failed, seeds, metHere);
    }
    fmt::print("{} runs: true error below its bound in {:.1f} % (bound {:.2f} times the error on average)\n", runs,
               100.0 * bounded / runs, wide / runs);
    fmt::print("tolerance said to be met in {:.1f} %, {:.1f} % of them truly; more than one render in {:.1f} %\n",
               100.0 * met / runs, met > 0 ? 100.0 * metTruly / met : 0, 100.0 * again / runs);
}

}  // namespace
}  // namespace scrim::bench

int main(int argc, char** argv) {
    int scenes = 40, seeds = 20;
    for (int i = 1; i + 1 < argc; i += 2) {
        if (std::string(argv[i]) == "--seeds") seeds = std::stoi(argv[i + 1]);
        if (std::string(argv[i]) == "--scenes") scenes = std::stoi(argv[i + 1]);
    }
    scrim::bench::report(scenes, seeds);
}
