// SPDX-License-Identifier: Apache-2.0
// What peers.py needs of the library: one scene that all tools render, the truth about it, and the dense ray marcher.
//
//     scrim_peers scene ASSET.vdb SCENE.toml PIXELS.csv COUNT   writes the scene and reference pixels; prints the
//                                                               scene's numbers as JSON, for tools that read no TOML
//     scrim_peers pixels SCENE.toml PIXELS.csv COUNT [SECONDS]  writes reference pixels of any scene
//     scrim_peers march SCENE.toml OUT.exr rays STEP SHADOW     renders with the dense marcher; prints the seconds that
//     scrim_peers march SCENE.toml OUT.exr volume STEP CELL RAY took, without loading and without making it dense;
//     scrim_peers march SCENE.toml OUT.exr sweep STEP CELL 1|3  the median of SCRIM_REPEATS (1) renderings
//     scrim_peers pilot SCENE.toml RAYS                         prints what presets are chosen by, and its seconds
//     scrim_peers scattering SCENE.toml                         prints what cells and directions of multiply scattered
//                                                               light are chosen by (ScatterPilot), and its seconds
//     scrim_peers error PIXELS.csv PICTURE.exr...               prints error and its 95 % interval, a line a picture
//     scrim_peers grain PICTURE.exr TRUTH.exr EDGE              prints the RMS of what is left of the difference when
//                                                               its mean over EDGE x EDGE pixels is taken away, over
//                                                               the mean of TRUTH: within the data window of TRUTH
#include "bench_scene.h"
#include "dense_marcher.h"
#include "sweep_marcher.h"

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/base/atomic_file.h>
#include <scrim/image/colour.h>
#include <scrim/image/exr.h>
#include <scrim/image/exr_read.h>
#include <scrim/shot/assemble.h>
#include <scrim/shot/load_shot.h>
#include <scrim/engine/sweep.h>
#include <scrim/scene/framing.h>
#include <scrim/scene/scene_reader.h>
#include <scrim/verify/pilot_rays.h>
#include <scrim/verify/scatter_pilot.h>
#include <scrim/verify/verify.h>
#include <scrim/volume/vdb_file.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scrim::bench {
namespace {

constexpr unsigned kSeed = 1;  // any, but always the same pixels

/// The scene in `file`, whose one volume is a .vdb.
ViewScene load(const std::string& file) {
    const ColourConfig colour = ColourConfig::open("");
    const Scene scene = readScene(loadSceneText(file), 1, {}, colour);
    const SceneVolume& volume = scene.volumes.front();
    return assemble(scene,
                    {{std::make_shared<SparseField>(VdbFile::open(volume.file).field(volume.densityGrid, {})), {}, {}}},
                    {}, 0);
}

/// The camera, density and key light of the first picture that `scrim render ASSET` gives, in grey, without its fill
/// and ambient light, and with isotropic scattering: what all the tools can render.
std::string sceneText(const std::string& asset, const ViewScene& framed) {
    const Camera& camera = framed.camera;
    const Vec3 eye = camera.wsPosition, target = eye + viewingAxis(camera) * glm::length(eye);
    const Light& light = framed.lights.front();
    const Rgb& albedo = framed.volumes.front().medium.albedo;
    return fmt::format(
        "[camera]\nposition = [{}, {}, {}]\ntarget = [{}, {}, {}]\nfov = {}\nresolution = [{}, {}]\n"
        "[[volume]]\nfile = \"{}\"\ndensity = {{ scale = {} }}\n"
        "[volume.medium]\nalbedo = [{a}, {a}, {a}]\n"
        "[[light]]\nname = \"key\"\ntype = \"distant\"\ndirection = [{}, {}, {}]\nintensity = {}\n",
        eye.x, eye.y, eye.z, target.x, target.y, target.z, camera.fov, camera.resolution.x, camera.resolution.y, asset,
        framed.volumes.front().medium.densityScale, light.wsDirection.x, light.wsDirection.y, light.wsDirection.z,
        light.intensity.x, fmt::arg("a", albedo.x));
}

std::string numbersAsJson(const std::string& asset, const ViewScene& scene) {
    const Camera& camera = scene.camera;
    const Vec3 &eye = camera.wsPosition, look = viewingAxis(camera), light = scene.lights.front().wsDirection;
    const ViewVolume& volume = scene.volumes.front();
    return fmt::format(
        "{{\"asset\": \"{}\", \"grid\": \"{}\", \"voxels\": {},\n \"eye\": [{}, {}, {}], \"look\": [{}, {}, {}], "
        "\"fov\": {}, \"resolution\": [{}, {}],\n \"scale\": {}, \"albedo\": {}, \"voxel\": {},\n \"light\": [{}, {}, "
        "{}], "
        "\"irradiance\": {}}}\n",
        asset, volume.field->name, volume.field->activeVoxels, eye.x, eye.y, eye.z, look.x, look.y, look.z, camera.fov,
        camera.resolution.x, camera.resolution.y, volume.medium.densityScale, volume.medium.albedo.x, voxelUnit(scene),
        light.x, light.y, light.z, scene.lights.front().intensity.x);
}

/// Any scene, with all its volumes.
ViewScene loadAny(const std::string& file) {
    ShotStores stores(ColourConfig::open(""));
    Scene scene = readScene(loadSceneText(file), 1, {}, stores.colour);
    const RenderOptions options;
    return loadShot(stores, {}, std::move(scene), options, VolumesOf::scene, ShotUse::plan)
        ->view(options, 0, VolumesOf::scene);
}

void writePixels(const std::string& sceneFile, const std::string& pixelFile, int count, double seconds = 0) {
    const ViewScene scene = loadAny(sceneFile);
    const Image image = render(scene, makePlan(scene, threadCount())).image;
    SampleOptions sampling;
    sampling.count = count;
    sampling.seed = kSeed;
    sampling.seconds = seconds;
    std::string pixels;
    for (const VerifiedPixel& p : samplePixels(scene, image, sampling).pixels)
        pixels += fmt::format("{} {} {} {} {} {} {} {} {} {}\n", p.x, p.y, p.reference[0], p.reference[1],
                              p.reference[2], p.reference[3], p.variance[0], p.variance[1], p.variance[2], p.edge);
    writeWholeFile(pixelFile, pixels);
}

void printPilot(const std::string& sceneFile, int rays) {
    const ViewScene scene = loadAny(sceneFile);
    const auto begin = std::chrono::steady_clock::now();
    const double error = pilotError(scene, rays);
    fmt::print("{} {}\n", error, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
}

void writeScene(const std::string& asset, const std::string& sceneFile, const std::string& pixelFile, int count) {
    const std::string path = std::filesystem::absolute(asset).string();
    writeWholeFile(sceneFile, sceneText(path, benchScene(path)));
    writePixels(sceneFile, pixelFile, count);
    fmt::print("{}", numbersAsJson(path, load(sceneFile)));  // as all others will read it
}

/// Renders, and prints the median of the seconds.
template <class Render>
Image timed(const Render& render) {
    const char* text = std::getenv("SCRIM_REPEATS");
    std::vector<double> seconds;
    Image image;
    for (int repeats = text != nullptr ? std::max(1, std::atoi(text)) : 1; repeats > 0; --repeats) {
        const auto begin = std::chrono::steady_clock::now();
        image = render();
        seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
    std::sort(seconds.begin(), seconds.end());
    fmt::print("{}\n", seconds[seconds.size() / 2]);
    return image;
}

void march(const std::string& sceneFile, const std::string& picture, const std::string& how,
           const std::vector<double>& settings) {
    const ViewScene scene = load(sceneFile);
    Image image;
    if (how == "sweep") {
        const SweepMarcher marcher(scene);
        image =
            timed([&] { return marcher.render(settings.at(0), static_cast<int>(settings.at(1)), settings.at(2) > 1); });
    } else {
        const DenseMarcher marcher(scene);
        image = timed([&] {
            return how == "rays"
                       ? marcher.withShadowRays(settings.at(0), settings.at(1))
                       : marcher.withLightVolume(settings.at(0), static_cast<int>(settings.at(1)), settings.at(2));
        });
    }
    ExrOptions options;
    options.displayWindow = {0, 0, scene.camera.resolution.x, scene.camera.resolution.y};
    writeExr(picture, image, options);
}

void printErrors(const std::string& pixelFile, const std::vector<std::string>& pictures) {
    std::vector<VerifiedPixel> pixels;
    std::ifstream in(pixelFile);
    for (VerifiedPixel p; in >> p.x >> p.y >> p.reference[0] >> p.reference[1] >> p.reference[2] >> p.reference[3] >>
                          p.variance[0] >> p.variance[1] >> p.variance[2] >> p.edge;)
        pixels.push_back(p);
    for (const std::string& picture : pictures) {
        setRendered(pixels, readExr(picture));
        const Verification v = summarise(pixels);
        fmt::print("{} {} {} {}\n", v.error, v.lower, v.upper, v.bias);
    }
}

void printScattering(const std::string& sceneFile) {
    const ViewScene scene = loadAny(sceneFile);
    const auto begin = std::chrono::steady_clock::now();
    const std::optional<ScatterPilot> pilot = scatterPilot(scene);
    if (!pilot) return fmt::print("light scatters once\n");
    fmt::print("{} {} {} {} {} {} {}\n", pilot->edge, pilot->difference, pilot->share, pilot->straight[0],
               pilot->straight[1], pilot->straight[2],
               std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
}

/// High-pass RMS of the difference of two pictures, see above.
void printGrain(const std::string& pictureFile, const std::string& truthFile, int edge) {
    const Image picture = readExr(pictureFile), truth = readExr(truthFile);
    const PixelWindow& w = truth.window;
    const auto difference = [&](int x, int y, std::size_t c) {
        const double shown = picture.window.contains(x, y) ? picture.rgba[picture.indexOf(x, y) + c] : 0;
        return shown - truth.rgba[truth.indexOf(x, y) + c];
    };
    double squares = 0, sum = 0, count = 0;
    const int reach = edge / 2;
    for (int y = w.y0 + reach; y < w.y1 - reach; ++y)
        for (int x = w.x0 + reach; x < w.x1 - reach; ++x)
            for (std::size_t c = 0; c < 3; ++c) {
                double mean = 0;
                for (int j = -reach; j <= reach; ++j)
                    for (int i = -reach; i <= reach; ++i) mean += difference(x + i, y + j, c);
                const double rest = difference(x, y, c) - mean / ((2 * reach + 1) * (2 * reach + 1));
                squares += rest * rest;
                sum += truth.rgba[truth.indexOf(x, y) + c];
                count += 1;
            }
    fmt::print("{}\n", sum > 0 ? std::sqrt(squares / count) / (sum / count) : 0);
}

int run(const std::vector<std::string>& a) {
    if (a.size() == 5 && a[0] == "scene")
        writeScene(a[1], a[2], a[3], std::stoi(a[4]));
    else if ((a.size() == 4 || a.size() == 5) && a[0] == "pixels")
        writePixels(a[1], a[2], std::stoi(a[3]), a.size() == 5 ? std::stod(a[4]) : 0);
    else if (a.size() == 3 && a[0] == "pilot")
        printPilot(a[1], std::stoi(a[2]));
    else if (a.size() == 2 && a[0] == "scattering")
        printScattering(a[1]);
    else if (a.size() == 4 && a[0] == "grain")
        printGrain(a[1], a[2], std::stoi(a[3]));
    else if (a.size() >= 6 && a[0] == "march") {
        std::vector<double> settings;
        for (std::size_t i = 4; i < a.size(); ++i) settings.push_back(std::stod(a[i]));
        march(a[1], a[2], a[3], settings);
    } else if (a.size() >= 3 && a[0] == "error")
        printErrors(a[1], {a.begin() + 2, a.end()});
    else
        throw Error(ErrorKind::usage,
                    "expected 'scene', 'pixels', 'march', 'error', 'pilot', 'scattering' or 'grain' and what belongs "
                    "to it, see peers.cpp");
    return 0;
}

}  // namespace
}  // namespace scrim::bench

int main(int argc, char** argv) try {
    return scrim::bench::run({argv + 1, argv + argc});
} catch (const std::exception& error) {
    fmt::print(stderr, "scrim_peers: {}\n", error.what());
    return 1;
}
