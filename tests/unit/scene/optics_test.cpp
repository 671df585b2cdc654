// SPDX-License-Identifier: Apache-2.0
#include "support/fields.h"

#include <scrim/scene/optics.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// A linear field is reconstructed as it is, within its voxels.
double slope(const Vec3& is) {
    return 10 + 0.2 * is.x - 0.1 * is.y + 0.05 * is.z;
}

ViewVolume slopeVolume() {
    ViewVolume volume;
    volume.field = makeField({-20, -20, -20}, {20, 20, 20}, 0.5, slope);
    volume.wsFromIs = volume.field->wsFromIs;
    volume.medium.densityScale = 3;
    volume.medium.albedo = {0.2, 0.5, 0.9};
    volume.medium.extinctionTint = {1, 0.5, 0.25};
    return volume;
}

TEST(VolumeOptics, OfAMediumIsFieldTimesScaleTimesTint) {
    const ViewVolume volume = slopeVolume();
    FieldSamplers samplers;
    const VolumeOptics optics(volume, Kernel::linear, samplers);
    const Vec3 ws(1.3, -2.1, 3.7);
    const double expected = 3 * slope(ws / 0.5);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(optics.extinction(ws)[c], expected * volume.medium.extinctionTint[c], 1e-5);
        EXPECT_NEAR(optics.scattering(ws)[c], expected * volume.medium.extinctionTint[c] * volume.medium.albedo[c],
                    1e-5);
    }
    EXPECT_NEAR(optics.mostExtinction(ws), expected, 1e-5);
    EXPECT_EQ(optics.extinction({100, 0, 0}), Rgb(0));
    EXPECT_EQ(optics.emission(ws), Rgb(0));
}

TEST(VolumeOptics, OfAClassifiedVolumeIsWhatTheTransferFunctionSays) {
    ViewVolume volume = slopeVolume();
    Classified look;
    look.transfer = {{0, Rgb(1), 0}, {20, Rgb(1), 40}};
    look.densityScale = 0.5;
    volume.classified = std::make_shared<Classified>(look);
    FieldSamplers samplers;
    const VolumeOptics optics(volume, Kernel::linear, samplers);
    const Vec3 ws(1.3, -2.1, 3.7);
    EXPECT_NEAR(optics.extinction(ws).x, 0.5 * 2 * slope(ws / 0.5), 1e-5);
    EXPECT_EQ(optics.mostExtinction(ws), optics.extinction(ws).x);
    // Per world unit, whose edge is two voxels.
    EXPECT_NEAR(glm::distance(optics.gradient(ws), Vec3(0.4, -0.2, 0.1)), 0, 1e-5);
}

TEST(VolumeOptics, AddsUpWhatGlows) {
    ViewVolume volume = slopeVolume();
    const ViewField field{volume.field, volume.wsFromIs};
    volume.emission = {{field, {1, 0, 0}}, {field, {0, 2, 3}}};
    FieldSamplers samplers;
    const VolumeOptics optics(volume, Kernel::linear, samplers);
    EXPECT_EQ(samplers.size(), 1u);  // one for one field
    const Vec3 ws(0.1, 0.2, 0.3);
    EXPECT_NEAR(glm::distance(optics.emission(ws), slope(ws / 0.5) * Rgb(1, 2, 3)), 0, 1e-4);
}

// At x it is what the field holds at x - path * velocity.
TEST(VolumeOptics, OfAMovedVolumeIsWhatWasUpstream) {
    ViewVolume volume = slopeVolume();
    auto velocity = std::make_shared<ViewVelocity>();
    const auto constant = [](double v) {
        return makeField({-20, -20, -20}, {20, 20, 20}, 0.5, [v](const Vec3&) { return v; });
    };
    for (const double part : {2.0, 0.0, 0.0, 4.0, 0.0, 0.0}) {  // (2, -4, 0)
        const auto field = constant(part);
        velocity->parts.push_back({field, field->wsFromIs});
    }
    velocity->wsPath = Mat3(0.25);
    volume.velocity = velocity;
    FieldSamplers samplers;
    const VolumeOptics optics(volume, Kernel::linear, samplers);
    const Vec3 ws(1, 2, 3), upstream = ws - 0.25 * Vec3(2, -4, 0);
    EXPECT_NEAR(optics.density(ws), slope(upstream / 0.5), 1e-5);
    EXPECT_NEAR(glm::distance(optics.gradient(ws), Vec3(0.4, -0.2, 0.1)), 0, 1e-5);
    EXPECT_LT(optics.evenAlong(ws, {1, 0, 0}, 0.1), 0);
}

// A promise that a march relies on: within that distance nothing is.
TEST(VolumeOptics, IsEmptyAsFarAsItSays) {
    ViewVolume volume;
    volume.field = boxField({-3, -3, -3}, {4, 4, 4}, 0.5);
    volume.wsFromIs = volume.field->wsFromIs;
    FieldSamplers samplers;
    const VolumeOptics optics(volume, Kernel::linear, samplers);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-12, 12), part(-1, 1);
    int empty = 0;
    for (int i = 0; i < 5000; ++i) {
        const Vec3 ws(place(random), place(random), place(random));
        const double distance = optics.emptyDistance(ws);
        if (distance == 0) continue;
        ++empty;
        for (int k = 0; k < 10; ++k) {
            const Vec3 d(part(random), part(random), part(random));
            ASSERT_EQ(optics.density(ws + distance * d / std::max(1.0, glm::length(d))), 0);
        }
    }
    EXPECT_GT(empty, 2000);
    EXPECT_EQ(optics.emptyDistance(Vec3(0)), 0);
}

}  // namespace
}  // namespace scrim::test
