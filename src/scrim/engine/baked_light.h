// SPDX-License-Identifier: Apache-2.0
// Light at voxels instead of pixels, for other renderers: what the sweeps' shadow buffers say is read where voxels
// stand, and nothing is composited.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/scene/view_scene.h>

#include <bitset>
#include <vector>

namespace scrim {

/// Light at a volume's voxels of density above 0: blocks of 8^3, tiles cut into blocks, too. Values of a block are 512
/// reds, greens and blues in `blockOffset` order, 0 where a voxel is not active.
struct BakedVolume {
    std::vector<Int3> blockOrigins;
    std::vector<std::bitset<kBlockVoxels>> active;
    /// For each light of the scene irradiance times transmittance: what arrives there, whatever the phase function.
    /// Empty: it does not light the volume, or was not wanted. An extended light is the sum of its sub-lights.
    std::vector<std::vector<float>> lights;
    /// Radiance per world unit that the medium scatters of these lights and of ambient light, were its phase function
    /// isotropic; its octaves count. Empty where it was not wanted, or the volume is classified.
    std::vector<float> scattered;
};

struct BakeWants {
    std::vector<bool> lights;  ///< of the scene, each
    bool scattered = false;
};

/// One for each volume of `scene`, whose camera does not count. All of its volumes shadow. Throws Error: memory,
/// render, interrupted.
std::vector<BakedVolume> bakeLight(const ViewScene& scene, const BakeWants& wants, int threads,
                                   const ProgressSink& progress = {});

}  // namespace scrim
