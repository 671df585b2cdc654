// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/model/served_lights.h>

#include <algorithm>

namespace scrim {
namespace {

Server serverOf(const Light& light, std::size_t number, bool onCells, const ViewVolume& volume) {
    if (!litBy(volume.lights, number)) return Server::none;
    // A sky surrounds the cells of the solve. Neither sub-lights nor light on cells may bring it there again.
    if (light.dome() && scattersFully(volume)) return Server::border;
    return onCells ? Server::cells : Server::buffers;
}

}  // namespace

std::vector<ServedLight> servedLights(const ViewScene& scene, const std::vector<int>& onCells) {
    const bool border = skiesFromBorder(scene);
    std::vector<ServedLight> all;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        const bool cells = std::ranges::find(onCells, static_cast<int>(i)) != onCells.end();
        ServedLight& served = all.emplace_back();
        for (const ViewVolume& volume : scene.volumes) served.volumes.push_back(serverOf(light, i, cells, volume));
        served.inSweeps = !cells && !(light.dome() && border);
    }
    return all;
}

bool skiesFromBorder(const ViewScene& scene) {
    return std::ranges::any_of(scene.volumes, scattersFully) &&
           std::ranges::all_of(scene.volumes, [](const ViewVolume& v) { return v.field->empty() || scattersFully(v); });
}

}  // namespace scrim
