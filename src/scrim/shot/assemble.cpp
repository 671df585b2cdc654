// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/assemble.h>

#include <scrim/base/error.h>
#include <scrim/shot/derived_fields.h>
#include <scrim/shot/point_balls.h>
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

// The number of pixels that the shortest edge of a voxel covers where the volume comes closest to the camera.
double voxelInPixels(const Camera& camera, const SparseField& field, const Mat4& wsFromIs) {
    const double edge = smallest(voxelEdges(wsFromIs));
    const Bounds ws = transformed(wsFromIs, field.isBounds());
    const double distance = ws.distance(camera.wsPosition);
    return edge / std::max(pixelAt(camera, distance), 1e-300);
}

// Halves the field's resolution along the short edges of its voxels as long as these stay below `lod` pixels.
std::shared_ptr<const SparseField> withLevelOfDetail(const Camera& camera, double lod, const Mat4& wsFromAsset,
                                                     std::shared_ptr<const SparseField> field, CoarserLevels* levels) {
    if (field->empty()) return field;
    CoarserLevels own;
    for (;;) {
        const Mat4 wsFromIs = wsFromAsset * field->wsFromIs;
        if (2 * voxelInPixels(camera, *field, wsFromIs) > lod || field->activeVoxels <= 1) break;
        std::shared_ptr<const SparseField> coarser =
            (levels != nullptr ? *levels : own).below(field, shortAxes(wsFromIs));
        if (coarser->empty()) break;  // means of the smallest values count as 0
        field = std::move(coarser);
    }
    return field;
}

// Whether each light of the scene is among those with these names; empty: all are.
std::vector<bool> lightsNamed(const Scene& scene, const std::optional<std::vector<std::string>>& names) {
    std::vector<bool> among;
    if (!names) return among;
    for (const Light& light : scene.lights)
        among.push_back(std::find(names->begin(), names->end(), light.name) != names->end());
    return among;
}

// The memory of the fields that were derived from those in `fields`.
std::size_t derivedBytes(const std::vector<ViewVolume>& volumes, const std::vector<VolumeFields>& fields) {
    std::set<FieldPointer> given, made;
    for (const VolumeFields& of : fields) {
        given.insert(of.density);
        given.insert(of.finer);
        given.insert(of.emission.begin(), of.emission.end());
        if (!of.points) continue;
        for (const FieldPointer& list : of.points->all()) given.insert(list);
    }
    std::size_t bytes = 0;
    const auto add = [&](const FieldPointer& field) {
        if (!given.contains(field) && made.insert(field).second) bytes += field->bytes();
    };
    for (const ViewVolume& volume : volumes) {
        add(volume.field);
        for (const ViewField& scatter : volume.scatter) add(scatter.field);
        for (const ViewEmission& emission : volume.emission) add(emission.field.field);
        if (!volume.balls) continue;
        add(volume.balls->density);
        for (const FieldPointer& scatter : volume.balls->scatter) add(scatter);
        for (const ViewEmission& emission : volume.balls->emission) add(emission.field.field);
    }
    return bytes;
}

std::optional<Kernel> kernelOf(GridInterpolation interpolation) {
    if (interpolation == GridInterpolation::automatic) return std::nullopt;
    return interpolation == GridInterpolation::smooth ? Kernel::bspline : Kernel::linear;
}

// The fields of a volume's detail, which is a volume of its own. Only one of both glows.
VolumeFields detailOf(VolumeFields fields) {
    fields.density = fields.finer;
    fields.emission.clear();
    return fields;
}

