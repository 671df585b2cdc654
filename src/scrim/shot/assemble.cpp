// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/assemble.h>

#include <scrim/base/error.h>
#include <scrim/shot/derived_fields.h>
#include <scrim/shot/moved_field.h>
#include <scrim/shot/shaded_field.h>
#include <scrim/engine/plan/culling.h>
#include <scrim/volume/coarser.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

// The number of pixels that the edge of a voxel covers where the volume comes closest to the camera.
double voxelInPixels(const Camera& camera, const SparseField& field, const Mat4& wsFromIs) {
    double edge = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) edge = std::min(edge, glm::length(Vec3(wsFromIs[axis])));
    const Bounds ws = transformed(wsFromIs, field.isBounds());
    const double distance = glm::distance(glm::clamp(camera.wsPosition, ws.lower, ws.upper), camera.wsPosition);
    return edge / std::max(pixelAt(camera, distance), 1e-300);
}

// Halves the field's resolution as long as its voxels stay below `lod` pixels.
std::shared_ptr<const SparseField> withLevelOfDetail(const Camera& camera, double lod, const Mat4& wsFromAsset,
                                                     std::shared_ptr<const SparseField> field) {
    if (field->empty()) return field;
    while (2 * voxelInPixels(camera, *field, wsFromAsset * field->wsFromIs) <= lod && field->activeVoxels > 1)
        field = std::make_shared<SparseField>(coarser(*field));
    return field;
}

// Whether each light of the scene lights the volume; empty: all do.
std::vector<bool> lightsOf(const Scene& scene, const SceneVolume& volume) {
    std::vector<bool> lit;
    if (!volume.lights) return lit;
    for (const Light& light : scene.lights)
        lit.push_back(std::find(volume.lights->begin(), volume.lights->end(), light.name) != volume.lights->end());
    return lit;
}

// The rest of `limit` (0: none) after the fields that were derived from those in `fields`.
std::size_t limitBeside(const std::vector<ViewVolume>& volumes, const std::vector<VolumeFields>& fields,
                        std::size_t limit) {
    if (limit == 0) return 0;
    std::set<FieldPointer> given, made;
    for (const VolumeFields& of : fields) {
        given.insert(of.density);
        given.insert(of.emission.begin(), of.emission.end());
    }
    std::size_t bytes = 0;
    const auto add = [&](const FieldPointer& field) {
        if (!given.contains(field) && made.insert(field).second) bytes += field->bytes();
    };
    for (const ViewVolume& volume : volumes) {
        add(volume.field);
        for (const ViewField& scatter : volume.scatter) add(scatter.field);
        for (const ViewEmission& emission : volume.emission) add(emission.field.field);
    }
    if (bytes >= limit)
        throw Error(
            ErrorKind::memory,
            fmt::format("the data made from the volumes' grids needs {}, more than the {} that the memory limit leaves",
                        bytesText(bytes), bytesText(limit)));
    return limit - bytes;
}

// Moves the fields of a volume by its velocity; null where nothing moves.
std::unique_ptr<const FieldMover> moverOf(const VolumeFields& fields, const SparseField& density) {
    const FieldPath path{fields.velocity, fields.time};
    if (!path.moves()) return nullptr;
    const auto glows = std::find_if(fields.emission.begin(), fields.emission.end(),
                                    [](const FieldPointer& field) { return field && !field->empty(); });
    return std::make_unique<const FieldMover>(path,
                                              density.empty() && glows != fields.emission.end() ? **glows : density);
}

/// Gives the volume, whose grid is `density`, its look with the scale of its extinction.
void addLook(const SceneVolume& volume, const SparseField& density, ViewVolume& out) {
    out.medium = volume.medium;
    out.medium.densityScale = volume.densityScale;
    if (!volume.classified) return;
    Classified look = *volume.classified;
    look.densityScale = volume.densityScale;
    if (look.perVoxel)
        look.densityScale /= std::cbrt(std::abs(glm::determinant(Mat3(volume.wsFromAsset * density.wsFromIs))));
    out.classified = std::make_shared<const Classified>(std::move(look));
    for (const HalfSpace& face : volume.clip) out.wsClip.push_back(transformed(face, glm::inverse(volume.wsFromAsset)));
}

std::optional<Kernel> kernelOf(GridInterpolation interpolation) {
    if (interpolation == GridInterpolation::automatic) return std::nullopt;
    return interpolation == GridInterpolation::smooth ? Kernel::bspline : Kernel::linear;
}

