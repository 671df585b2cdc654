// SPDX-License-Identifier: Apache-2.0
// The decision who brings the light of a light to a volume before it has been scattered. Sub-lights, light on cells and
// the solve for scattered light take what they are handed here, so that each volume receives each light once.
#pragma once

#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

enum class Server {
    none,     ///< the light does not shine on the volume
    buffers,  ///< the shadow buffers of the light's sub-lights, in a sweep
    cells,    ///< light on cells (passes/light_cells.h)
    border    ///< the border of the cells on which scattered light is solved for (solve/scattered_light.h)
};

/// Who serves one light of the scene. The suns in the picture of a sky are not meant: they always
/// have sub-lights of their own, which shine on all volumes that the sky shines on.
struct ServedLight {
    std::vector<Server> volumes;  ///< for each of ViewScene::volumes
    /// The light is represented by sub-lights in sweeps, because buffers serve a volume.
    bool inSweeps = true;
};

/// For each light of the scene. `onCells`: indices of those that are kept on cells.
std::vector<ServedLight> servedLights(const ViewScene& scene, const std::vector<int>& onCells = {});

/// True if a light is a sky that comes in by the border of the cells on which scattered light is solved for, where it
/// shines on all that is there, and volumes hold it back. Other skies are many suns to that solve.
bool entersAtBorder(const ViewScene& scene, std::size_t light);
/// True if all volumes that have voxels receive a sky by the border.
bool comesByBorder(const ViewScene& scene, std::size_t light);

}  // namespace scrim
