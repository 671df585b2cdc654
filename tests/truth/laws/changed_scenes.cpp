// SPDX-License-Identifier: Apache-2.0
#include "changed_scenes.h"

#include <scrim/engine/model/sub_lights.h>
#include <scrim/image/sky_parts.h>

#include <algorithm>
#include <cmath>

#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

namespace scrim::test {
namespace {

Rgb swapped(const Rgb& c) {
    return {c.z, c.y, c.x};
}

std::shared_ptr<const Texture> swapped(const std::shared_ptr<const Texture>& texture) {
    if (!texture) return texture;
    const Texture::Level& whole = texture->levels().front();
    Image image{{0, 0, whole.width, whole.height}, whole.rgba};
    return std::make_shared<const Texture>(exchanged(image), texture->aspect() * whole.height / whole.width);
}

std::shared_ptr<const Solids> changedSolids(const std::shared_ptr<const Solids>& solids,
                                            const std::function<void(Solid&)>& change) {
    if (!solids) return solids;
    std::vector<Solid> all = solids->all();
    for (Solid& solid : all) change(solid);
    return std::make_shared<const Solids>(std::move(all));
}

void moveVolume(ViewVolume& volume, const Mat4& ws) {
    volume.wsFromIs = ws * volume.wsFromIs;
    for (ViewField& field : volume.scatter) field.wsFromIs = ws * field.wsFromIs;
    for (ViewEmission& emission : volume.emission) emission.field.wsFromIs = ws * emission.field.wsFromIs;
}

void moveLight(Light& light, double scale, const Mat3& axes, const std::function<Vec3(const Vec3&)>& place,
               const Mat4& ws) {
    light.wsPosition = place(light.wsPosition);
    light.wsDirection = axes * light.wsDirection;
    light.wsUp = axes * light.wsUp;
    if (light.slide) {
        light.slide->width *= scale;
        light.slide->height *= scale;
    }
    if (auto* area = std::get_if<Light::Area>(&light.kind)) {
        area->width *= scale;
        area->height *= scale;
        area->radius *= scale;
        if (!area->surface) return;
        auto mesh = std::make_shared<TriangleMesh>(*area->surface);
        for (Vec3& point : mesh->points) point = transformPoint(ws, point);
        if (glm::determinant(axes) < 0) turnOver(*mesh);
        area->surface = mesh;
        area->surfaceArea *= scale * scale;
        area->wsSurface = {};
        for (const Vec3& point : mesh->points) area->wsSurface.include(point);
        return;
    }
    if (light.distant() || light.dome()) return;
    light.point().radius *= scale;
    if (light.point().decay) light.intensity *= scale * scale;
}

}  // namespace

std::shared_ptr<const Solids> coloured(const std::shared_ptr<const Solids>& solids) {
    return changedSolids(solids, [](Solid& solid) { solid.albedo = Rgb(0.9, 0.5, 0.2); });
}

ViewScene withLights(const ViewScene& scene, const std::vector<std::size_t>& lights) {
    ViewScene out = scene;
    out.lights.clear();
    for (const std::size_t i : lights) out.lights.push_back(scene.lights[i]);
    for (ViewVolume& volume : out.volumes)
        for (std::vector<bool>* list : {&volume.lights, &volume.shadows}) {
            if (list->empty()) continue;
            const std::vector<bool> all = *list;
            list->clear();
            for (const std::size_t i : lights) list->push_back(all[i]);
        }
    return out;
}

ViewScene reversed(const ViewScene& scene) {
    ViewScene out = scene;
    // Volumes keep their names in the scene, which are places.
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) out.volumes[v].place = placeOf(scene, v);
    out.volumeCount = placesOf(scene);
    for (ViewVolume& volume : out.volumes)
        for (std::vector<bool>* list : {&volume.lights, &volume.shadows}) std::reverse(list->begin(), list->end());
    std::reverse(out.volumes.begin(), out.volumes.end());
    std::reverse(out.lights.begin(), out.lights.end());
    return out;
}

ViewScene withoutOtherLight(ViewScene scene) {
    scene.ambient = Rgb(0);
    for (ViewVolume& volume : scene.volumes) volume.emission.clear();
    return scene;
}

void scaleDensity(ViewVolume& volume, double factor) {
    volume.medium.densityScale *= factor;
    for (ViewEmission& emission : volume.emission) emission.color *= factor;
    if (!volume.classified) return;
    Classified look = *volume.classified;
    look.densityScale *= factor;
    volume.classified = std::make_shared<const Classified>(std::move(look));
}

