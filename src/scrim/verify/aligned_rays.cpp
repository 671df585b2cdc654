// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/aligned_rays.h>

#include <scrim/geometry/bounds.h>
#include <scrim/verify/pilot_rays.h>

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr double kOnLine = 0.05;  // voxels from a line through centres

// Of the two axes across a ray, the part at which it runs along such lines, in a volume that it meets from `first` to
// `end`.
double partOnLines(const ViewVolume& volume, const Vec3& wsOrigin, const Vec3& wsDirection, double first, double end) {
    constexpr int kPlaces = 4;
    const Mat4 isFromWs = glm::inverse(volume.wsFromIs);
    const int along = axisOfLargest(glm::abs(Mat3(isFromWs) * wsDirection));
    int on = 0;
    for (int i = 0; i < kPlaces; ++i) {
        const Vec3 is =
            transformPoint(isFromWs, wsOrigin + (first + (i + 0.5) / kPlaces * (end - first)) * wsDirection);
        const Vec3 beside = glm::abs(is - glm::round(is));
        for (int axis = 0; axis < 3; ++axis) on += axis != along && beside[axis] < kOnLine;
    }
    return on / (2.0 * kPlaces);
}

// The mean of that over rays of the picture through the volumes.
double shareOnLines(const ViewScene& scene) {
    constexpr int kRays = 400;
    const RayFamily rays = wsRays(scene.camera);
    const double perPixel = scene.dials.antialias;
    double sum = 0;
    int count = 0;
    for (int i = 0; i < kRays; ++i) {
        const Vec3 place = pilotPlace(i);
        const Vec2 at = (glm::floor(Vec2(place) * Vec2(scene.camera.resolution) * perPixel) + 0.5) / perPixel;
        const Vec3 direction = glm::normalize(rays.direction(at.x, at.y)), origin = rays.origin(at.x, at.y);
        for (const ViewVolume& volume : scene.volumes) {
            if (volume.field->empty() || volume.classified) continue;
            const auto [first, end] =
                transformed(volume.wsFromIs, volume.field->isBounds()).clip(origin, direction, 0, 1e300);
            if (!(first < end)) continue;
            sum += partOnLines(volume, origin, direction, first, end);
            ++count;
        }
    }
    return count > 0 ? sum / count : 0;
}

}  // namespace

// Texels of a voxels leave an error in proportion to a there, and to its power 1.8 elsewhere, by which they are chosen.
// A ball of noise, one pixel a voxel, an orthographic camera along an axis: draft, standard, high and ultra leave 9.1,
// 4.8, 2.4 and 1.7 %, where 10, 4.4, 2.6 and 1.3 are foreseen; a third of a voxel beside that 0.2 at standard; three
// pixels a voxel 2.5 (2.3). Disney's cloud 3.3.
void addAlignedRays(const ViewScene& scene, PromisedDials& promised) {
    constexpr double kEven = 2 * kOnLine;  // the share of rays that run anywhere
    constexpr double kMany = 0.25, kOfPromise = 1.6, kPower = -0.8;
    const double share = shareOnLines(scene);
    if (share < kMany) return;
    const double expected = kOfPromise * promised.promised * std::pow(std::min(promised.dials.texel, 1.0), kPower) *
                            std::sqrt((share - kEven) / (1 - kEven));
    if (!(expected > promised.promised && expected > promised.expected)) return;
    PromisedDials::Beyond& beyond = promised.beyond.emplace_back();
    beyond.expected = expected;
    beyond.why =
        "rays of the picture run through the centres of voxels, where interpolation bends; a camera that is a "
        "third of a voxel beside that, or antialias = 4, does not have this error";
}

}  // namespace scrim
