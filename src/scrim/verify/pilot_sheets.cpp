// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/pilot_sheets.h>

#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/plan/flat_voxels.h>
#include <scrim/volume/coarser.h>

#include <algorithm>

#include <glm/geometric.hpp>

namespace scrim {

double shortestEdge(const ViewVolume& volume) {
    return smallest(voxelEdges(volume.wsFromIs));
}

double flatness(const ViewVolume& volume) {
    return largest(voxelEdges(volume.wsFromIs)) / shortestEdge(volume);
}

bool anyFlat(const ViewScene& scene) {
    constexpr double kFlat = 2;
    return std::ranges::any_of(scene.volumes, [](const ViewVolume& volume) { return flatness(volume) > kFlat; });
}

PilotSheets pilotSheets(const ViewScene& scene, const std::vector<PilotLight>& lights, const Vec3& wsCenter) {
    const Vec3 eye = viewingAxis(scene.camera);
    std::vector<Vec3> ways;
    if (!lights.empty()) ways.push_back(-toLight(*lights.front().light, wsCenter));
    Vec3 axis = eye;
    if (!ways.empty()) axis = glm::dot(ways.front(), eye) >= 0 ? eye + ways.front() : eye - ways.front();
    if (anyFlat(scene))
        if (const auto flat = FlatVoxels(scene).sheets({eye}, ways)) return {flat->wsAxis, flat->across};
    return {glm::normalize(axis), 1};
}

bool sheetsAlongFlatVoxels(const ViewScene& scene) {
    if (!anyFlat(scene)) return false;
    const ViewScene few = withFewSubLights(scene, static_cast<int>(kMostPilotLights));
    return pilotSheets(few, brightestLights(few), wsBounds(scene).center()).across > 1;
}

}  // namespace scrim
