// SPDX-License-Identifier: Apache-2.0
// The peers to beat: ray marchers over a dense copy of the grid, as most renderers in use work. Tuned in earnest:
// empty 8^3 blocks are skipped, rays stop when opaque, steps are integrated in closed form, and light is precomputed
// only where a sample can ask for it. One distant light, one medium.
#pragma once

#include <scrim/image/image.h>
#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim::bench {

class DenseMarcher {
  public:
    /// Copies the first volume of `scene` (a uniform, unrotated grid) into a dense array. `scene` must outlive this.
    explicit DenseMarcher(const ViewScene& scene);

    /// A shadow ray from every sample. Steps in voxels.
    Image withShadowRays(double step, double shadowStep) const;

    /// Light precomputed at `coarseness` voxels a cell (1 or more) with rays of `shadowStep` voxels, then looked up.
    Image withLightVolume(double step, int coarseness, double shadowStep) const;

    std::size_t bytes() const { return m_values.size() * sizeof(float); }

  private:
    struct Ray;
    struct LightVolume;
    template <class TauIn>
    Image march(double step, const TauIn& tauIn) const;
    float value(float x, float y, float z) const;
    bool occupied(float x, float y, float z) const;
    float shadowTau(float x, float y, float z, float step) const;
    bool occupiedAround(const float* position) const;
    LightVolume fillLight(int coarseness, float shadowStep) const;
    static float exitOfBlock(const float* position, const float* direction);

    const ViewScene& m_scene;
    int m_size[3];                // voxels, two of margin on each side
    Vec3 m_isOrigin;              // index-space position of voxel (0, 0, 0) of the array
    std::vector<float> m_values;  // extinction a voxel
    int m_blocks[3];
    std::vector<unsigned char> m_occupied;  // 8^3 blocks in which a sample can be above 0
    float m_toLight[3];                     // unit, index space
};

}  // namespace scrim::bench
