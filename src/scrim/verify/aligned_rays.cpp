// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/aligned_rays.h>

#include <scrim/geometry/bounds.h>
#include <scrim/verify/pilot_rays.h>
#include <scrim/volume/field_sampler.h>

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr double kOnLine = 0.05;  // voxels from a line through centres
constexpr double kLost = 0.09;    // of what values bend in a voxel, times the texel

bool isOnLine(const Vec3& is, int axis) {
    return std::abs(is[axis] - std::round(is[axis])) < kOnLine;
}

// A ray's way through a volume, in index space.
struct Way {
    Vec3 from, all;
    double length = 0;  // in world space
    int along() const { return axisOfLargest(glm::abs(all)); }
};

// Calls visit(way) for rays all over the picture that meet the volume.
template <class Visit>
void forRays(const ViewScene& scene, const ViewVolume& volume, const Visit& visit) {
    constexpr int kRays = 400;
    const RayFamily rays = wsRays(scene.camera);
    const double perPixel = scene.dials.antialias;
    const Bounds is = volume.field->isBounds();
    const Bounds box = transformed(volume.wsFromIs, {is.lower - 1.0, is.upper + 1.0});
    const Mat4 isFromWs = glm::inverse(volume.wsFromIs);
    for (int i = 0; i < kRays; ++i) {
        const Vec2 place(pilotPlace(i));
        const Vec2 at = (glm::floor(place * Vec2(scene.camera.resolution) * perPixel) + 0.5) / perPixel;
        const Vec3 origin = rays.origin(at.x, at.y), direction = glm::normalize(rays.direction(at.x, at.y));
        const auto [first, end] = box.clip(origin, direction, 0, 1e300);
        if (!(first < end)) continue;
        const Vec3 from = transformPoint(isFromWs, origin + first * direction);
        visit(Way{from, transformPoint(isFromWs, origin + end * direction) - from, end - first});
    }
}

// Of the two axes across a ray, the part at which it runs along such lines.
double partOnLines(const Way& way) {
    constexpr int kPlaces = 4;
    int on = 0;
    for (int i = 0; i < kPlaces; ++i)
        for (int axis = 0; axis < 3; ++axis)
            on += axis != way.along() && isOnLine(way.from + (i + 0.5) / kPlaces * way.all, axis);
    return on / (2.0 * kPlaces);
}

// What is seen along a ray, and how much it bends across the ray where that runs along such lines.
struct Seen {
    double depth = 0, bends = 0;
};
// `depth`: optical depth along all of the way where values are 1.
Seen seenAlong(const FieldSampler& sampler, const Way& way, double depth) {
    constexpr double kMost = 256;
    const int steps = int(std::clamp(std::round(std::abs(way.all[way.along()])), 1.0, kMost));
    double transmittance = 1;
    Seen out;
    for (int i = 0; i < steps; ++i) {
        const Vec3 is = way.from + (i + 0.5) / steps * way.all;
        const Int3 voxel(glm::round(is));
        const double here = sampler.voxel(voxel), part = transmittance * depth / steps;
        transmittance *= std::exp(-depth / steps * here);
        out.depth += part * here;
        for (int axis = 0; axis < 3; ++axis) {
            if (axis == way.along() || !isOnLine(is, axis)) continue;
            Int3 before = voxel, after = voxel;
            --before[axis], ++after[axis];
            out.bends += part * (sampler.voxel(before) - 2 * here + sampler.voxel(after));
        }
    }
    return out;
}

bool counts(const ViewVolume& volume) {
    return !volume.field->empty() && !volume.classified;
}

// The mean part of rays through the volumes that runs along such lines.
double shareOnLines(const ViewScene& scene) {
    double share = 0;
    int count = 0;
    for (const ViewVolume& volume : scene.volumes)
        if (counts(volume)) forRays(scene, volume, [&](const Way& way) { share += partOnLines(way), ++count; });
    return count > 0 ? share / count : 0;
}

// What texels of `texel` voxels lose there: its RMS over the mean of what is seen.
double lostOnLines(const ViewScene& scene, double texel) {
    double lost = 0, depth = 0;
    int count = 0;
    for (const ViewVolume& volume : scene.volumes) {
        if (!counts(volume)) continue;
        const FieldSampler sampler(*volume.field);
        forRays(scene, volume, [&](const Way& way) {
            const Seen seen = seenAlong(sampler, way, volume.medium.densityScale * way.length);
            lost += std::pow(std::expm1(-kLost * texel * std::abs(seen.bends)), 2);
            depth += seen.depth;
            ++count;
        });
    }
    return depth > 0 ? std::sqrt(lost / count) / (depth / count) : 0;
}

}  // namespace

// Texels leave an error in proportion to their size there, and to its power 1.8 elsewhere, by which they are chosen.
// What is expected, and what is left: a ball of noise, one pixel a voxel, an orthographic camera along an axis, 5.6
// and 4.8 %; a third of a voxel beside that none, and 0.2; with a fortieth of its density 5 and 3.9; Disney's cloud 2.6
// and 2.9; a cube of even fog whose faces are on such rays 2.8 and 5.6. Dense edges that are lit from the side leave up
// to four times as much as is expected.
void addAlignedRays(const ViewScene& scene, PromisedDials& promised) {
    constexpr double kMany = 0.25;  // of rays; 0.1 are on such lines by chance
    if (shareOnLines(scene) < kMany) return;
    const double expected = lostOnLines(scene, std::min(promised.dials.texel, 1.0));
    if (!(expected > promised.promised && expected > promised.expected)) return;
    PromisedDials::Beyond& beyond = promised.beyond.emplace_back();
    beyond.expected = expected;
    beyond.why =
        "rays of the picture run through the centres of voxels, where interpolation bends; a camera that is a "
        "third of a voxel beside that, or antialias = 4, does not have this error";
}

}  // namespace scrim
