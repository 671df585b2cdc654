// SPDX-License-Identifier: Apache-2.0
// Renders a field that is made in code, with a layer for each light:  own_field OUT.exr
#include <scrim/scrim.h>

#include <algorithm>
#include <iostream>

#include <glm/geometric.hpp>

// A soft ball around the origin, 15 units in radius, in voxels of one unit.
scrim::SparseField ball() {
    scrim::FieldBuilder builder("density", scrim::Mat4(1.0));
    for (int block = 0; block < 64; ++block) {
        const scrim::Int3 origin = scrim::Int3(block / 16, block / 4 % 4, block % 4) * 8 - 16;
        float values[scrim::kBlockVoxels];
        for (int i = 0; i < scrim::kBlockVoxels; ++i) {
            const scrim::Vec3 voxel(origin + scrim::Int3(i / 64, i / 8 % 8, i % 8));
            values[i] = static_cast<float>(std::max(0.0, 1 - glm::length(voxel) / 15));
        }
        builder.addBlock(origin, values);
    }
    return builder.finish();
}

int main(int argc, char** argv) try {
    if (argc != 2) throw scrim::Error(scrim::ErrorKind::usage, "usage: own_field OUT.exr");
    scrim::Scene scene;
    scene.camera.wsPosition = {0, 0, 60};  // looks along -z
    scene.volumes.resize(1);
    scene.volumes[0].name = "ball";
    scene.volumes[0].densityScale = 0.3;
    scene.lights.resize(2);
    scene.lights[0].name = "key";
    scene.lights[0].wsDirection = glm::normalize(scrim::Vec3(1, -1, -1));
    scene.lights[1].name = "rim";
    scene.lights[1].wsDirection = glm::normalize(scrim::Vec3(-1, 0.5, 1));
    scene.output.layers = {scrim::Layer::light};
    auto shot = scrim::Shot::make(scene);
    shot.setVolume("ball", {ball()});
    auto frame = shot.render(1);
    const auto& key = frame.layer("light.key").data;
    std::cout << "brightest of light.key: " << *std::max_element(key.begin(), key.end()) << "\n";
    frame.write(argv[1]);
} catch (const scrim::Error& error) {
    std::cerr << error.what() << "\n";
    return 1;
}
