// SPDX-License-Identifier: Apache-2.0
// Which lights and volumes a picture has no use for, before anything is planned around them. Judged by the whole
// picture and not by a crop, whose pixels must come out as in the whole.
#pragma once

#include <scrim/scene/view_scene.h>

#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// For each light why it contributes nothing; empty where it may.
std::vector<std::string> uselessLights(const ViewScene& scene);

/// A volume that is perhaps not loaded yet.
struct VolumeBox {
    /// Eight a field, in the order of Bounds::corners(); none: nothing is there; no vector: nobody knows.
    std::optional<std::vector<Vec3>> wsCorners;
    std::vector<bool> lights;  ///< as ViewVolume has them
};

/// For each volume why it does not matter: out of view, and throwing no shadow on what is in view. Empty where it may.
std::vector<std::string> uselessVolumes(const Camera& camera, const PixelWindow& picture,
                                        const std::vector<Light>& lights, const std::vector<VolumeBox>& volumes);

}  // namespace scrim
