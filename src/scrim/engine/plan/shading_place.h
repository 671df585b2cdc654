// SPDX-License-Identifier: Apache-2.0
// Where light is added up, at texels of the sheets or at pixels of the picture, and why (the dial `shade`).
#pragma once

#include <scrim/engine/plan/plan.h>

#include <string>

namespace scrim {

struct ShadingPlace {
    bool atPixels = false;
    std::string reason;
};

/// For `plan`, whose groups are known.
ShadingPlace shadingPlace(const ViewScene& scene, const Plan& plan);

}  // namespace scrim
