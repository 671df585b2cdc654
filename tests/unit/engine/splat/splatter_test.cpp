// SPDX-License-Identifier: Apache-2.0
// A splatted field against its definition: the mean over each sheet of the sum of all kernels, at texel centres.
//
// What may differ is the quantisation of positions. A voxel is off by at most half a step an axis, and the error of
// a texel is the sum over the voxels it sees of value times the footprint's gradient times that: it falls with the
// first power of 1 / steps, whatever the field.
#include "support/fields.h"

#include <scrim/engine/splat/splatter.h>
#include <scrim/volume/field_sampler.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <string>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

namespace scrim::test {
namespace {

Mat3 rotated(double angle, const Vec3& axis) {
    return Mat3(glm::rotate(Mat4(1.0), angle, glm::normalize(axis)));
}
Mat3 scaled(double u, double v, double n) {
    return Mat3(u, 0, 0, 0, v, 0, 0, 0, n);
}

// A field's place in texel space, with room to spare on every side, at odd fractions.
struct Stage {
    Mat4 tsFromIs;
    int width, height, sheets;
};

Stage stageFor(const SparseField& field, const Mat3& linear, Kernel kernel) {
    Stage stage{Mat4(linear), 0, 0, 0};
    Bounds ts = transformed(stage.tsFromIs, field.isBounds());
    for (int axis = 0; axis < 3; ++axis) {
        const double reach = kernelExtent(kernel, {linear[0][axis], linear[1][axis], linear[2][axis]});
        ts.lower[axis] -= reach + 3.3;
        ts.upper[axis] += reach + 5.7;
    }
    stage.tsFromIs[3] = glm::dvec4(-ts.lower + Vec3(0.123, 0.456, 0.789), 1);
    const auto tiles = [](double size) { return (static_cast<int>(std::ceil(size)) / kTileEdge + 1) * kTileEdge; };
    stage.width = tiles(ts.size().x);
    stage.height = tiles(ts.size().y);
    stage.sheets = static_cast<int>(std::ceil(ts.size().z)) + 1;
    return stage;
}

struct Splatted {
    PlaneStack planes;
    std::uint64_t footprints = 0;

