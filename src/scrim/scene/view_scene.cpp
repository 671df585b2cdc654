// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/view_scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {

bool solidsBlock(const ViewScene& scene) {
    return scene.solids && scene.solids->any(SolidRole::shadow);
}

bool sharpShadows(const ViewScene& scene) {
    constexpr int kFew = 4;
    int count = 0;
    for (const Light& light : scene.lights) {
        if (!light.shadows || light.intensity == Rgb(0)) continue;
        if (light.extended()) return false;
        ++count;
    }
    return solidsBlock(scene) && count > 0 && count <= kFew;
}

bool greySolids(const ViewScene& scene) {
    return !solidsBlock(scene) ||
           std::ranges::none_of(scene.solids->all(), [](const Solid& s) { return s.shadows && !isGrey(s.albedo); });
}

bool anyClassified(const ViewScene& scene) {
    return std::ranges::any_of(scene.volumes, [](const ViewVolume& v) { return v.classified != nullptr; });
}

bool anyEmits(const ViewScene& scene) {
    return std::ranges::any_of(scene.volumes, [](const ViewVolume& v) { return !v.emission.empty(); });
}

bool anyScattersFully(const ViewScene& scene) {
    return std::ranges::any_of(scene.volumes, scattersFully);
}

bool greyExtinction(const ViewScene& scene) {
    return std::all_of(scene.volumes.begin(), scene.volumes.end(),
                       [](const ViewVolume& v) { return v.classified || isGrey(v.medium.extinctionTint); });
}

bool greyScattering(const ViewScene& scene) {
    // Beside volumes in which light scatters more than once, others scatter light to them.
    const bool all = anyScattersFully(scene);
    return greyExtinction(scene) && std::all_of(scene.volumes.begin(), scene.volumes.end(), [&](const ViewVolume& v) {
               if (v.classified) return !scattersFully(v) || scattersGrey(*v.classified);
               return !all || (v.scatter.empty() && isGrey(v.medium.albedo));
           });
}

bool wants(const ViewScene& scene, Layer layer) {
    return std::find(scene.layers.begin(), scene.layers.end(), layer) != scene.layers.end();
}

int placeOf(const ViewScene& scene, std::size_t i) {
    const int place = scene.volumes[i].place;
    return place >= 0 ? place : static_cast<int>(i);
}

int lightOfLayer(const ViewScene& scene, int light) {
    const std::string& group = scene.lights[std::size_t(light)].group;
    if (group.empty()) return light;
    const auto first = std::find_if(scene.lights.begin(), scene.lights.end(),
                                    [&](const Light& other) { return other.group == group; });
    return static_cast<int>(first - scene.lights.begin());
}

std::size_t placesOf(const ViewScene& scene) {
    return scene.volumeCount > 0 ? scene.volumeCount : scene.volumes.size();
}

std::vector<ViewField> fieldsOf(const ViewVolume& volume) {
    std::vector<ViewField> fields{densityOf(volume)};
    for (const ViewEmission& emission : volume.emission) fields.push_back(emission.field);
    std::erase_if(fields, [](const ViewField& field) { return field.field->empty(); });
    return fields;
}

Bounds ViewVelocity::wsRange(const std::function<double(const SparseField&)>& most) const {
    Bounds v{Vec3(0), Vec3(0)};
    for (int axis = 0; axis < 3; ++axis) {
        v.upper[axis] = most(*parts[std::size_t(2 * axis)].field);
        v.lower[axis] = -most(*parts[std::size_t(2 * axis + 1)].field);
    }
    Bounds ways;
    for (const Vec3& corner : v.corners()) ways.include(wsPath * corner);
    return ways;
}

std::vector<Vec3> wsCorners(const ViewVolume& volume, Kernel kernel) {
    std::vector<Vec3> corners;
    for (const ViewField& field : fieldsOf(volume)) {
        Bounds is = field.field->isBounds();
        const double radius = kernelRadius(field.kernel.value_or(kernel));
        is.lower -= radius;
        is.upper += radius;
        for (const Vec3& corner : is.corners()) corners.push_back(transformPoint(field.wsFromIs, corner));
    }
    if (!volume.velocity) return corners;
    // The box grows by all displacements. But moved density only comes to lie where the velocity field has values, so
    // the part outside of the field's own box is limited to the reach of the velocity.
    Bounds still, moved, reach;
    for (const Vec3& corner : corners) still.include(corner);
    if (still.empty()) return corners;
    const Bounds ways = volume.velocity->wsRange();
    moved.include(still.lower + ways.lower);
    moved.include(still.upper + ways.upper);
    reach.include(still);
    for (const ViewField& part : volume.velocity->parts) {
        if (part.field->empty()) continue;
        Bounds is = part.field->isBounds();
        is.lower -= 1.0;  // the velocity is linear between its voxels
        is.upper += 1.0;
        reach.include(transformed(part.wsFromIs, is));
    }
    moved.include(still);
    const Bounds box{glm::max(moved.lower, reach.lower), glm::min(moved.upper, reach.upper)};
    const auto all = box.corners();
    return {all.begin(), all.end()};
}

