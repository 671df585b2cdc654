// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/point_balls.h>

#include <scrim/shot/derived_fields.h>
#include <scrim/shot/shaded_field.h>
#include <scrim/volume/grid_edit.h>

#include <utility>

namespace scrim {

bool canSeeBalls(const SceneVolume& volume) {
    if (volume.classified || volume.displacement || volume.shading.noise) return false;
    if (!volume.edit) return true;
    const GridEdit& edit = *volume.edit;
    return edit.points.sharp.value_or(true) && edit.grids.empty() && edit.resample == 1 && edit.programs.empty();
}

std::shared_ptr<const ViewBalls> ballsOf(const SceneVolume& volume, const PointFields& points) {
    if (points.radius->empty()) return nullptr;
    auto out = std::make_shared<ViewBalls>();
    out->place = points.place;
    out->radius = points.radius;
    out->discs = volume.edit && volume.edit->points.discs;
    out->clip = volume.clip;
    out->velocity = points.velocity;
    out->density = points.density;
    if (!volume.ramp.empty()) out->density = withRamp(*out->density, volume.ramp);
    if (volume.albedoGrid && !volume.holdout && !out->density->empty() && !points.albedo[0]->empty())
        out->scatter = scatteringFields(*out->density, points.albedo, *volume.albedoGrid);
    for (std::size_t i = 0; i < points.emission.size() && !volume.holdout; ++i) {
        if (points.emission[i]->empty()) continue;
        for (const EmittedField& emitted : emittedFields(points.emission[i], volume.emission[i])) {
            const auto& mask = volume.emission[i].mask;
            const FieldPointer own = mask ? maskedField(emitted.field, *mask, points.emissionMasks[i]) : emitted.field;
            out->emission.push_back({{own}, emitted.color});
        }
    }
    return out;
}

std::shared_ptr<const ViewBalls> movedBalls(const ViewBalls& balls, const std::array<const SceneVolume*, 2>& at,
                                            const std::array<double, 2>& time) {
    auto out = std::make_shared<ViewBalls>(balls);
    for (std::size_t end = 0; end < 2; ++end) out->wsFromAsset[end] = at[end]->wsFromAsset;
    out->time = time;
    return out;
}

}  // namespace scrim
