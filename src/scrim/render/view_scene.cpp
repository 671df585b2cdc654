// SPDX-License-Identifier: Apache-2.0
#include <scrim/render/view_scene.h>

#include <algorithm>
#include <limits>

#include <glm/geometric.hpp>

namespace scrim {

std::vector<Vec3> wsCorners(const ViewScene& scene) {
    std::vector<Vec3> corners;
    for (const ViewVolume& volume : scene.volumes) {
        if (volume.field->empty()) continue;
        Bounds is = volume.field->isBounds();
        const double radius = kernelRadius(scene.dials.kernel);
        is.lower -= radius;
        is.upper += radius;
        for (const Vec3& corner : is.corners()) corners.push_back(transformPoint(volume.wsFromIs, corner));
    }
    return corners;
}

double voxelUnit(const ViewScene& scene) {
    double unit = std::numeric_limits<double>::infinity();
    for (const ViewVolume& volume : scene.volumes)
        if (!volume.field->empty())
            for (int axis = 0; axis < 3; ++axis) unit = std::min(unit, glm::length(Vec3(volume.wsFromIs[axis])));
    return unit < std::numeric_limits<double>::infinity() ? unit : 1.0;
}

}  // namespace scrim
