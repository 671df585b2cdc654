// SPDX-License-Identifier: Apache-2.0
// How far samples move across the picture until the next frame: by their volume's transform, by a velocity grid, and by
// the camera. It is separate from shading, which only carries the result, weighted by opacity.
#pragma once

#include <scrim/engine/model/eye_view.h>
#include <scrim/geometry/sheets.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <span>
#include <vector>

namespace scrim {

class ScreenMotion {
  public:
    ScreenMotion(const ViewScene& scene, const Sheets& sheets);
    ~ScreenMotion();

    /// A volume's contribution to the samples of a tile, 256 values each.
    struct Part {
        int sceneVolume;
        const Real* extinction;
        /// Values of VolumeMotion::flow at the samples; null: none.
        std::array<const Real*, 3> flow = {};
        /// Of balls: their velocities themselves; null: none.
        std::array<const Real*, 3> velocity = {};
    };
    /// Writes, for 256 samples on the plane N = `middle`, the mean motion of their volumes,
    /// weighted by extinction, in pixels per frame to the right and up. It is 0 where there is
    /// nothing, or where the sample is not in front of the camera.
    void fill(double middle, const SampleTile& samples, std::span<const Part> parts, Real* right, Real* up) const;

  private:
    struct Volume;
    Mat4 m_rasterFromTs;  // homogeneous: (x w, y w, 0, w)
    std::vector<Volume> m_volumes;
};

}  // namespace scrim
