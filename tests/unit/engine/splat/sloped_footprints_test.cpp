// SPDX-License-Identifier: Apache-2.0
// Footprints between the steps of a table.
#include <scrim/engine/splat/splatter.h>

#include "support/fields.h"

#include <gtest/gtest.h>

#include <cmath>

namespace scrim::test {
namespace {

constexpr int kTexels = 48, kSheets = 30;

std::vector<float> splatted(const SparseField& field, const Mat4& tsFromIs, int steps) {
    PlaneStack planes(kSheets, kTexels, kTexels, 1);
    for (int p = 0; p < kSheets; ++p) planes.begin(p);
    FieldSplatter(field, tsFromIs, Kernel::bspline, steps, 1).splat(0, kSheets, planes, 0);
    std::vector<float> all;
    for (int p = 0; p < kSheets; ++p) {
        planes.finish(p);
        all.insert(all.end(), planes.plane(p), planes.plane(p) + kTexels * kTexels);
    }
    return all;
}

double rms(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(a[i] - b[i], 2);
    return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(SlopedFootprints, ErrInSecondOrderOfTheStep) {
    const auto field = smokeField(9);
    Mat4 tsFromIs(1.0);
    tsFromIs[0] = {0.91, 0.31, -0.21, 0};
    tsFromIs[1] = {-0.25, 0.92, 0.25, 0};
    tsFromIs[2] = {0.25, -0.2, 0.93, 0};
    tsFromIs[3] = {23.3, 22.6, 15.2, 1};
    const auto truth = splatted(*field, tsFromIs, 64);
    const double coarse = rms(splatted(*field, tsFromIs, 8), truth);
    const double finer = rms(splatted(*field, tsFromIs, 16), truth);
    EXPECT_NEAR(std::log2(coarse / finer), 2, 0.4);
}

TEST(SlopedFootprints, LeaveLatticesOnTheStepsAsTheyAre) {
    const auto field = smokeField(9);
    Mat4 tsFromIs(1.0);
    tsFromIs[3] = {24, 24, 14, 1};
    const auto few = splatted(*field, tsFromIs, 2), many = splatted(*field, tsFromIs, 64);
    for (std::size_t i = 0; i < few.size(); ++i) ASSERT_NEAR(few[i], many[i], 1e-6);
}

}  // namespace
}  // namespace scrim::test
