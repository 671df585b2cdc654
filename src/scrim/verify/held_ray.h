// SPDX-License-Identifier: Apache-2.0
// The fraction of a ray's light that a depth or deep picture lets through, point by point. The
// reference uses it to integrate numerically what the engine computes in closed form.
#pragma once

#include <scrim/image/depth_picture.h>

namespace scrim {

class HeldRay {
  public:
    /// The ray through raster position (x, y). Points on it are given by their distance; `perDepth`
    /// is the distance for each unit of depth.
    HeldRay(const DepthPicture* picture, double x, double y, double perDepth);

    /// The distance beyond which nothing is seen.
    double end() const;
    /// The fraction of light from a point at `distance` that reaches the eye.
    double transmittance(double distance) const;
    /// `step`, shortened so that no piece of the picture begins or ends within it and it hides at
    /// most an optical depth of `mostTau`.
    double limited(double distance, double step, double mostTau) const;

  private:
    DepthPicture::Pieces m_pieces;
    double m_scale = 1;  // distance over the picture's depth
};

}  // namespace scrim
