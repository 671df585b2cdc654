// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/expected_time.h>

namespace scrim {

double expectedSeconds(const ViewScene& scene, const Plan& plan, int threads) {
    // Seconds on one thread, fitted to a study of smoke (scrim study, noise:350). A footprint reaches about three voxels
    // beyond its slab in u and v, so it has that many texels, squared; of sheets and pictures about a third is not empty.
    constexpr double kFootprint = 2.0e-8, kFootprintTexel = 1.2e-9, kReach = 4;
    constexpr double kTexel = 2e-9, kLightSample = 1e-9, kPixelSheet = 1.5e-9, kStart = 5e-3;
    const double across = kReach / scene.dials.texel;
    const double views = plan.perView && !plan.groups.empty() ? 1.0 + double(plan.groups.front().lights.size()) : 1.0;
    const double work = plan.work.footprints * views * (kFootprint + kFootprintTexel * across * across) +
                        plan.work.texels * kTexel + plan.work.lightSamples * kLightSample +
                        plan.work.pixelSheets * kPixelSheet * (plan.shadeAtPixels ? 3 : 1);
    return kStart + work / threads;
}

}  // namespace scrim
