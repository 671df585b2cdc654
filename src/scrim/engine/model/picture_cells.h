// SPDX-License-Identifier: Apache-2.0
// The picture of a sky or a luminous rectangle, cut into cells that each count about as much: a bright window has many
// small ones and a dark wall a few large ones. Every pixel's light is in just one cell, so that no light gets lost.
#pragma once

#include <scrim/scene/light.h>

#include <vector>

namespace scrim {

struct PictureCell {
    Rgb sum{0};        ///< dome: integral of the picture over the cell's solid angle; rectangle: its share of the mean
    Vec3 center{0};    ///< of its light: dome: unit direction towards the sky; rectangle: a point in world space
    double share = 0;  ///< of all solid angles, or of the rectangle's area
};

/// At most `count` cells, those without light left out. Deterministic. Of a dome with a loaded picture.
std::vector<PictureCell> domeCells(const Light& light, int count);

/// What share of a dome's light comes from spots, such as a sun, that are much smaller than one of `directions` that
/// are spread evenly over the sky: a mean over a direction blurs those. In [0, 1]; 0 without a loaded picture.
double lightInSpots(const Light& dome, int directions);

/// As domeCells, of a rectangle with a loaded picture.
std::vector<PictureCell> rectangleCells(const Light& light, int count);

}  // namespace scrim