// A volume with all fields that are derived from its grids; no value where all of it is empty.
std::optional<ViewVolume> viewOf(const Scene& scene, const SceneVolume& volume, const VolumeFields& fields,
                                 Moved moved) {
    std::unique_ptr<const FieldMover> mover;
    const auto placed = [&](FieldPointer field) {
        if (mover) field = (*mover)(field);
        if (scene.dials.lod > 0)
            field = withLevelOfDetail(scene.camera, scene.dials.lod, volume.wsFromAsset, std::move(field));
        const Mat4 wsFromIs = volume.wsFromAsset * field->wsFromIs;
        return ViewField{std::move(field), wsFromIs, kernelOf(volume.interpolation)};
    };
    ViewVolume out;
    out.name = volume.name;
    out.kernel = kernelOf(volume.interpolation);
    out.lights = lightsOf(scene, volume);
    out.holdout = volume.holdout;
    FieldPointer density = fields.density ? fields.density : std::make_shared<SparseField>();
    addLook(volume, *density, out);
    if (!volume.ramp.empty()) density = withRamp(*density, volume.ramp);
    // What is classified is cut where it is seen, because its values must not change.
    const auto cut = [&](const FieldPointer& field) {
        return volume.classified || volume.clip.empty() ? field : clippedField(field, volume.clip);
    };
    density = cut(density);
    if (moved == Moved::byVelocity)
        out.velocity = velocityOf(volume, fields);
    else
        mover = moverOf(fields, *density);
    if (!volume.classified && !volume.holdout) {
        for (std::size_t i = 0; i < fields.emission.size(); ++i)
            if (fields.emission[i] && !fields.emission[i]->empty())
                for (const EmittedField& emitted : emittedFields(fields.emission[i], volume.emission[i])) {
                    const auto& mask = volume.emission[i].mask;
                    const bool masked = mask && i < fields.emissionMasks.size() && fields.emissionMasks[i];
                    const FieldPointer own =
                        masked ? maskedField(emitted.field, *mask, fields.emissionMasks[i]) : emitted.field;
                    out.emission.push_back({placed(cut(own)), emitted.color});
                }
        if (volume.albedoGrid && fields.albedo[0] && !density->empty())
            for (const FieldPointer& channel : scatteringFields(*density, fields.albedo, *volume.albedoGrid))
                out.scatter.push_back(placed(channel));
    }
    if (density->empty() && out.emission.empty()) return std::nullopt;
    const ViewField own = placed(density);
    out.field = own.field;
    out.wsFromIs = own.wsFromIs;
    return out;
}

}  // namespace

PixelWindow pictureOf(const Scene& scene) {
    const Int2 size = scene.camera.resolution;
    return {-scene.overscan, -scene.overscan, size.x + scene.overscan, size.y + scene.overscan};
}

std::shared_ptr<const ViewVelocity> velocityOf(const SceneVolume& volume, const VolumeFields& fields) {
    if (!FieldPath{fields.velocity, fields.time}.moves()) return nullptr;
    auto out = std::make_shared<ViewVelocity>();
    for (const FieldPointer& part : fields.velocity) out->parts.push_back({part, volume.wsFromAsset * part->wsFromIs});
    out->wsPath = fields.time * Mat3(volume.wsFromAsset);
    return out;
}

ViewScene assemble(const Scene& scene, const std::vector<VolumeFields>& fields, const std::optional<PixelWindow>& crop,
                   std::size_t memoryLimit, VolumesOf volumesOf, Moved moved) {
    ViewScene out;
    out.camera = scene.camera;
    out.region = out.picture = pictureOf(scene);
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
    if (!out.dials.crossFade && !scene.moves) out.dials.crossFade = 0;
    out.layers = scene.output.layers;
    if (wants(out, Layer::volume) && !wants(out, Layer::cryptomatte)) out.layers.push_back(Layer::cryptomatte);
    out.depths = scene.output.holdout.picture;
    if (scene.shutter) out.shutter = ViewShutter{scene.shutter->open, scene.shutter->close};
    out.lines = scene.lines;
    std::vector<std::optional<std::vector<Vec3>>> corners;
    std::vector<std::optional<ViewVolume>> volumes;
    out.volumeCount = scene.volumes.size();
    for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
        volumes.push_back(viewOf(scene, scene.volumes[i], fields[i], moved));
        if (volumes[i]) volumes[i]->place = static_cast<int>(i);
        corners.push_back(volumes[i] ? wsCorners(*volumes[i], scene.dials.kernel) : std::vector<Vec3>{});
    }
    const std::vector<std::string> reasons = culledVolumes(scene, corners);
    for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
        const std::string& reason = fields[i].culled.empty() ? reasons[i] : fields[i].culled;
        if (volumes[i] && (reason.empty() || volumesOf == VolumesOf::scene))
            out.volumes.push_back(std::move(*volumes[i]));
        else if (volumes[i] || !fields[i].culled.empty())
            out.culled.emplace_back(scene.volumes[i].name, reason);
    }
    out.memoryLimit = limitBeside(out.volumes, fields, memoryLimit);
    return out;
}

std::vector<std::string> culledVolumes(const Scene& scene,
                                       const std::vector<std::optional<std::vector<Vec3>>>& wsCorners) {
    std::vector<VolumeBox> boxes;
    for (std::size_t i = 0; i < scene.volumes.size(); ++i)
        boxes.push_back({wsCorners[i], lightsOf(scene, scene.volumes[i])});
    std::vector<std::string> reasons = culledVolumes(scene.camera, pictureOf(scene), scene.lights, boxes);
    // Where light scatters more than once, any volume may light or shadow a volume in view. All are then kept, so that
    // a crop equals a part of the whole picture.
    bool couples = false;
    for (std::size_t i = 0; i < reasons.size(); ++i)
        couples = couples || (reasons[i].empty() && scene.volumes[i].medium.scattering == Scattering::full);
    if (couples) std::fill(reasons.begin(), reasons.end(), "");
    return reasons;
}

}  // namespace scrim
