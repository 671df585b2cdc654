// SPDX-License-Identifier: Apache-2.0
// Estimates the detail that a raster of texels loses: a few rays are marched coarsely through the
// field as it is and through the field as texels reconstruct it.
#pragma once

#include <scrim/scene/view_scene.h>

#include <memory>

namespace scrim {

/// Ray `i` of a pilot: its place in the unit square of the picture, and a number in [0, 1) that
/// shifts its steps. An additive recurrence spreads the rays evenly and is the same in every run.
Vec3 pilotPlace(int i);

inline constexpr int kMostPilotRays = 384;

/// A rough relative RMSE that texels of one voxel, of each volume its own, leave along `rays` rays over the whole
/// picture, or up to `mostRays` where these disagree. It serves to compare scenes. 0 where nothing is visible.
double pilotError(const ViewScene& scene, int rays, int mostRays = kMostPilotRays);

struct PilotRadiance;

/// What coarser fields leave in the picture of a scene.
class CoarserPilot {
  public:
    /// Marches `rays` rays through `scene`, which must outlive this object.
    CoarserPilot(const ViewScene& scene, int rays);
    ~CoarserPilot();
    /// The relative RMSE along these rays of `coarser`, the same scene with coarser fields: one
    /// standard deviation above what they find.
    double error(const ViewScene& coarser) const;

  private:
    std::unique_ptr<const PilotRadiance> m_rays;
};

/// What rays over the whole picture see, of its three brightest lights.
struct PilotSight {
    double radiance = 0;    ///< its sum over the rays
    double contrast = 1;    ///< RMS over mean of the radiance of those that see something; 1: there is no light
    double thickness = 0;   ///< the mean optical depth of a voxel where that light comes from; 0: there is none
    double depthAtEye = 0;  ///< the mean optical depth of three voxels, the scene's finest, where rays begin; 0: the
                            ///< eye is in front of all volumes
};
PilotSight pilotSight(const ViewScene& scene, int rays);

}  // namespace scrim
