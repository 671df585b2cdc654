// SPDX-License-Identifier: Apache-2.0
// The noise of a scene (scene.h) at the voxels of blocks.
#pragma once

#include <scrim/scene/scene.h>

#include <cstdint>
#include <vector>

namespace scrim {

/// Internal: gradient noises of two seeds, which are added with weights.
struct NoiseOctave {
    double frequency;
    std::uint32_t seeds[2];
    double weights[2];
};

/// The pattern at the voxels of blocks, about -1 to 1; its `amount` does not matter.
class NoiseBlocks {
  public:
    /// `placeFromIs` maps voxels to places. `part`: 0, 1 and 2 are independent patterns.
    NoiseBlocks(const Noise& noise, const Mat4& placeFromIs, std::uint32_t part = 0);
    /// Writes the values of the block at `origin` in `blockOffset` order: the same bits on every
    /// instruction set. May be called from several threads.
    void fill(const Int3& origin, float* values) const;

  private:
    Vec3 m_first;
    Mat3 m_steps;
    std::vector<NoiseOctave> m_octaves;
};

}  // namespace scrim
