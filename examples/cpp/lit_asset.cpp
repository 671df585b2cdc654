// SPDX-License-Identifier: Apache-2.0
// Renders a volume under two lights that are set by hand:  lit_asset ASSET.vdb OUT.exr
#include <scrim/scrim.h>

#include <iostream>

#include <glm/geometric.hpp>

scrim::Light distantLight(const std::string& name, const scrim::Vec3& direction, const scrim::Rgb& intensity) {
    scrim::Light light;
    light.name = name;
    light.wsDirection = glm::normalize(direction);
    light.intensity = intensity;
    return light;
}

int main(int argc, char** argv) try {
    if (argc != 3) throw scrim::Error(scrim::ErrorKind::usage, "usage: lit_asset ASSET.vdb OUT.exr");
    auto shot = scrim::Shot::open(argv[1]);  // it is framed and lit
    scrim::Scene scene = shot.scene(1);
    scene.lights = {distantLight("key", {1, -1, -0.5}, {5, 4.2, 3}), distantLight("rim", {-1, 0.2, 0.8}, {1, 2, 4})};
    shot.render(scene).write(argv[2]);
} catch (const scrim::Error& error) {
    std::cerr << error.what() << "\n";
    return 1;
}
