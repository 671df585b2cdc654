// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/wide_lights.h>

#include <scrim/engine/lamps/area_shine.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/geometry/even_points.h>
#include <scrim/scene/optics.h>
#include <scrim/scene/phase_over_caps.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

// True if some volumes have voxels of more than `least` of optical depth at even places on a sphere.
bool meets(const ViewScene& scene, bool (*some)(const ViewVolume&), const Vec3& center, double radius, int places,
           double least) {
    FieldSamplers samplers;
    for (const ViewVolume& volume : scene.volumes) {
        if (volume.field->empty() || !some(volume)) continue;
        const VolumeOptics optics(volume, Kernel::linear, samplers);
        for (int i = 0; i < places; ++i)
            if (optics.mostExtinction(center + radius * evenDirection(i, places)) * voxelUnit(volume) > least)
                return true;
    }
    return false;
}

// True if opaque voxels of surfaces touch the sphere of a lamp.
bool touchesSurfaces(const ViewScene& scene, const Light& light) {
    const auto isSurface = [](const ViewVolume& volume) { return volume.classified != nullptr; };
    return meets(scene, isSurface, light.wsPosition, light.area()->radius, 64, 0.1);
}

}  // namespace

// Lamps that opaque voxels touch: nearly all that is seen of their light is within a cell of them.
// A sphere of three voxels across in a cavity of a scan leaves 3 to 6 %; where voxels touch it, one
// of two and one of six left 49 and 220 %.
void addTouchingLamps(const ViewScene& scene, PromisedDials& promised) {
    constexpr double kLeft = 0.9;
    for (const Light& light : scene.lights)
        if (light.area() && light.area()->shape == AreaShape::sphere && light.intensity != Rgb(0) &&
            touchesSurfaces(scene, light))
            promised.beyond.push_back(
                {kLeft, fmt::format("surfaces touch the sphere of light '{}', whose light there changes within a cell; "
                                    "a smaller radius, or a place with no voxels around it, avoids that",
                                    light.name)});
}

namespace {

// What the lobes of phase functions and the spreads of surfaces leave, where they are narrow beside the lights.
struct Narrow {
    double expected = 0;
    std::string why;
    void take(double error, const std::string& reason) {
        if (error > expected) expected = error, why = reason;
    }
};

// The narrowest lobe that shows a light; pi if none is narrow. Surfaces of scans have none.
double narrowestLobe(const ViewScene& scene, std::size_t light) {
    double narrowest = std::numbers::pi;
    for (const ViewVolume& volume : scene.volumes)
        if (!volume.classified && !volume.field->empty() && litBy(volume.lights, light))
            narrowest = std::min(narrowest, lobeWidth(volume.medium.phase));
    return narrowest;
}

// The least angle by which light from a surface is turned towards the eye, radians, at places on a lattice in volumes
// whose lobes point onwards: what such a lobe shows is no narrower than a part of that angle.
double leastTurn(const ViewScene& scene, std::size_t index) {
    constexpr int kPlaces = 11;
    FieldSamplers samplers;
    const Light& light = scene.lights[index];
    const Light::Area& area = *light.area();
    const double size = area.shape == AreaShape::mesh        ? 0.5 * glm::length(area.wsSurface.size())
                        : area.shape == AreaShape::rectangle ? 0.5 * std::hypot(area.width, area.height)
                        : area.shape == AreaShape::cylinder  ? std::hypot(0.5 * area.width, area.radius)
                                                             : area.radius;
    double least = std::numbers::pi;
    for (const ViewVolume& volume : scene.volumes) {
        if (volume.classified || volume.field->empty() || !litBy(volume.lights, index)) continue;
        const Phase& phase = volume.medium.phase;
        if (phase.g < 0 || (phase.type == PhaseType::twoLobe && phase.g2 < 0)) return 0;
        const Bounds ws = transformed(volume.wsFromIs, volume.field->isBounds());
        const double between = 0.25 * glm::length(ws.size()) / (kPlaces - 1);
        const VolumeOptics optics(volume, Kernel::linear, samplers);
        for (int i = 0; i < kPlaces * kPlaces * kPlaces; ++i) {
            const Vec3 part = Vec3(i % kPlaces, i / kPlaces % kPlaces, i / (kPlaces * kPlaces)) / double(kPlaces - 1);
            const Vec3 at = ws.lower + part * ws.size(), way = at - light.wsPosition;
            if (!(optics.mostExtinction(at) > 0)) continue;
            const double distance = glm::length(way);
            if (distance <= size + between) return 0;
            const double cosine = glm::dot(way / distance, travelToEye(scene.camera, at));
            double turn = std::acos(std::clamp(cosine, -1.0, 1.0)) - std::asin((size + between) / distance);
            if (scene.camera.type == CameraType::perspective)
                turn -= std::asin(std::min(between / glm::distance(at, scene.camera.wsPosition), 1.0));
            least = std::min(least, turn);
        }
    }
    return std::max(least, 0.0);
}

}  // namespace

