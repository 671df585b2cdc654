// SPDX-License-Identifier: Apache-2.0
// A render and its error against the brute-force reference.
#pragma once

#include "support/fields.h"

#include <scrim/verify/verify.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace scrim::test {

/// Relative RMSE of `frame` at `pixels` pixels that show something.
inline Verification verified(const ViewScene& scene, const Frame& frame, int pixels) {
    return summarise(samplePixels(scene, frame.image, pixels, 7));
}

inline double errorOf(const ViewScene& scene, int pixels) {
    return verified(scene, renderScene(scene), pixels).error;
}

/// What green is off at all of these pixels together, relative to the reference.
inline double greenBias(const ViewScene& scene, const Frame& frame, std::vector<VerifiedPixel> pixels) {
    evaluateReferences(scene, pixels);
    double difference = 0, sum = 0;
    for (const VerifiedPixel& p : pixels) {
        difference += pixelOf(frame, p.x, p.y)[1] - p.reference[1];
        sum += p.reference[1];
    }
    return difference / sum;
}

/// The scene with texels and sheets of half the size, footprints of twice as many steps, and a quarter of the cut-off.
inline ViewScene refined(ViewScene scene) {
    scene.dials.texel /= 2;
    scene.dials.sheetThickness /= 2;
    scene.dials.footprintSteps = std::min(2 * scene.dials.footprintSteps, 64);
    scene.dials.opacityCutoff /= 4;
    return scene;
}

/// Agreement with brute force: what the dials are to blame for goes away with them. The error, colour's and alpha's, at
/// half their size must be at most 2^-order of what it was. Both are taken at the same pixels, so that which ones were
/// drawn hardly matters. Below kFloor no order is asked for: the reference itself has steps of half a voxel, and in
/// per-view splatting the raster is the picture's, which does not get finer.
///
/// A wrong picture's error may halve, too, from 30 to 15 %: so at half the dials either error is at most `most`. Smooth
/// media come below 1 %, which is what the preset `standard` promises of them, and half the dials are finer than those
/// it has for an average scene. Where something is sharper than texels (a surface, a hard edge and its shadow) more is
/// left, and the caller says what. A caller asks for about one and a half times what is measured at its pixels, which
/// are the same in every run, but for no less than kFloor.
constexpr double kFloor = 0.002;
inline void expectConvergence(const ViewScene& scene, int pixels, double order, double most,
                              const std::string& name = "") {
    PixelSample sample = samplePixels(scene, renderScene(scene).image, pixels, 7);
    const Verification at = summarise(sample);
    setRendered(sample.pixels, renderScene(refined(scene)).image);
    const Verification finer = summarise(sample);
    EXPECT_EQ(at.pixels, pixels) << name;
    testing::Test::RecordProperty(name + "Errors", fmt::format("{} {}", at.error, finer.error));
    testing::Test::RecordProperty(name + "AlphaErrors", fmt::format("{} {}", at.alphaError, finer.alphaError));
    EXPECT_LE(finer.error, std::max(std::exp2(-order) * at.error, kFloor))
        << name << ": error " << at.error << ", worst pixel " << at.worst;
    EXPECT_LE(finer.alphaError, std::max(std::exp2(-order) * at.alphaError, kFloor))
        << name << ": error of alpha " << at.alphaError;
    EXPECT_LE(finer.error, most) << name << ": error " << at.error << " before, worst pixel " << finer.worst;
    EXPECT_LE(finer.alphaError, most) << name << ": error of alpha " << at.alphaError << " before";
}

}  // namespace scrim::test
