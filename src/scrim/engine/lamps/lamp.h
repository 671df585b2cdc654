// SPDX-License-Identifier: Apache-2.0
// A lamp, a point or a small sphere, as light on cells sees it: the way of its light, and where cells know it.
#pragma once

#include <scrim/engine/cells/cell_walk.h>
#include <scrim/scene/light.h>

#include <functional>
#include <memory>
#include <utility>

namespace scrim {

/// Gauss' and Legendre's four points in [0, 1] and their weights.
inline constexpr std::pair<double, double> kFourPoints[] = {{0.0694318442, 0.1739274226},
                                                            {0.3300094782, 0.3260725774},
                                                            {0.6699905218, 0.3260725774},
                                                            {0.9305681558, 0.1739274226}};

/// The radius of a lamp that is a sphere; 0: it is a point.
inline double radiusOfSphere(const Light& lamp) {
    return lamp.area() ? lamp.area()->radius : 0;
}

/// True if cells of this edge resolve a sphere, so that its light must begin at its surface.
bool hollowOnCells(const Light& lamp, double edge);

/// The distance from a lamp from which on cells that many lamps share keep all of its light, world units.
double nearestFar(const Light& lamp, double edge);

/// The blocks of `all` that are wanted, by their centres; a cell has a corner at `wsCorner`.
CellGrid blocksOf(const CellGrid& all, const Vec3& wsCorner, const std::function<bool(const Vec3& wsCenter)>& wants);
/// The blocks of `all` in which such a lamp has cells of its own.
std::shared_ptr<const CellGrid> cellsNear(const Light& lamp, const CellGrid& all, const Vec3& wsCorner);

/// The way of light from a lamp to a place at distance r of its centre: of a sphere the mean over the solid angle that
/// it fills there, which is that of t = r mu - sqrt(r^2 mu^2 - h^2) for mu from h / r to 1, with h^2 = r^2 - radius^2.
double wayFrom(const Light& lamp, double r);

/// The optical depth of what is left, on the way to `ws` outside of it, of a sphere's light: of its
/// mean over the solid angle that the sphere fills there, by 24 rays through the cells of all
/// media, whose extinction counts `extinction` times.
Rgb depthFromSphere(const MediaTogether& media, double extinction, const Vec3& wsCenter, double radius, const Vec3& ws);

/// The logarithm of the ratio by which the light of a hollow sphere is too bright where points on a shell of sqrt(3/4)
/// radii stand for it (pointsOfLamp). What passes b radii beside the centre begins at the surface, sqrt(1 - b^2) radii
/// nearer; the sphere, seen as a disk, and the shell differ in how often each b occurs. `depth`: the optical depth of
/// one radius through the medium around the sphere.
double shellOverDisk(double depth);

}  // namespace scrim