// Narrow lobes show surfaces with their edges, which means over sub-lights blur. Smoke of 24^3 voxels before a square,
// a disk and a cylinder, and beside a sphere, with g = 0.6, 0.8, 0.9 and 0.98 (lobes of 0.4 to 0.02 radians): 1.1
// to 2.0, 2.1 to 3.1, 5.0 to 7.7 and 18 to 125 %; the same with droplets of 1 and 10 micrometres (g of 0.85 and 0.98).
// A dome leaves 0.9 and 2.3 % with g of 0 and 0.9, a clear sky 1.3 to 2.5 with g of 0.7 and 0.8 and 3.0 to 3.4 with
// 0.9. Points with spreads of 45, 20, 10, 3 and 1 degrees, of surfaces that are not beams, leave 1.4 to 2.6, 4.4
// to 7.1, 13 to 21, 110 to 180 and 210 to 550 %. Droplets of 12 micrometres in a ball leave 35 to 80 % with a rectangle
// and a sphere behind it, 4 to 5 % with these beside it, and 1 % with the rectangle before it.
void addNarrow(const ViewScene& scene, PromisedDials& promised) {
    constexpr double kOfSurface = 0.006, kOfSky = 0.02, kNarrow = 0.25, kNarrowToSkies = 0.15, kOfPicture = 0.034,
                     kOfPictureToLobes = 0.025, kLobe = 0.35, kOfTurn = 1.0 / 6;
    constexpr double kSpread = 45, kOfSpread = 0.018, kGrowth = 1.4, kClearly = 1.05;
    Narrow narrow;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        if (light.intensity == Rgb(0) || (!light.area() && !light.dome())) continue;
        const double lobe = narrowestLobe(scene, i);
        const bool picture = light.dome() && light.slide;
        const double ofPicture = lobe < kNarrowToSkies ? kOfPicture : kOfPictureToLobes;
        if (lobe < (picture ? kLobe : light.dome() ? kNarrowToSkies : kNarrow))
            narrow.take(picture        ? ofPicture
                        : light.dome() ? kOfSky
                                       : kOfSurface / std::max(lobe, kOfTurn * leastTurn(scene, i)),
                        fmt::format("phase functions as narrow as {:.2g} degrees show the extended light '{}' with its "
                                    "edges, which its sub-lights blur",
                                    glm::degrees(lobe), light.name));
        if (light.area() && light.area()->spread < kSpread && !shinesInBeams(scene, light))
            narrow.take(
                kOfSpread * std::pow(kSpread / light.area()->spread, kGrowth),
                fmt::format("points of light '{}' with a spread of {:.2g} degrees show one by one; a projector, "
                            "or a surface with all volumes before it, does not have this error",
                            light.name, light.area()->spread));
    }
    if (narrow.expected > kClearly * promised.promised && narrow.expected > promised.expected)
        promised.beyond.push_back({narrow.expected, narrow.why});
}

namespace {

// True if the camera may see a place, by its frame and what it shows beyond that.
bool isInPicture(const Camera& camera, const Vec3& ws) {
    const glm::dvec4 at = worldToNdc(camera) * glm::dvec4(ws, 1);
    return at.w > 0 && std::abs(at.x) <= at.w && std::abs(at.y) <= at.w;
}

// True if a medium is around a place.
bool isAmongMedia(const ViewScene& scene, const Vec3& ws, double around) {
    const auto isSeen = [](const ViewVolume& volume) { return !volume.classified && !volume.holdout; };
    return meets(scene, isSeen, ws, around, 16, 0);
}

}  // namespace

// The light of a surface rises towards it, and cells and points show it no finer than they are. A square of 1.6, 4, 8
// and 16 voxels in haze that the eye sees, with cells of a quarter of a voxel, left 90, 23, 14 and 8 %; with shadow
// buffers 60, 16, 11 and 7 %. A cylinder of 0.4 by 3.2 voxels left 40 %. Where look-ups compute that light (AreaField),
// squares, disks and cylinders leave 0.2 to 1 %; with a phase function of g = 0.6 1.0, 2.0 and 1.6 %. A cube of
// 1.6 voxels that is a mesh leaves 0.4 to 1.6 %, a ring of a tube of 1.3 voxels 2.5 to 3 %.
void addSurfacesAmong(const ViewScene& scene, PromisedDials& promised) {
    constexpr double kOfSize = 1.2, kMost = 0.9, kTurning = 0.02, kLobe = 0.5, kOfMesh = 0.03;
    constexpr double kNarrowSpread = 45;  // whose beams shadow buffers see
    for (const Light& light : scene.lights) {
        const Light::Area* area = light.area();
        if (!area || light.intensity == Rgb(0) || isLampOnCells(scene, light) || area->spread < kNarrowSpread) continue;
        const double size = std::sqrt(area->area());
        if (!isInPicture(scene.camera, light.wsPosition) || !isAmongMedia(scene, light.wsPosition, size)) continue;
        const auto number = std::size_t(&light - scene.lights.data());
        const bool turns = narrowestLobe(scene, number) < kLobe;
        const bool ownField = AreaShine::serves(light) && planCellLights(scene).has(number);
        const double blobs = std::min(kOfSize * voxelUnit(scene) / size, kMost);
        const double known = area->shape == AreaShape::mesh ? std::min(kOfMesh, blobs) : turns ? kTurning : 0;
        const double expected = ownField ? known : blobs;
        if (expected > promised.promised && expected > promised.expected)
            promised.beyond.push_back(
                {expected, fmt::format("the surface of light '{}' shines among volumes in the picture, where its light "
                                       "changes within a cell; a sphere of the same size does not have this error",
                                       light.name)});
    }
}

}  // namespace scrim