ViewScene movedScene(const ViewScene& scene, double scale, const Mat3& axes, const Vec3& shift) {
    ViewScene out = scene;
    const auto place = [&](const Vec3& p) { return scale * (axes * p) + shift; };
    Mat4 ws(axes * scale);
    ws[3] = glm::dvec4(shift, 1);
    for (ViewVolume& volume : out.volumes) {
        moveVolume(volume, ws);
        if (volume.classified) {
            Classified look = *volume.classified;
            for (auto& [length, factor] : look.gradientRamp) length /= scale;
            volume.classified = std::make_shared<const Classified>(std::move(look));
        }
        scaleDensity(volume, 1 / scale);
    }
    for (Light& light : out.lights) moveLight(light, scale, axes, place, ws);
    out.solids = changedSolids(scene.solids, [&](Solid& solid) { solid.wsFromMesh = ws * solid.wsFromMesh; });
    Camera& camera = out.camera;
    camera.wsPosition = place(camera.wsPosition);
    camera.wsFromCamera = axes * camera.wsFromCamera;
    camera.height *= scale;
    camera.near *= scale;
    if (glm::determinant(axes) < 0) {
        camera.wsFromCamera[0] = -camera.wsFromCamera[0];
        camera.shift.x = -camera.shift.x;
    }
    return out;
}

ViewScene inARow(ViewScene scene) {
    constexpr double kApart = 16;  // voxels, as wide as a volume
    Camera& camera = scene.camera;
    camera.resolution.x *= 2;
    camera.fov = 2 * glm::degrees(std::atan(2 * std::tan(glm::radians(0.5 * camera.fov))));
    scene.region = scene.picture = {0, 0, camera.resolution.x, camera.resolution.y};
    for (const double side : {-kApart, kApart}) {
        ViewVolume copy = scene.volumes.front();
        copy.name += side < 0 ? "left" : "right";
        copy.place = static_cast<int>(scene.volumeCount++);
        Mat4 ws(1.0);
        ws[3] = glm::dvec4(side * voxelUnit(scene) * camera.wsFromCamera[0], 1);
        moveVolume(copy, ws);
        scene.volumes.push_back(std::move(copy));
    }
    return scene;
}

ViewScene exchanged(const ViewScene& scene) {
    ViewScene out = scene;
    out.ambient = swapped(scene.ambient);
    for (ViewVolume& volume : out.volumes) {
        volume.medium.albedo = swapped(volume.medium.albedo);
        volume.medium.extinctionTint = swapped(volume.medium.extinctionTint);
        if (!volume.scatter.empty()) std::swap(volume.scatter[0], volume.scatter[2]);
        for (ViewEmission& emission : volume.emission) emission.color = swapped(emission.color);
        if (!volume.classified) continue;
        Classified look = *volume.classified;
        for (TransferPoint& point : look.transfer) point.color = swapped(point.color);
        look.albedo = swapped(look.albedo);
        volume.classified = std::make_shared<const Classified>(std::move(look));
    }
    for (Light& light : out.lights) {
        light.intensity = swapped(light.intensity);
        if (!light.slide) continue;
        light.slide->image = swapped(light.slide->image);
        if (!light.slide->parts) continue;
        SkyParts parts = *light.slide->parts;
        for (SkySun& sun : parts.suns) {
            sun.light = swapped(sun.light);
            for (Rgb& row : sun.rows) row = swapped(row);
        }
        parts.smooth = swapped(parts.smooth);
        light.slide->parts = std::make_shared<const SkyParts>(std::move(parts));
    }
    out.solids = changedSolids(scene.solids, [](Solid& solid) { solid.albedo = swapped(solid.albedo); });
    return out;
}

ViewScene refined(ViewScene scene) {
    Dials& dials = scene.dials;
    dials.texel /= 2;
    dials.sheetThickness /= 2;
    dials.lightError /= 2;
    dials.footprintSteps = std::min(2 * dials.footprintSteps, 32);
    for (auto* cell : {&dials.lightCell, &dials.lightCellOthers, &dials.scatterCell})
        if (*cell) **cell /= 2;
    if (!dials.scatterCell) dials.scatterCell = kScatterCell / 2;
    for (Light& light : scene.lights)
        if (light.extended()) light.samples = 2 * subLightCount(scene, light);
    return scene;
}

Image mirrored(const Image& image) {
    Image out = image;
    const auto width = std::size_t(image.window.width());
    for (std::size_t row = 0; row < std::size_t(image.window.height()); ++row)
        for (std::size_t x = 0; x < width; ++x)
            std::copy_n(&image.rgba[4 * (row * width + width - 1 - x)], 4, &out.rgba[4 * (row * width + x)]);
    return out;
}

Image exchanged(const Image& image) {
    Image out = image;
    for (std::size_t i = 0; i < out.rgba.size(); i += 4) std::swap(out.rgba[i], out.rgba[i + 2]);
    return out;
}

}  // namespace scrim::test
