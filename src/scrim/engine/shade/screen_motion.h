// SPDX-License-Identifier: Apache-2.0
// How far what samples show moves across the picture until the next frame: by its volume's transform, by a velocity
// grid, and by the camera. Apart from shading, which only carries the result, weighted by opacity.
#pragma once

#include <scrim/engine/model/samples.h>
#include <scrim/geometry/sheets.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <span>
#include <vector>

namespace scrim {

class ScreenMotion {
  public:
    ScreenMotion(const ViewScene& scene, const Sheets& sheets);

    /// A volume's part in the samples of a tile, 256 values each.
    struct Part {
        int sceneVolume;
        const Real* extinction;
        /// VolumeMotion::flow where the samples are; null: there is none.
        std::array<const Real*, 3> flow = {};
    };
    /// Writes for 256 samples of the plane N = `middle` the mean over their volumes, by extinction, in pixels a frame:
    /// to the right, and up. 0 where nothing is, or it is not before the camera.
    void fill(double middle, const SampleTile& samples, std::span<const Part> parts, Real* right, Real* up) const;

  private:
    struct Volume {
        Mat4 rasterFromTs;    // at the next frame
        Mat4 rasterFromFlow;  // for each unit of velocity more
        Vec3 least, most;
    };
    Mat4 m_rasterFromTs;  // homogeneous: (x w, y w, 0, w)
    std::vector<Volume> m_volumes;
};

}  // namespace scrim