double kernelRadius(const ViewScene& scene) {
    double radius = scene.volumes.empty() ? kernelRadius(scene.dials.kernel) : 0;
    for (const ViewVolume& volume : scene.volumes)
        radius = std::max(radius, kernelRadius(volume.kernel.value_or(scene.dials.kernel)));
    return radius;
}

std::vector<Vec3> wsCorners(const ViewScene& scene) {
    std::vector<Vec3> corners;
    for (const ViewVolume& volume : scene.volumes) {
        const std::vector<Vec3> own = wsCorners(volume, scene.dials.kernel);
        corners.insert(corners.end(), own.begin(), own.end());
    }
    return corners;
}

Bounds wsBounds(const ViewScene& scene) {
    Bounds ws;
    for (const Vec3& corner : wsCorners(scene)) ws.include(corner);
    return ws;
}

Vec3 wsOccupiedSize(const ViewScene& scene) {
    constexpr int kBins = 1024;
    constexpr double kMostEmpty = 0.25;
    const Bounds ws = wsBounds(scene);
    if (ws.empty()) return Vec3(0);
    const Vec3 perUnit = double(kBins) / glm::max(ws.size(), 1e-300);
    std::array<std::array<bool, kBins>, 3> filled{};
    const auto part = [&](int axis) {
        const auto& bins = filled[std::size_t(axis)];
        return double(std::count(bins.begin(), bins.end(), true)) / kBins;
    };
    for (const ViewVolume& volume : scene.volumes) {
        if (std::min({part(0), part(1), part(2)}) >= 1 - kMostEmpty) return ws.size();
        for (const ViewField& field : fieldsOf(volume)) {
            const double reach = kernelRadius(field.kernel.value_or(volume.kernel.value_or(scene.dials.kernel)));
            const Mat3 map(field.wsFromIs);
            const Vec3 wide = glm::abs(map[0]) + glm::abs(map[1]) + glm::abs(map[2]);
            const auto add = [&](const Int3& origin, int edge) {
                const double half = 0.5 * (edge - 1) + reach;
                const Vec3 middle = transformPoint(field.wsFromIs, Vec3(origin) + 0.5 * (edge - 1)) - ws.lower;
                for (int axis = 0; axis < 3; ++axis) {
                    const double far = half * wide[axis];
                    const auto bin = [&](double at) {
                        return static_cast<int>(std::clamp(at * perUnit[axis], 0.0, kBins - 1.0));
                    };
                    const auto first = filled[std::size_t(axis)].begin() + bin(middle[axis] - far);
                    std::fill_n(first, bin(middle[axis] + far) - bin(middle[axis] - far) + 1, true);
                }
            };
            for (const Int3& origin : field.field->blockOrigins) add(origin, kBlockEdge);
            for (const ConstantTile& tile : field.field->tiles) add(tile.origin, tile.edge);
        }
    }
    Vec3 size = ws.size();
    for (int axis = 0; axis < 3; ++axis)
        if (part(axis) < 1 - kMostEmpty) size[axis] *= part(axis);
    return size;
}

bool holdsOut(const ViewScene& scene) {
    return (scene.depths && scene.depths->thin) ||
           std::any_of(scene.volumes.begin(), scene.volumes.end(), [](const ViewVolume& v) { return v.holdout; });
}

PixelWindow wholePicture(const ViewScene& scene) {
    if (!scene.picture.empty()) return scene.picture;
    const PixelWindow& r = scene.region;
    return {std::min(r.x0, 0), std::min(r.y0, 0), std::max(r.x1, scene.camera.resolution.x),
            std::max(r.y1, scene.camera.resolution.y)};
}

double voxelUnit(const ViewScene& scene) {
    double unit = std::numeric_limits<double>::infinity();
    for (const ViewVolume& volume : scene.volumes) unit = std::min(unit, voxelUnit(volume));
    return unit < std::numeric_limits<double>::infinity() ? unit : 1.0;
}

double voxelUnit(const ViewVolume& volume) {
    double unit = std::numeric_limits<double>::infinity();
    for (const ViewField& field : fieldsOf(volume))
        for (int axis = 0; axis < 3; ++axis) unit = std::min(unit, glm::length(Vec3(field.wsFromIs[axis])));
    return unit;
}

}  // namespace scrim
