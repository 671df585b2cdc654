// SPDX-License-Identifier: Apache-2.0
#include "bench_scene.h"

#include <scrim/image/colour.h>
#include <scrim/shot/assemble.h>
#include <scrim/scene/framing.h>
#include <scrim/scene/scene_reader.h>
#include <scrim/volume/source.h>
#include <scrim/volume/vdb_file.h>

#include <filesystem>

#include <glm/geometric.hpp>

namespace scrim::bench {

ViewScene benchScene(const std::string& asset, Int2 resolution) {
    std::shared_ptr<const SparseField> field;
    if (asset.rfind("noise:", 0) == 0)
        field = std::make_shared<SparseField>(generate("noise", {{"resolution", asset.substr(6)}}, {}).front());
    else
        field = std::make_shared<SparseField>(VdbFile::open(asset).field("", {}));
    const ColourConfig colour = ColourConfig::open("");
    const SceneText text{"bench", "",
                         framingScene({.file = "asset.vdb", .grid = field->name, .field = field.get()}, resolution)};
    ViewScene scene = assemble(readScene(text, 1, {}, colour), {{field, {}, {}}}, {}, 0);
    scene.lights.resize(1);
    scene.lights[0].intensity = Rgb(10);
    scene.ambient = Rgb(0);
    scene.volumes[0].medium.phase.g = 0;
    return scene;
}

std::string assetLabel(const std::string& asset) {
    return asset.rfind("noise:", 0) == 0 ? asset : std::filesystem::path(asset).filename().string();
}

void addLights(ViewScene& scene, int count) {
    while (static_cast<int>(scene.lights.size()) < count) {
        Light light = scene.lights.front();
        light.name += std::to_string(scene.lights.size());
        const double turn = 0.05 * static_cast<double>(scene.lights.size());
        light.wsDirection = glm::normalize(light.wsDirection + turn * Vec3(0.3, 0.1, -0.3));
        scene.lights.push_back(light);
    }
}

}  // namespace scrim::bench
