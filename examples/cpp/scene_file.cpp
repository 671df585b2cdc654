// SPDX-License-Identifier: Apache-2.0
// Renders a scene file:  scene_file SCENE.toml OUT.exr [KEY=VALUE...]
#include <scrim/scrim.h>

#include <iostream>

int main(int argc, char** argv) try {
    if (argc < 3) throw scrim::Error(scrim::ErrorKind::usage, "usage: scene_file SCENE.toml OUT.exr [KEY=VALUE...]");
    auto shot = scrim::Shot::open(argv[1], {argv + 3, argv + argc});
    auto frame = shot.render(1);
    frame.write(argv[2]);
} catch (const scrim::Error& error) {
    std::cerr << error.what() << "\n";
    return 1;
}
