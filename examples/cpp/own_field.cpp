// SPDX-License-Identifier: Apache-2.0
// Renders a field that is made in code, with a layer for each light:  own_field OUT.exr
#include <scrim/scrim.h>

#include <algorithm>
#include <iostream>
#include <vector>

#include <glm/geometric.hpp>

// A soft ball around the origin, 15 units in radius, in voxels of one unit.
scrim::SparseField ball() {
    constexpr int kEdge = scrim::kBlockEdge;
    scrim::FieldBuilder builder("density", scrim::Mat4(1.0));
    std::vector<float> values(scrim::kBlockVoxels);
    for (int block = 0; block < 64; ++block) {
        const scrim::Int3 origin = scrim::Int3(block / 16, block / 4 % 4, block % 4) * kEdge - 2 * kEdge;
        for (int i = 0; i < scrim::kBlockVoxels; ++i) {
            const scrim::Int3 voxel = origin + scrim::Int3(i / (kEdge * kEdge), i / kEdge % kEdge, i % kEdge);
            values[i] = static_cast<float>(std::max(0.0, 1 - glm::length(scrim::Vec3(voxel)) / 15));
        }
        builder.addBlock(origin, values.data());
    }
    return builder.finish();
}

scrim::Light distantLight(const std::string& name, const scrim::Vec3& direction, double intensity) {
    scrim::Light light;
    light.name = name;
    light.wsDirection = glm::normalize(direction);
    light.intensity = scrim::Rgb(intensity);
    return light;
}

int main(int argc, char** argv) try {
    if (argc != 2) throw scrim::Error(scrim::ErrorKind::usage, "usage: own_field OUT.exr");
    scrim::Scene scene;
    scene.camera.wsPosition = {0, 0, 60};  // looks along -z
    scene.camera.resolution = {256, 256};
    scene.volumes.resize(1);
    scene.volumes[0].name = "ball";
    scene.volumes[0].densityScale = 0.3;
    scene.lights = {distantLight("key", {1, -1, -1}, 4), distantLight("rim", {-1, 0.5, 1}, 6)};
    scene.output.layers = {scrim::Layer::light};
    auto shot = scrim::Shot::make(scene);
    shot.setVolume("ball", {ball()});
    auto frame = shot.render(1);
    for (const std::string& name : frame.layerNames()) {
        const std::vector<float>& data = frame.layer(name).data;
        std::cout << name << ": brightest " << *std::max_element(data.begin(), data.end()) << "\n";
    }
    frame.write(argv[1]);
} catch (const scrim::Error& error) {
    std::cerr << error.what() << "\n";
    return 1;
}
