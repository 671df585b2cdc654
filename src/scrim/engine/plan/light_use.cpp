// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/light_use.h>

#include <scrim/geometry/sheets.h>
#include <scrim/engine/plan/light_beam.h>
#include <scrim/engine/plan/view_frustum.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

bool litBy(const std::vector<bool>& lights, std::size_t light) {
    return lights.empty() || lights[light];
}

bool scatters(const ViewVolume& volume) {
    if (volume.field->empty()) return false;
    if (volume.classified) return true;
    return volume.medium.mostExtinction() > 0 && (!volume.scatter.empty() || volume.medium.albedo != Rgb(0));
}

// Might light that passes `from` come to `to`? Judged by what encloses either, so that a yes may be wrong.
bool shadowReaches(const Light& light, const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
    if (light.type == LightType::distant) {
        const Vec3 other = std::abs(light.wsDirection.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
        const Mat3 alongLight = sweepRotation(light.wsDirection, other);
        const auto boxOf = [&](const std::vector<Vec3>& points) {
            Bounds box;
            for (const Vec3& p : points) box.include(alongLight * p);
            return box;
        };
        const Bounds a = boxOf(from), b = boxOf(to);
        return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y && b.lower.y <= a.upper.y &&
               a.lower.z <= b.upper.z;
    }
    std::vector<Vec3> directions;
    const Cone a = coneToCorners(light.wsPosition, from, directions);
    directions.clear();
    const Cone b = coneToCorners(light.wsPosition, to, directions);
    if (a.cosAngle <= 0 || b.cosAngle <= 0) return true;
    double farthest = 0;
    for (const Vec3& p : to) farthest = std::max(farthest, glm::distance(p, light.wsPosition));
    // No point of the boxes is nearer than the plane through the nearest corner across the cone's axis.
    double nearest = 1e300;
    for (const Vec3& p : from) nearest = std::min(nearest, glm::dot(p - light.wsPosition, a.axis));
    const double between = std::acos(std::clamp(glm::dot(a.axis, b.axis), -1.0, 1.0));
    return nearest <= farthest && between <= std::acos(a.cosAngle) + std::acos(b.cosAngle);
}

}  // namespace

std::vector<std::string> uselessLights(const ViewScene& scene) {
    const ViewFrustum frustum(scene.camera, wholePicture(scene));
    std::vector<std::vector<Vec3>> visible;  // of volumes that scatter
    bool scattering = false;
    for (const ViewVolume& volume : scene.volumes) {
        scattering = scattering || scatters(volume);
        visible.push_back(scatters(volume) ? frustum.visibleParts(wsCorners(volume, scene.dials.kernel))
                                           : std::vector<Vec3>{});
    }
    std::vector<std::string> reasons;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        std::string& reason = reasons.emplace_back();
        if (light.intensity == Rgb(0)) {
            reason = "it is black";
            continue;
        }
        bool linked = false, sees = false, reaches = false;
        for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
            if (!litBy(scene.volumes[v].lights, i)) continue;
            linked = true;
            if (visible[v].empty()) continue;
            sees = true;
            std::vector<Vec3> directions;
            reaches = reaches || light.type == LightType::distant ||
                      !passesBy(light, beamOf(light), coneToCorners(light.wsPosition, visible[v], directions));
        }
        if (!scattering)
            reason = "no volume scatters light";
        else if (!linked)
            reason = "no volume is linked to it";
        else if (!sees)
            reason = "it lights nothing in view";
        else if (!reaches)
            reason = "its beam passes by all that it could light in view";
    }
    return reasons;
}

std::vector<std::string> uselessVolumes(const Camera& camera, const PixelWindow& picture,
                                        const std::vector<Light>& lights, const std::vector<VolumeBox>& volumes) {
    const ViewFrustum frustum(camera, picture);
    std::vector<std::vector<Vec3>> visible;
    bool allKnown = true;
    for (const VolumeBox& volume : volumes) {
        visible.push_back(frustum.visibleParts(volume.wsCorners.value_or(std::vector<Vec3>{})));
        allKnown = allKnown && volume.wsCorners;
    }
    const auto shades = [&](std::size_t v) {
        for (std::size_t i = 0; i < lights.size(); ++i)
            for (std::size_t w = 0; w < volumes.size(); ++w)
                if (lights[i].shadows && lights[i].intensity != Rgb(0) && litBy(volumes[w].lights, i) &&
                    !visible[w].empty() && shadowReaches(lights[i], *volumes[v].wsCorners, visible[w]))
                    return true;
        return false;
    };
    // Of a volume that nobody knows the place of, it may be that any other shades it.
    const bool mayShade =
        !allKnown && std::any_of(lights.begin(), lights.end(), [](const Light& l) { return l.shadows; });
    std::vector<std::string> reasons(volumes.size());
    for (std::size_t v = 0; v < volumes.size(); ++v) {
        if (!volumes[v].wsCorners || !visible[v].empty()) continue;
        if (!volumes[v].wsCorners->empty() && (mayShade || shades(v))) continue;
        reasons[v] = "it is out of view and throws no shadow into view";
    }
    return reasons;
}

}  // namespace scrim
