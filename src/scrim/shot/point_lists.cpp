// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/point_lists.h>

namespace scrim {

GridRequest albedoRequest(const SceneVolume& volume, int component) {
    // A ramp makes colours of a scalar.
    return {volume.albedoGrid->grid, volume.albedoGrid->ramp.empty() ? component : GridRequest::kScalar};
}

/// The requests for both fields of velocity component `axis`: values above 0 and values below 0.
std::array<GridRequest, 2> velocityRequests(const Velocity& velocity, int axis) {
    const bool isOne = velocity.grids.size() == 1;
    GridRequest request{velocity.grids[isOne ? 0 : std::size_t(axis)], isOne ? axis : GridRequest::kScalar,
                        GridPart::positive};
    GridRequest below = request;
    below.part = GridPart::negative;
    return {request, below};
}

namespace {

/// The requests for lists of the points of a volume, by what they are for.
struct PointRequests {
    std::array<GridRequest, 3> place;
    GridRequest radius, density;
    std::vector<GridRequest> shadingMask, albedo, emission, emissionMasks, velocity;

    PointRequests(const SceneVolume& volume, bool moving) {
        const auto listOf = [](GridRequest request) { return request.part = GridPart::ofPoints, request; };
        radius = {volume.densityGrid, GridRequest::kScalar, GridPart::places};
        for (int c = 0; c < 3; ++c) place[std::size_t(c)] = {volume.densityGrid, c, GridPart::places};
        density = listOf({volume.densityGrid});
        if (volume.shading.mask) shadingMask = {listOf({volume.shading.mask->grid})};
        for (int c = 0; volume.albedoGrid && c < 3; ++c) albedo.push_back(listOf(albedoRequest(volume, c)));
        for (const Emission& one : volume.emission) {
            emission.push_back(listOf({one.grid}));
            emissionMasks.push_back(one.mask ? listOf({one.mask->grid}) : density);
        }
        for (int axis = 0; moving && volume.velocity && axis < 3; ++axis) {
            const GridRequest request = velocityRequests(*volume.velocity, axis)[0];
            velocity.push_back({request.grid, request.component, GridPart::positiveOfPoints});
            velocity.push_back({request.grid, request.component, GridPart::negativeOfPoints});
        }
    }

    std::vector<GridRequest> all() const {
        std::vector<GridRequest> out(place.begin(), place.end());
        out.insert(out.end(), {radius, density});
        for (const auto* const some : {&shadingMask, &albedo, &emission, &emissionMasks, &velocity})
            out.insert(out.end(), some->begin(), some->end());
        return out;
    }
};

}  // namespace

std::vector<GridRequest> pointRequests(const SceneVolume& volume, bool moving) {
    return PointRequests(volume, moving).all();
}

std::shared_ptr<const PointFields> pointFields(const SceneVolume& volume, bool moving, FieldShader& shader,
                                               const std::function<FieldPointer(const GridRequest&)>& listOf) {
    const PointRequests requests(volume, moving);
    auto out = std::make_shared<PointFields>();
    out->radius = listOf(requests.radius);
    if (out->radius->empty()) return nullptr;
    const FieldPointer mask = requests.shadingMask.empty() ? nullptr : listOf(requests.shadingMask.front());
    if (mask && mask->empty()) return nullptr;  // it is no attribute of these points
    out->density = shader.density(volume, listOf(requests.density), mask);
    for (std::size_t c = 0; c < 3; ++c) {
        out->place[c] = listOf(requests.place[c]);
        if (!requests.albedo.empty()) out->albedo[c] = listOf(requests.albedo[c]);
    }
    for (const GridRequest& request : requests.emission) out->emission.push_back(listOf(request));
    for (const GridRequest& request : requests.emissionMasks) out->emissionMasks.push_back(listOf(request));
    for (const GridRequest& request : requests.velocity) out->velocity.push_back(listOf(request));
    return out;
}

}  // namespace scrim