// A volume with all fields that are derived from its grids; no value where all of it is empty.
// `view` is told what was left out of it.
std::optional<ViewVolume> viewOf(const Scene& scene, const SceneVolume& volume, const VolumeFields& fields,
                                 VolumesOf volumesOf, CoarserLevels* levels, ViewScene& view) {
    const auto viewed = [&](FieldPointer field) {
        if (scene.dials.lod > 0)
            field = withLevelOfDetail(scene.camera, *scene.dials.lod, volume.wsFromAsset, std::move(field), levels);
        return ViewField{std::move(field), Mat4(1.0), kernelOf(volume.interpolation)};
    };
    ViewVolume out;
    out.name = volume.name;
    out.kernel = kernelOf(volume.interpolation);
    out.lights = lightsNamed(scene, volume.lights);
    out.shadows = lightsNamed(scene, volume.shadows);
    if (std::count(out.shadows.begin(), out.shadows.end(), false) == 0) out.shadows.clear();
    out.holdout = volume.holdout;
    FieldPointer density = fields.density ? fields.density : std::make_shared<SparseField>();
    if (!volume.ramp.empty() && !fields.finer) density = withRamp(*density, volume.ramp);
    // What is classified is cut where it is seen, because its values must not change.
    const auto cut = [&](const FieldPointer& field) {
        return volume.classified || volume.clip.empty() ? field : clippedField(field, volume.clip);
    };
    density = cut(density);
    out.balls = fields.points ? ballsOf(volume, *fields.points) : nullptr;
    if (volumesOf == VolumesOf::picture && !volume.classified && fields.velocity.empty() && !out.balls) {
        Medium medium = volume.medium;
        medium.densityScale = volume.densityScale;
        const Mat3 edges = Mat3(volume.wsFromAsset) * Mat3(density->wsFromIs);
        const double edge = std::max({glm::length(edges[0]), glm::length(edges[1]), glm::length(edges[2])});
        const FieldPointer whole = density;
        density = withoutStrays(whole, medium.mostExtinction() * edge);
        if (density != whole)
            view.culled.emplace_back(volume.name,
                                     fmt::format("{} faint voxels of it, far from all others, take at most 0.01 % of "
                                                 "the light",
                                                 whole->activeVoxels - density->activeVoxels));
    }
    if (!volume.classified) {
        for (std::size_t i = 0; i < fields.emission.size(); ++i)
            if (fields.emission[i] && !fields.emission[i]->empty())
                for (const EmittedField& emitted : emittedFields(fields.emission[i], volume.emission[i])) {
                    const auto& mask = volume.emission[i].mask;
                    const bool masked = mask && i < fields.emissionMasks.size() && fields.emissionMasks[i];
                    const FieldPointer own =
                        masked ? maskedField(emitted.field, *mask, fields.emissionMasks[i]) : emitted.field;
                    const bool ofBalls = out.balls && !fields.points->emission[i]->empty();
                    out.emission.push_back({viewed(cut(own)), emitted.color, ofBalls});
                }
        if (volume.albedoGrid && fields.albedo[0] && !density->empty())
            for (const FieldPointer& channel : scatteringFields(*density, fields.albedo, *volume.albedoGrid))
                out.scatter.push_back(viewed(channel));
    }
    if (density->empty() && out.emission.empty()) return std::nullopt;
    out.field = viewed(density).field;
    place(volume, fields, out);
    return out;
}

}  // namespace

std::vector<FieldPointer> PointFields::all() const {
    std::vector<FieldPointer> out{radius, density};
    out.insert(out.end(), place.begin(), place.end());
    out.insert(out.end(), albedo.begin(), albedo.end());
    for (const auto* const lists : {&emission, &emissionMasks, &velocity})
        out.insert(out.end(), lists->begin(), lists->end());
    return out;
}

std::size_t limitBeside(std::size_t limit, std::size_t bytes) {
    if (limit == 0) return 0;
    if (bytes >= limit)
        throw Error(
            ErrorKind::memory,
            fmt::format("the data made from the volumes' grids needs {}, more than the {} that the memory limit leaves",
                        bytesText(bytes), bytesText(limit)));
    return limit - bytes;
}

PixelWindow pictureOf(const Scene& scene) {
    const Int2 size = scene.camera.resolution;
    return {-scene.overscan, -scene.overscan, size.x + scene.overscan, size.y + scene.overscan};
}

void place(const SceneVolume& volume, const VolumeFields& fields, ViewVolume& out) {
    const auto placed = [&](const SparseField& field) { return volume.wsFromAsset * field.wsFromIs; };
    out.wsFromIs = placed(*out.field);
    for (ViewField& field : out.scatter) field.wsFromIs = placed(*field.field);
    for (ViewEmission& emission : out.emission) emission.field.wsFromIs = placed(*emission.field.field);
    out.medium = volume.medium;
    out.medium.densityScale = volume.densityScale;
    if (volume.classified) {
        Classified look = *volume.classified;
        look.densityScale = volume.densityScale;
        if (look.perVoxel && fields.density)
            look.densityScale /= std::cbrt(std::abs(glm::determinant(Mat3(placed(*fields.density)))));
        out.classified = std::make_shared<const Classified>(std::move(look));
    }
    out.wsClip.clear();
    for (const HalfSpace& face : volume.clip)
        if (volume.classified) out.wsClip.push_back(transformed(face, glm::inverse(volume.wsFromAsset)));
    if (out.balls) {
        auto balls = std::make_shared<ViewBalls>(*out.balls);
        balls->wsFromAsset = {volume.wsFromAsset, volume.wsFromAsset};
        balls->time = {fields.time, fields.time};
        out.balls = std::move(balls);
    }
    out.velocity = nullptr;
    if (fields.velocity.empty() || fields.time == 0) return;
    auto velocity = std::make_shared<ViewVelocity>();
    for (const FieldPointer& part : fields.velocity) velocity->parts.push_back({part, placed(*part)});
    velocity->wsPath = fields.time * Mat3(volume.wsFromAsset);
    out.velocity = std::move(velocity);
}

