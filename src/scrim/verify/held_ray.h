// SPDX-License-Identifier: Apache-2.0
// What a depth or deep picture leaves of what one ray shows, point by point: for the reference, which integrates
// numerically what the engine has in closed form.
#pragma once

#include <scrim/image/depth_picture.h>

namespace scrim {

class HeldRay {
  public:
    /// The ray through raster position (x, y), by distance along it; `perDepth`: what that grows by with the depth.
    HeldRay(const DepthPicture* picture, double x, double y, double perDepth);

    /// The distance from which on nothing is seen.
    double end() const;
    /// What part is seen of what a point at that distance sends to the eye.
    double transmittance(double distance) const;
    /// `step` from `distance` on, or less: so that within it nothing begins or ends, and little is hidden.
    double limited(double distance, double step, double mostTau) const;

  private:
    DepthPicture::Pieces m_pieces;
    double m_scale = 1;  // distance over depth in the picture
};

}  // namespace scrim
