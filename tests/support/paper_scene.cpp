// SPDX-License-Identifier: Apache-2.0
#include "support/paper_scene.h"

#include "support/data.h"
#include "support/run_program.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <scrim/image/exr_read.h>
#include <scrim/scene/scene_reader.h>

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <glm/vec4.hpp>

namespace scrim::test {
namespace {

std::string pathOf(const std::string& name) {
    return std::string(SCRIM_SOURCE_DIR) + "/examples/paper/" + name + ".toml";
}

Settings smallPicture() {
    return {fmt::format("camera.resolution=[{0}, {0}]", kPaperResolution), "output.type=float"};
}

}  // namespace

Settings operator+(Settings settings, const Settings& more) {
    settings.insert(settings.end(), more.begin(), more.end());
    return settings;
}

Scene paperScene(const std::string& name, const Settings& settings) {
    ::setenv("SCRIM_DATA", dataFolder().c_str(), 1);
    return readScene(loadSceneText(pathOf(name)), 1, smallPicture() + settings, ColourConfig::open(""));
}

PaperPicture renderPaper(const std::string& name, const Settings& settings, int verify) {
    const TempFolder folder;
    std::vector<std::string> arguments{"render", pathOf(name), "-o", "picture.exr", "--stats", "stats.json", "-q"};
    for (const std::string& setting : smallPicture() + settings) arguments.insert(arguments.end(), {"--set", setting});
    if (verify > 0) arguments.insert(arguments.end(), {"--verify", std::to_string(verify)});

    ProgramOptions options;
    options.environment = {{"SCRIM_DATA", std::filesystem::absolute(dataFolder()).string()}};
    const ProgramResult result = runProgram(folder.path(), arguments, options);
    EXPECT_EQ(result.status, 0) << name << ": " << result.err;

    PaperPicture picture;
    const Scene scene = paperScene(name, settings);
    picture.camera = scene.camera;
    const PixelWindow window{0, 0, scene.camera.resolution.x, scene.camera.resolution.y};
    picture.image = result.status == 0 ? reframed(readExr(folder.file("picture.exr")), window) : emptyImage(window);
    if (result.status == 0) picture.stats = nlohmann::json::parse(readBytes(folder.file("stats.json"))).at(0);
    return picture;
}

Rgb PaperPicture::colour(int x, int y) const {
    if (!image.window.contains(x, y)) {
        ADD_FAILURE() << "pixel " << x << "," << y << " is not in the picture";
        return Rgb(0);
    }
    const float* p = image.rgba.data() + image.indexOf(x, y);
    return {p[0], p[1], p[2]};
}

double PaperPicture::brightness(int x, int y) const {
    const Rgb c = colour(x, y);
    return (c.x + c.y + c.z) / 3;
}

double PaperPicture::alpha(int x, int y) const {
    return image.rgba[image.indexOf(x, y) + 3];
}

Int2 PaperPicture::pixelOf(const Vec3& ws) const {
    const glm::dvec4 h = worldToNdc(camera) * glm::dvec4(ws, 1);
    return {static_cast<int>(std::floor((0.5 + 0.5 * h.x / h.w) * camera.resolution.x)),
            static_cast<int>(std::floor((0.5 - 0.5 * h.y / h.w) * camera.resolution.y))};
}

double PaperPicture::brightnessAt(const Vec3& ws) const {
    const Int2 p = pixelOf(ws);
    return brightness(p.x, p.y);
}

Rgb PaperPicture::colourAt(const Vec3& ws) const {
    const Int2 p = pixelOf(ws);
    return colour(p.x, p.y);
}

int PaperPicture::count(const std::function<bool(int x, int y)>& claim) const {
    int pixels = 0;
    for (int y = image.window.y0; y < image.window.y1; ++y)
        for (int x = image.window.x0; x < image.window.x1; ++x) pixels += claim(x, y);
    return pixels;
}

double PaperPicture::meanBrightness() const {
    double sum = 0;
    count([&](int x, int y) {
        sum += brightness(x, y);
        return true;
    });
    return sum / static_cast<double>(image.window.pixelCount());
}

}  // namespace scrim::test
