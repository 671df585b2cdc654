// SPDX-License-Identifier: Apache-2.0
// Light at voxels instead of pixels, for other renderers: the sweeps' shadow buffers are looked up
// at the voxels, and nothing is composited.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <bitset>
#include <vector>

namespace scrim {

/// Light at a volume's voxels with density above 0, in blocks of 8^3; tiles are divided into blocks. Each block has 512
/// values of red, green and blue in `blockOffset` order, 0 where a voxel is not active.
struct BakedVolume {
    std::vector<Int3> blockOrigins;
    std::vector<std::bitset<kBlockVoxels>> active;
    /// For each light of the scene, irradiance times transmittance at the voxels, independent of
    /// the phase function. Empty if the light does not light the volume or was not requested. For
    /// an extended light, the sum over its sub-lights.
    std::vector<std::vector<float>> lights;
    /// Radiance per world unit that the medium scatters from these lights and from ambient light,
    /// with its octaves or any number of times, but as if its phase function were isotropic for the
    /// eye. Empty if not requested or if the volume is classified.
    std::vector<float> scattered;
    /// The mean, over all directions, of the radiance of light that has scattered before, and for
    /// each colour the mean of that radiance times its direction of travel (x, y and z in world
    /// space). Empty if not requested or if the volume does not scatter light more than once.
    std::vector<float> indirect;
    std::array<std::vector<float>, 3> flux;
    /// The estimated error of the iteration for light that has scattered before, where that is more
    /// than the dial asks for; else 0.
    double iterationError = 0;
};

/// Bakes each volume of `scene`; the camera is ignored. All volumes cast shadows. `wanted`: for
/// each light of the scene, whether its own light is kept; `scattered` and `indirect`: whether
/// these are. Throws Error: memory, render, interrupted.
std::vector<BakedVolume> bakeLight(const ViewScene& scene, const std::vector<bool>& wanted, bool scattered,
                                   bool indirect, int threads, const ProgressSink& progress = {});

}  // namespace scrim
