// SPDX-License-Identifier: Apache-2.0
// The picture of a sky, divided into its suns and the smooth rest. A sun has most of a sky's light in a few pixels: as
// a light of its own it casts the sharp shadow that a sum of wide directions blurs.
#pragma once

#include <scrim/image/image.h>
#include <scrim/image/texture.h>

#include <memory>
#include <vector>

namespace scrim {

/// A small bright spot of a lat-long picture.
struct SkySun {
    double u = 0, v = 0;  ///< its centre, in [0, 1] from the picture's left and top
    double angle = 0;     ///< full angle of a disk of its solid angle, degrees
    Rgb light{0};         ///< integral over its solid angle of what it adds to the sky around it
    /// Radiance of a sun that is not in the picture itself, from its lowest to its highest
    /// elevation, at the middles of strips of equal heights; empty: it is in the picture.
    std::vector<Rgb> rows = {};
};

struct SkyParts {
    std::vector<SkySun> suns;               ///< the brightest first
    std::shared_ptr<const Texture> smooth;  ///< the picture without them, at most 2048 pixels wide; null: it has none
};

/// Finds at most 8 suns: spots at most 5 degrees across, much brighter than the sky, each with 0.5
/// % of its light or more. The integral of the parts is that of the picture, to rounding.
SkyParts skyParts(const Texture& picture);

}  // namespace scrim