void cull(const Scene& scene, ViewScene& view) {
    std::vector<std::optional<std::vector<Vec3>>> corners(scene.volumes.size(), std::vector<Vec3>{});
    for (const ViewVolume& volume : view.volumes)
        for (const Vec3& corner : wsCorners(volume, scene.dials.kernel))
            corners[std::size_t(volume.place)]->push_back(corner);
    std::vector<std::string> reasons = culledVolumes(scene, corners);
    // Beside a scan even such a volume would change the sheets.
    for (std::size_t v = 0; v < reasons.size(); ++v)
        if (reasons[v].empty() && scene.volumes[v].densityScale == 0 && scene.volumes[v].emission.empty())
            reasons[v] = "its density is 0";
    int last = -1;  // of a volume and its detail one is reported
    std::erase_if(view.volumes, [&](const ViewVolume& volume) {
        const std::string& reason = reasons[std::size_t(volume.place)];
        if (!reason.empty() && last != volume.place) view.culled.emplace_back(volume.name, reason);
        last = volume.place;
        return !reason.empty();
    });
}

// Light that scatters more than once is attenuated by all volumes together.
void checkShadows(const Scene& scene, const ViewScene& view) {
    const auto full = std::find_if(view.volumes.begin(), view.volumes.end(), scattersFully);
    const auto apart = std::find_if(view.volumes.begin(), view.volumes.end(),
                                    [](const ViewVolume& volume) { return !volume.shadows.empty(); });
    if (full != view.volumes.end() && apart != view.volumes.end())
        throw Error(ErrorKind::input,
                    fmt::format("{}: volume '{}' does not cast shadows in all lights; with scattering "
                                "= \"full\" in volume '{}' it must",
                                scene.volumes[std::size_t(apart->place)].where, apart->name, full->name));
}

ViewScene assemble(const Scene& scene, const std::vector<VolumeFields>& fields, const std::optional<PixelWindow>& crop,
                   std::size_t memoryLimit, VolumesOf volumesOf, CoarserLevels* levels) {
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
    out.layers = scene.output.allLayers();
    // The direct light is what is left of the picture without the indirect one.
    if (wants(out, Layer::direct) && !wants(out, Layer::indirect)) out.layers.push_back(Layer::indirect);
    if (wants(out, Layer::volume) && !wants(out, Layer::cryptomatte)) out.layers.push_back(Layer::cryptomatte);
    out.depths = scene.output.holdout.picture;
    if (scene.shutter) out.shutter = ViewShutter{scene.shutter->open, scene.shutter->close};
    if (scene.lens) out.lens = ViewLens{*scene.lens};
    out.lines = scene.lines;
    out.volumeCount = scene.volumes.size();
    for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
        const std::size_t before = out.volumes.size();
        const auto add = [&](const VolumeFields& of) {
            std::optional<ViewVolume> volume = viewOf(scene, scene.volumes[i], of, volumesOf, levels, out);
            if (!volume) return;
            volume->place = static_cast<int>(i);
            out.volumes.push_back(std::move(*volume));
        };
        const bool culled = !fields[i].culled.empty();
        if (!culled || volumesOf == VolumesOf::scene) add(fields[i]);
        if (fields[i].finer) add(detailOf(fields[i]));
        if (culled && out.volumes.size() == before) out.culled.emplace_back(scene.volumes[i].name, fields[i].culled);
    }
    checkShadows(scene, out);
    if (volumesOf == VolumesOf::picture) cull(scene, out);
    out.memoryLimit = limitBeside(memoryLimit, derivedBytes(out.volumes, fields));
    return out;
}

std::vector<std::string> culledVolumes(const Scene& scene,
                                       const std::vector<std::optional<std::vector<Vec3>>>& wsCorners) {
    std::vector<VolumeBox> boxes;
    for (std::size_t i = 0; i < scene.volumes.size(); ++i)
        boxes.push_back(
            {wsCorners[i], lightsNamed(scene, scene.volumes[i].lights), lightsNamed(scene, scene.volumes[i].shadows)});
    std::vector<std::string> reasons = culledVolumes(scene.camera, pictureOf(scene), scene.lights, boxes);
    // Where light scatters more than once, any volume may light or shadow a volume in view. All are
    // then kept, so that a crop equals a part of the whole picture.
    bool couples = false;
    for (std::size_t i = 0; i < reasons.size(); ++i)
        couples = couples || (reasons[i].empty() && scene.volumes[i].medium.scattering == Scattering::full);
    if (couples) std::fill(reasons.begin(), reasons.end(), "");
    return reasons;
}

}  // namespace scrim
