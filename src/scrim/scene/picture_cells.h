// SPDX-License-Identifier: Apache-2.0
// Divides the picture of a sky or a luminous rectangle into cells of about equal importance: many small ones for a
// bright window, a few large ones for a dark wall. Every pixel's light is in exactly one cell, so no light is lost.
#pragma once

#include <scrim/image/sky_parts.h>
#include <scrim/scene/light.h>

#include <vector>

namespace scrim {

struct PictureCell {
    Rgb sum{0};  ///< dome: integral of the picture over the cell's solid angle; rectangle: its contribution to the mean
    Vec3 center{0};    ///< centre of its light; dome: unit direction towards the sky; rectangle: a point in world space
    double share = 0;  ///< fraction of the full solid angle, or of the rectangle's area
};

/// The picture of a dome without its suns.
inline const Texture& smoothPicture(const Slide& slide) {
    return slide.parts && slide.parts->smooth ? *slide.parts->smooth : *slide.image;
}

/// The sun of a dome that is not in its picture: that of a clear sky. Null: it has none.
inline const SkySun* sunBeside(const Slide& slide) {
    if (!slide.parts || slide.parts->suns.empty() || slide.parts->suns.front().rows.empty()) return nullptr;
    return &slide.parts->suns.front();
}

/// The radiance of such a sun at the height v of the dome's picture, where it is seen; beyond its
/// rims that of the nearer one. It has at least two rows.
Rgb sunRadiance(const SkySun& sun, double v);

/// The finest level of that picture that has at most 256 columns: what means over wide directions are computed from.
const Texture::Level& wideLevel(const Slide& slide);

/// The radiance of a dome in a direction (unit, towards the sky), without its suns, from that level.
Rgb skyAt(const Light& dome, const Vec3& direction);

/// What a camera sees of a dome in a direction (unit, towards the sky), suns and all: the mean over
/// about `angle` radians, those of a pixel.
Rgb visibleSky(const Light& dome, const Vec3& direction, double angle);

/// What a camera sees of an area light's surface at a place, whose normal (unit) points to where it
/// shines, by a ray along `direction` (unit): the mean over about `pixel` world units.
Rgb visibleSurface(const Light& light, const Vec3& ws, const Vec3& normal, const Vec3& direction, double pixel);

/// At most `count` cells of a dome with a loaded picture, its suns left out, without those that are
/// dark. Deterministic.
std::vector<PictureCell> domeCells(const Light& light, int count);

/// The fraction, in [0, 1], of a dome's light that comes from spots much smaller than one of
/// `directions` directions spread evenly over the sky, such as a sun: a mean over a direction blurs
/// them. Suns that are lights of their own do not count. 0 without a loaded picture.
double lightInSpots(const Light& dome, int directions);

/// As domeCells, for a rectangle with a loaded picture.
std::vector<PictureCell> rectangleCells(const Light& light, int count);

}  // namespace scrim