    float at(int x, int y, int n) const { return planes.plane(n)[y * planes.rowStride() + x]; }
};

// Splats all sheets in calls of `sheetsACall`, each into its own planes.
Splatted splat(const SparseField& field, const Stage& stage, Kernel kernel, int steps, float scale = 1,
               int sheetsACall = 1000) {
    Splatted out{PlaneStack(stage.sheets, stage.width, stage.height, 1), {}};
    const FieldSplatter splatter(field, stage.tsFromIs, kernel, steps, scale);
    for (int p = 0; p < stage.sheets; ++p) out.planes.begin(p);
    for (int first = 0; first < stage.sheets; first += sheetsACall)
        out.footprints += splatter.splat(first, std::min(first + sheetsACall, stage.sheets), out.planes, first);
    for (int p = 0; p < stage.sheets; ++p) out.planes.finish(p);
    return out;
}

// Mean of the reconstructed field over sheet n at texel (x, y): two Gauss points in each of 16 steps.
double slabMean(const FieldSampler& probe, const Mat4& isFromTs, int x, int y, int n) {
    constexpr int kSteps = 16;
    const double gauss = 0.5 / std::sqrt(3.0);
    double sum = 0;
    for (int i = 0; i < kSteps; ++i)
        for (const double side : {-gauss, gauss})
            sum += probe.value(transformPoint(isFromTs, Vec3(x, y, n + (i + 0.5 + side) / kSteps)));
    return sum / (2 * kSteps);
}

// White noise in [0, 1], a third of it empty: the hardest field there is for misplaced voxels.
std::shared_ptr<SparseField> noiseField() {
    auto random = std::make_shared<std::mt19937>(23);
    return makeField({-6, -9, 2}, {7, 8, 15}, 1, [random](const Vec3&) {
        return std::max(0.0, std::uniform_real_distribution<double>(-0.5, 1)(*random));
    });
}

// RMS difference to the brute force at 400 random texels within the field's bounds.
double rmsError(const SparseField& field, const Stage& stage, Kernel kernel, int steps) {
    const Splatted sheets = splat(field, stage, kernel, steps);
    const FieldSampler probe(field, kernel);
    const Mat4 isFromTs = glm::inverse(stage.tsFromIs);
    std::mt19937 random(29);
    const auto below = [&](int count) { return static_cast<int>(random() % static_cast<unsigned>(count)); };
    const Bounds is = field.isBounds();
    double squares = 0;
    int count = 0;
    while (count < 400) {
        const int x = below(stage.width), y = below(stage.height), n = below(stage.sheets);
        if (!is.contains(transformPoint(isFromTs, Vec3(x, y, n + 0.5)))) continue;
        const double d = sheets.at(x, y, n) - slabMean(probe, isFromTs, x, y, n);
        squares += d * d;
        ++count;
    }
    return std::sqrt(squares / count);
}

struct Case {
    std::string name;
    Mat3 linear;
};
void PrintTo(const Case& c, std::ostream* out) {
    *out << c.name;
}

class SplattedSheets : public testing::TestWithParam<std::tuple<Kernel, Case>> {};

TEST_P(SplattedSheets, ApproachTheSlabMeansOfTheFieldWithTheirSteps) {
    const auto& [kernel, shape] = GetParam();
    const auto field = noiseField();
    const Stage stage = stageFor(*field, shape.linear, kernel);
    const double coarse = rmsError(*field, stage, kernel, 8);
    const double fine = rmsError(*field, stage, kernel, 32);
    // A texel sees the weight of about 2^3 voxels of RMS value 0.4, whose positions are off by 0.29 / steps (RMS of
    // a rounding) along three axes, times footprint gradients of about 0.15: 0.15 / steps. Measured: 0.13 (linear),
    // 0.10 (gaussian), 0.06 (bspline); more where 0.75 of the steps were found to be enough.
    EXPECT_LT(coarse, 0.25 / 8);
    EXPECT_LT(fine, 0.25 / 32);
    // Four times finer at first order; steps are powers of two, so that the ratio itself is rounded.
    EXPECT_GT(coarse / fine, 2.8) << coarse << " " << fine;
}

INSTANTIATE_TEST_SUITE_P(
    EveryShape, SplattedSheets,
    testing::Combine(testing::Values(Kernel::linear, Kernel::gaussian, Kernel::bspline),
                     testing::Values(Case{"rotated", rotated(0.7, {1, 2, 3})},
                                     Case{"rotatedThin", scaled(1, 1, 2) * rotated(-2.1, {3, -1, 0.5})},
                                     Case{"fineTexels", scaled(2, 2, 1) * rotated(1.1, {0, 1, 2})},
                                     Case{"sheared", Mat3(1, 0.3, -0.2, 0, 0.9, 0.5, 0.4, 0, 1.1)},
                                     Case{"anisotropic", rotated(0.4, {0, 1, 1}) * scaled(1.4, 0.7, 0.9)},
                                     Case{"mirrored", rotated(1.2, {1, 0, 1}) * scaled(-1, 1, 1)})),
    [](const auto& test) { return test::nameOf(std::get<0>(test.param)) + "_" + std::get<1>(test.param).name; });

struct Deviation {
    double most = 0, rms = 0, mean = 0;
};

// Deviation from `expected(is)` inside the field: where the whole kernel, and a slab, see filled voxels.
template <class Expected>
Deviation deviationInside(const SparseField& field, const Stage& stage, Kernel kernel, int steps,
                          const Expected& expected) {
    const Splatted sheets = splat(field, stage, kernel, steps);
    const Mat4 isFromTs = glm::inverse(stage.tsFromIs);
    Bounds is = field.isBounds();
    const double margin = kernelRadius(kernel) + 1.5;
    is.lower += margin;
    is.upper -= margin;
    Deviation out;
    int count = 0;
    for (int n = 0; n < stage.sheets; ++n)
        for (int y = 0; y < stage.height; ++y)
            for (int x = 0; x < stage.width; ++x) {
                const Vec3 p = transformPoint(isFromTs, Vec3(x, y, n + 0.5));
                if (!is.contains(p)) continue;
                const double d = sheets.at(x, y, n) - expected(p);
                out.most = std::max(out.most, std::abs(d));
                out.rms += d * d;
                out.mean += d;
                ++count;
            }
    EXPECT_GT(count, 1000);
    out.rms = std::sqrt(out.rms / count);
    out.mean /= count;
    return out;
}

// A constant field hides no error of position behind its values: what is left is the footprints' ripple. With
// positions off by at most half a step an axis, and voxels' gradients of at most 2 an axis in sum, it is below
// 3 / steps even if all roundings conspired; they reach a third of that, 0.13 / steps in the RMS. Rounding to the
// nearest leaves no bias.
TEST(ConstantField, RipplesLessWithEveryDoublingOfTheSteps) {
    const auto field = boxField({0, 0, 0}, {23, 23, 23});
    const Stage stage = stageFor(*field, rotated(0.7, {1, 2, 3}), Kernel::linear);
    double before = 1;
    for (const int steps : {8, 16, 32, 64}) {
        const Deviation ripple = deviationInside(*field, stage, Kernel::linear, steps, [](const Vec3&) { return 1.0; });
        RecordProperty("rms" + std::to_string(steps), std::to_string(ripple.rms));
        EXPECT_LT(ripple.most, 1.5 / steps) << steps << " steps";
        EXPECT_LT(ripple.rms, 0.4 / steps) << steps << " steps";
        EXPECT_LT(ripple.rms, 0.6 * before) << steps << " steps";
        EXPECT_LT(std::abs(ripple.mean), 1e-3) << steps << " steps";
        before = ripple.rms;
    }
}

// Lattices that fall on the steps are not quantised at all: rounding only.
TEST(ConstantField, OnAnAlignedLatticeIsExact) {
    for (const Kernel kernel : {Kernel::linear, Kernel::bspline}) {
        const auto field = boxField({0, 0, 0}, {23, 23, 23});
        Stage stage = stageFor(*field, Mat3(1.0), kernel);
        stage.tsFromIs[3] = glm::dvec4(glm::round(Vec3(stage.tsFromIs[3])) + Vec3(0.25, 0.5, 0.125), 1);
        const Deviation d = deviationInside(*field, stage, kernel, 16, [](const Vec3&) { return 1.0; });
        EXPECT_LT(d.most, 2e-5) << test::nameOf(kernel);
    }
}

// The linear kernel reproduces linear functions, and their mean over a slab is their value in its middle. Single
// texels ripple with their value (up to 2.5) as a constant field does; that the ramp has not moved, not even by the
// half step that rounding down would mean (0.0014), shows in the mean of rotated ones, whose roundings differ.
TEST(LinearRamp, StaysALinearRamp) {
    const Vec3 slope(0.08, -0.03, 0.05);
    const auto ramp = [&](const Vec3& is) { return 0.7 + glm::dot(slope, is); };
    const auto field = makeField({0, 0, 0}, {23, 23, 23}, 1, ramp);
    for (const Mat3& linear : {Mat3(1.0), rotated(0.7, {1, 2, 3}), scaled(1, 1, 0.5) * rotated(-1.3, {2, 0, 1})}) {
        const Stage stage = stageFor(*field, linear, Kernel::linear);
        const Deviation d = deviationInside(*field, stage, Kernel::linear, 32, ramp);
        EXPECT_LT(d.most, 2.5 * 1.5 / 32);
        EXPECT_LT(d.rms, 2.5 * 0.4 / 32);
        if (linear != Mat3(1.0)) {
            EXPECT_LT(std::abs(d.mean), 3e-4);
        }
    }
}

TEST(SplattedPlanes, AreTheSameBitsInOneCallOrSeveral) {
    const auto field = noiseField();
    for (const Kernel kernel : {Kernel::linear, Kernel::bspline}) {
        const Stage stage = stageFor(*field, rotated(0.9, {3, 1, 2}), kernel);
        const Splatted whole = splat(*field, stage, kernel, 16);
        for (const int sheetsACall : {1, 3, 8}) {
            const Splatted parts = splat(*field, stage, kernel, 16, 1, sheetsACall);
            EXPECT_EQ(parts.footprints, whole.footprints) << sheetsACall;
            for (int p = 0; p < stage.sheets; ++p)
                EXPECT_EQ(std::memcmp(whole.planes.plane(p), parts.planes.plane(p),
                                      sizeof(float) * static_cast<std::size_t>(stage.width * stage.height)),
                          0)
                    << "sheet " << p << " in calls of " << sheetsACall;
        }
    }
}

// Sheets that cut a lattice along its axis put whole layers of voxels next to the limits of what reaches a sheet,
// where rounding a position decides. It must decide the same way in every call, and add nothing to tiles that are
// not active: what is written there would be seen in a later batch.
TEST(SplattedPlanes, OfAlignedLatticesHangOnNeitherTheCallsNorOldContent) {
    const auto field = boxField({0, 0, 0}, {15, 7, 7});
    std::mt19937 random(31);
    std::uniform_real_distribution<double> size(0.6, 1.9), shift(0, 1);
    for (int i = 0; i < 400; ++i) {
        Mat3 linear(0.0);
        linear[0][2] = random() % 2 ? size(random) : -size(random);  // the grid's x runs along the sweep
        linear[1][0] = linear[2][1] = 1;
        Stage stage = stageFor(*field, linear, Kernel::linear);
        stage.tsFromIs[3].z += shift(random);
        const Splatted whole = splat(*field, stage, Kernel::linear, 8);
        const Splatted parts = splat(*field, stage, Kernel::linear, 8, 1, 1);
        ASSERT_EQ(whole.footprints, parts.footprints) << linear[0][2] << " from " << stage.tsFromIs[3].z;
        for (int n = 0; n < stage.sheets; ++n)
            for (int y = 0; y < stage.height; ++y)
                for (int x = 0; x < stage.width; ++x) {
                    ASSERT_EQ(whole.at(x, y, n), parts.at(x, y, n))
                        << "sheet " << n << ", " << linear[0][2] << " sheets a voxel from " << stage.tsFromIs[3].z;
                    if (whole.at(x, y, n) != 0) {
                        ASSERT_TRUE(whole.planes.active(n, x / kTileEdge, y / kTileEdge))
                            << whole.at(x, y, n) << " on sheet " << n << ", " << linear[0][2] << " sheets a voxel from "
                            << stage.tsFromIs[3].z;
                    }
                }
    }
}

// Every voxel above 0 meets the same number of sheets; empty ones, which blocks hold too, meet none.
TEST(FootprintCount, IsOfVoxelsAboveZeroOnly) {
    const auto field = noiseField();
    const Stage stage = stageFor(*field, rotated(0.9, {3, 1, 2}), Kernel::linear);
    const FootprintTable table(Kernel::linear, stage.tsFromIs, slopedSteps(Kernel::linear, stage.tsFromIs, 16));
    EXPECT_LT(field->activeVoxels, field->blockCount() * kBlockVoxels);
    EXPECT_EQ(splat(*field, stage, Kernel::linear, 16).footprints,
              field->activeVoxels * static_cast<std::uint64_t>(table.sheets()));
}

TEST(Scale, MultipliesEveryTexel) {
    const auto field = noiseField();
    const Stage stage = stageFor(*field, rotated(0.9, {3, 1, 2}), Kernel::linear);
    const Splatted one = splat(*field, stage, Kernel::linear, 16), four = splat(*field, stage, Kernel::linear, 16, 4);
    for (int n = 0; n < stage.sheets; ++n)
        for (int i = 0; i < stage.width * stage.height; ++i)
            ASSERT_EQ(four.planes.plane(n)[i], 4 * one.planes.plane(n)[i]);  // a power of two: exact
}

TEST(TilesOfTheRaster, AwayFromTheFieldAreNeverActive) {
    const auto field = boxField({0, 0, 0}, {7, 7, 7});
    Stage stage = stageFor(*field, Mat3(1.0), Kernel::linear);
    stage.width += 64;
    stage.sheets += 20;
    const Splatted sheets = splat(*field, stage, Kernel::linear, 16);
    int active = 0;
    for (int n = 0; n < stage.sheets; ++n)
        for (int ty = 0; ty < stage.height / kTileEdge; ++ty)
            for (int tx = 0; tx < stage.width / kTileEdge; ++tx) active += sheets.planes.active(n, tx, ty) ? 1 : 0;
    // 8 voxels and a kernel's reach span at most 12 sheets and two tiles an axis.
    EXPECT_GT(active, 0);
    EXPECT_LE(active, 12 * 4);
    // And an active tile is where the field is: nothing lies outside.
    for (int n = 0; n < stage.sheets; ++n)
        for (int y = 0; y < stage.height; ++y)
            for (int x = 0; x < stage.width; ++x)
                if (sheets.at(x, y, n) != 0) {
                    ASSERT_TRUE(sheets.planes.active(n, x / kTileEdge, y / kTileEdge));
                }
}

// Active tiles of the grid stand for their voxels, however many sheets a call asks for.
TEST(ConstantTiles, AreSplattedAsTheVoxelsTheyStandFor) {
    const auto voxels = makeField({-16, 0, 16}, {15, 31, 47}, 1, [](const Vec3& is) {
        // One octant, (-16, 0, 16) .. (-1, 15, 31), and one corner block of another.
        if (is.x < 0 && is.y < 16 && is.z < 32) return 0.5;
        return is.x >= 8 && is.y >= 24 && is.z >= 40 ? 2.0 : 0.0;
    });
    SparseField tiles;
    tiles.wsFromIs = voxels->wsFromIs;
    tiles.tiles = {{{-16, 0, 16}, 16, 0.5f}, {{8, 24, 40}, 8, 2.0f}};
    ASSERT_EQ(voxels->activeVoxels, 16u * 16 * 16 + 8 * 8 * 8);
    const Stage stage = stageFor(*voxels, rotated(0.9, {3, 1, 2}), Kernel::linear);
    const Splatted expected = splat(*voxels, stage, Kernel::linear, 16);
    for (const int sheetsACall : {1, 5, 1000}) {
        const Splatted actual = splat(tiles, stage, Kernel::linear, 16, 1, sheetsACall);
        EXPECT_EQ(actual.footprints, expected.footprints) << sheetsACall;
        for (int n = 0; n < stage.sheets; ++n)
            for (int i = 0; i < stage.width * stage.height; ++i)
                ASSERT_NEAR(actual.planes.plane(n)[i], expected.planes.plane(n)[i], 1e-6);  // order of additions
    }
}

TEST(FieldSplatter, EverySecondBandMayBeSplattedAtOnce) {
    std::mt19937 random(5);
    for (const double size : {0.3, 1.0, 2.7}) {
        const auto field = makeField({-70, -70, 2}, {70, 70, 9}, 1, [&](const Vec3&) { return random() % 3 + 1.0; });
        const Mat3 linear = scaled(size, size, 1) * rotated(0.7, {0.3, 0.2, 1});
        const Stage stage = stageFor(*field, linear, Kernel::linear);
        const FieldSplatter splatter(*field, stage.tsFromIs, Kernel::linear, 8, 1);
        PlaneStack shape(stage.sheets, stage.width, stage.height, 1);
        const int bands = splatter.bands(shape);
        ASSERT_GE(bands, size < 1 ? 1 : 3);
        std::vector<std::vector<int>> rows(static_cast<std::size_t>(bands));
        std::uint64_t footprints = 0;
        for (int band = 0; band < bands; ++band) {
            PlaneStack planes(stage.sheets, stage.width, stage.height, 1);
            for (int p = 0; p < stage.sheets; ++p) planes.begin(p);
            footprints += splatter.splat(0, stage.sheets, std::span(&planes, 1), 0, {}, band);
            for (int y = 0; y < stage.height; ++y)
                for (int p = 0; p < stage.sheets; ++p) {
                    const Real* row = planes.plane(p) + y * planes.rowStride();
                    bool any = std::any_of(row, row + stage.width, [](Real v) { return v != 0; });
                    for (int tx = 0; tx < planes.tilesX(); ++tx) any = any || planes.active(p, tx, y / kTileEdge);
                    if (!any) continue;
                    rows[std::size_t(band)].push_back(y);
                    break;
                }
        }
        for (int band = 0; band + 2 < bands; ++band) {
            // Tables reach up to six rows beyond footprints, and two before them.
            ASSERT_FALSE(rows[std::size_t(band)].empty());
            EXPECT_LT(rows[std::size_t(band)].back() + 6, rows[std::size_t(band) + 2].front() - 2) << size;
        }
        EXPECT_EQ(footprints, splat(*field, stage, Kernel::linear, 8).footprints);
    }
}

}  // namespace
}  // namespace scrim::test
