// SPDX-License-Identifier: Apache-2.0
#include <scrim/render/assemble.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/volume/coarser.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

using Ramp = std::vector<std::pair<double, double>>;

float ramped(const Ramp& ramp, double value) {
    if (value <= ramp.front().first) return static_cast<float>(ramp.front().second);
    for (std::size_t i = 1; i < ramp.size(); ++i)
        if (value <= ramp[i].first) {
            const double t = (value - ramp[i - 1].first) / (ramp[i].first - ramp[i - 1].first);
            return static_cast<float>(ramp[i - 1].second + t * (ramp[i].second - ramp[i - 1].second));
        }
    return static_cast<float>(ramp.back().second);
}

// Remaps the voxels of a field. Empty space stays empty, whatever the ramp says of 0: only active voxels are fed.
std::shared_ptr<const SparseField> withRamp(const SparseField& field, const Ramp& ramp) {
    auto out = std::make_shared<SparseField>(field);
    auto values = std::make_shared<std::vector<float>>(field.blockCount() * kBlockVoxels);
    parallelFor(field.blockCount(), [&](std::size_t b) {
        for (int i = 0; i < kBlockVoxels; ++i) {
            const float v = field.block(b)[i];
            (*values)[b * kBlockVoxels + static_cast<std::size_t>(i)] = v > 0 ? ramped(ramp, v) : 0.0f;
        }
    });
    out->blockValues = std::shared_ptr<const float>(values, values->data());
    out->maxValue = 0;
    for (const float v : *values) out->maxValue = std::max(out->maxValue, v);
    for (ConstantTile& tile : out->tiles) {
        tile.value = ramped(ramp, tile.value);
        out->maxValue = std::max(out->maxValue, tile.value);
    }
    return out;
}

// Pixels that the edge of a voxel covers where the volume comes closest to the camera.
double voxelInPixels(const Camera& camera, const SparseField& field, const Mat4& wsFromIs) {
    double edge = 1e300;
    for (int axis = 0; axis < 3; ++axis) edge = std::min(edge, glm::length(Vec3(wsFromIs[axis])));
    const RayFamily rays = wsRays(camera);
    if (camera.type == CameraType::orthographic) return edge / glm::length(rays.originX);
    const Bounds ws = transformed(wsFromIs, field.isBounds());
    const double distance = glm::distance(glm::clamp(camera.wsPosition, ws.lower, ws.upper), camera.wsPosition);
    return edge / std::max(glm::length(rays.directionX) * distance, 1e-300);
}

// Halves the resolution as long as the voxels stay below `lod` pixels.
std::shared_ptr<const SparseField> withLevelOfDetail(const Camera& camera, double lod, const Mat4& wsFromAsset,
                                                     std::shared_ptr<const SparseField> field) {
    while (2 * voxelInPixels(camera, *field, wsFromAsset * field->wsFromIs) <= lod && field->activeVoxels > 1)
        field = std::make_shared<SparseField>(coarser(*field));
    return field;
}

}  // namespace

ViewScene assemble(const Scene& scene, const std::vector<VolumeFields>& fields,
                   const std::optional<PixelWindow>& crop, std::size_t memoryLimit) {
    ViewScene out;
    out.camera = scene.camera;
    out.region = {-scene.overscan, -scene.overscan, scene.camera.resolution.x + scene.overscan,
                  scene.camera.resolution.y + scene.overscan};
    if (crop) {
        const PixelWindow part = intersection(out.region, *crop);
        if (part.empty())
            throw Error(
                ErrorKind::usage,
                fmt::format("the crop {},{},{},{} holds no pixel of the picture, which is {},{},{},{}", crop->x0,
                            crop->y0, crop->x1, crop->y1, out.region.x0, out.region.y0, out.region.x1, out.region.y1));
        out.region = part;
    }
    out.lights = scene.lights;
    out.ambient = scene.ambient;
    out.dials = scene.dials;
    out.layers = scene.output.layers;
    out.lines = scene.lines;
    out.memoryLimit = memoryLimit;
    for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
        const SceneVolume& volume = scene.volumes[i];
        std::shared_ptr<const SparseField> field = fields[i].density;
        if (!field || field->empty()) continue;
        if (!volume.ramp.empty()) field = withRamp(*field, volume.ramp);
        if (scene.dials.lod > 0)
            field = withLevelOfDetail(scene.camera, scene.dials.lod, volume.wsFromAsset, std::move(field));
        out.volumes.push_back(
            {volume.name, field, volume.wsFromAsset * field->wsFromIs, volume.medium, volume.classified});
    }
    return out;
}

}  // namespace scrim
