// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/lamps/cell_light.h>

#include <algorithm>

namespace scrim {

void VolumeLight::sample(const Vec3& ws, Real (&rgb)[3]) const {
    for (Real& c : rgb) c = 0;
    if (field) field->sample(ws, rgb);
    for (const auto& lamp : lamps) lamp->addTo(ws, rgb);
    for (const auto& area : areas) area->addTo(ws, rgb);
}

void VolumeLight::lookUp(const SamplePlane& plane, const SampleTile& samples, const Real* extinction,
                         Real* const rgb[3], const Real* nearer) const {
    if (field)
        field->lookUp(plane, samples, extinction, rgb, nearer);
    else
        for (int c = 0; c < 3; ++c) std::fill_n(rgb[c], kTileSize, Real(0));
    if (lamps.empty() && areas.empty()) return;
    Bounds place;
    for (int k = 0; k < kTileSize; ++k)
        if (extinction[k] != 0) place.include(plane.wsSample(samples, k));
    for (const auto& lamp : lamps)
        if (lamp->reaches(place)) lamp->addTo(plane, samples, extinction, rgb);
    for (const auto& area : areas)
        if (!place.empty() && area->reaches(place)) area->addTo(plane, samples, extinction, rgb, nearer);
}

}  // namespace scrim
