// SPDX-License-Identifier: Apache-2.0
// What peers.py needs of the library: one scene that all tools render, the truth about it, and the dense ray marcher.
//
//     scrim_peers scene ASSET.vdb SCENE.toml PIXELS.csv COUNT   writes the scene and reference pixels; prints the
//                                                               scene's numbers as JSON, for tools that read no TOML
//     scrim_peers march SCENE.toml OUT.exr rays STEP SHADOW     renders with the dense marcher; prints the seconds that
//     scrim_peers march SCENE.toml OUT.exr volume STEP CELL RAY took, without loading and without making it dense
//     scrim_peers error PIXELS.csv PICTURE.exr...               prints error and its 95 % interval, a line a picture
#include "bench_scene.h"
#include "dense_marcher.h"

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/base/atomic_file.h>
#include <scrim/image/colour.h>
#include <scrim/image/exr.h>
#include <scrim/image/exr_read.h>
#include <scrim/shot/assemble.h>
#include <scrim/engine/sweep.h>
#include <scrim/scene/framing.h>
#include <scrim/scene/scene_reader.h>
#include <scrim/verify/verify.h>
#include <scrim/volume/vdb_file.h>

#include <chrono>
#include <filesystem>
#include <fstream>
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

void writeScene(const std::string& asset, const std::string& sceneFile, const std::string& pixelFile, int count) {
    const std::string path = std::filesystem::absolute(asset).string();
    writeWholeFile(sceneFile, sceneText(path, benchScene(path)));
    const ViewScene scene = load(sceneFile);  // as all others will read it
    const Image image = render(scene, makePlan(scene, threadCount())).image;
    std::string pixels;
    for (const VerifiedPixel& p : samplePixels(scene, image, count, kSeed).pixels)
        pixels += fmt::format("{} {} {} {} {} {}\n", p.x, p.y, p.reference[0], p.reference[1], p.reference[2],
                              p.reference[3]);
    writeWholeFile(pixelFile, pixels);
    fmt::print("{}", numbersAsJson(path, scene));
}

void march(const std::string& sceneFile, const std::string& picture, const std::string& how,
           const std::vector<double>& settings) {
    const ViewScene scene = load(sceneFile);
    const DenseMarcher dense(scene);
    const auto begin = std::chrono::steady_clock::now();
    const Image image = how == "rays"
                            ? dense.withShadowRays(settings.at(0), settings.at(1))
                            : dense.withLightVolume(settings.at(0), static_cast<int>(settings.at(1)), settings.at(2));
    fmt::print("{}\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    ExrOptions options;
    options.displayWindow = {0, 0, scene.camera.resolution.x, scene.camera.resolution.y};
    writeExr(picture, image, options);
}

void printErrors(const std::string& pixelFile, const std::vector<std::string>& pictures) {
    std::vector<VerifiedPixel> pixels;
    std::ifstream in(pixelFile);
    for (VerifiedPixel p; in >> p.x >> p.y >> p.reference[0] >> p.reference[1] >> p.reference[2] >> p.reference[3];)
        pixels.push_back(p);
    for (const std::string& picture : pictures) {
        const Image image = readExr(picture);
        for (VerifiedPixel& p : pixels)
            for (std::size_t c = 0; c < 4; ++c)
                p.rendered[c] = image.window.contains(p.x, p.y) ? image.rgba[image.indexOf(p.x, p.y) + c] : 0;
        const Verification v = summarise(pixels);
        fmt::print("{} {} {} {}\n", v.error, v.lower, v.upper, v.bias);
    }
}

int run(const std::vector<std::string>& a) {
    if (a.size() == 5 && a[0] == "scene")
        writeScene(a[1], a[2], a[3], std::stoi(a[4]));
    else if (a.size() >= 6 && a[0] == "march") {
        std::vector<double> settings;
        for (std::size_t i = 4; i < a.size(); ++i) settings.push_back(std::stod(a[i]));
        march(a[1], a[2], a[3], settings);
    } else if (a.size() >= 3 && a[0] == "error")
        printErrors(a[1], {a.begin() + 2, a.end()});
    else
        throw Error(ErrorKind::usage, "expected 'scene', 'march' or 'error' and what belongs to it, see peers.cpp");
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
