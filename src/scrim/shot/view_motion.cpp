// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/view_motion.h>

#include <scrim/shot/derived_fields.h>

#include <algorithm>

#include <glm/matrix.hpp>

namespace scrim {
namespace {

// The velocity's values are those of the moment. A volume with a transfer function moves only as a whole.
void addFlow(const ViewVolume& volume, const SceneVolume& now, const std::vector<FieldPointer>& velocity,
             VolumeMotion& motion) {
    for (int axis = 0; axis < 3; ++axis) {
        motion.most[axis] = velocity[std::size_t(2 * axis)]->maxValue;
        motion.least[axis] = -velocity[std::size_t(2 * axis + 1)]->maxValue;
    }
    const Mat4 assetFromIs = glm::inverse(now.wsFromAsset) * volume.wsFromIs;
    for (const FieldPointer& field : flowFields(*volume.field, assetFromIs, velocity, motion.least))
        motion.flow.push_back({field, volume.wsFromIs, volume.kernel});
}

}  // namespace

bool wantsMotion(const Scene& scene) {
    const std::vector<Layer> layers = scene.output.allLayers();
    return std::find(layers.begin(), layers.end(), Layer::motion) != layers.end();
}

void addMotion(ViewScene& view, const Scene& now, const Scene& next, const Fields& fields) {
    if (!wantsMotion(now)) return;
    view.nextCamera = next.camera;
    std::size_t bytes = 0;
    for (ViewVolume& volume : view.volumes) {
        const auto i = std::size_t(volume.place);
        const SceneVolume &own = now.volumes[i], &later = next.volumes[i];
        const bool ballsFlow = volume.balls && !volume.balls->velocity.empty();
        const bool fieldFlows = !volume.balls && fields[i].velocity.size() == 6 && !volume.field->empty();
        const bool flows = own.velocity && fields[i].onward != 0 && !volume.classified && (ballsFlow || fieldFlows);
        if (!flows && own.wsFromAsset == later.wsFromAsset) continue;
        auto motion = std::make_shared<VolumeMotion>();
        motion->wsNextFromWs = later.wsFromAsset * glm::inverse(own.wsFromAsset);
        if (flows) {
            motion->wsPerVelocity = fields[i].onward * Mat3(later.wsFromAsset);
            if (fieldFlows) addFlow(volume, own, fields[i].velocity, *motion);
        }
        for (const ViewField& field : motion->flow) bytes += field.field->bytes();
        volume.motion = std::move(motion);
    }
    if (view.memoryLimit > 0) view.memoryLimit = view.memoryLimit > bytes ? view.memoryLimit - bytes : 1;
}

}  // namespace scrim
