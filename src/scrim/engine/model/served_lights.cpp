// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/model/served_lights.h>

#include <algorithm>

namespace scrim {
namespace {

Server serverOf(std::size_t number, bool enters, bool onCells, const ViewVolume& volume) {
    if (!litBy(volume.lights, number)) return Server::none;
    // A sky surrounds the cells of the solve. Neither sub-lights nor light on cells may bring it there again.
    if (enters && scattersFully(volume)) return Server::border;
    return onCells ? Server::cells : Server::buffers;
}

}  // namespace

std::vector<ServedLight> servedLights(const ViewScene& scene, const std::vector<int>& onCells) {
    std::vector<ServedLight> all;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const bool enters = entersAtBorder(scene, i);
        const bool cells = std::ranges::find(onCells, static_cast<int>(i)) != onCells.end();
        ServedLight& served = all.emplace_back();
        for (const ViewVolume& volume : scene.volumes) served.volumes.push_back(serverOf(i, enters, cells, volume));
        served.inSweeps = !cells && !comesByBorder(scene, i);
    }
    return all;
}

bool entersAtBorder(const ViewScene& scene, std::size_t light) {
    return scene.lights[light].dome() && scene.lights[light].shadows &&
           std::ranges::all_of(scene.volumes,
                               [&](const ViewVolume& v) { return v.field->empty() || litBy(v.lights, light); });
}

bool comesByBorder(const ViewScene& scene, std::size_t light) {
    return entersAtBorder(scene, light) && std::ranges::any_of(scene.volumes, scattersFully) &&
           std::ranges::all_of(scene.volumes, [](const ViewVolume& v) { return v.field->empty() || scattersFully(v); });
}

}  // namespace scrim
