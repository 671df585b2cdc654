// SPDX-License-Identifier: Apache-2.0
#include <scrim/geometry/sheets.h>

#include "support/expect_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

namespace scrim::test {
namespace {

class Random {
  public:
    double in(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(m_engine); }
    Vec3 vector(double reach) { return {in(-reach, reach), in(-reach, reach), in(-reach, reach)}; }

  private:
    std::mt19937 m_engine{5};
};

Sheets someSheets(Random& random) {
    Sheets sheets;
    sheets.wsAnchor = random.vector(100);
    sheets.ssFromWs = sweepRotation(glm::normalize(random.vector(1)), {0, 1, 0});
    sheets.texel = random.in(0.1, 2);
    sheets.thickness = random.in(0.1, 2);
    sheets.ssOrigin = random.vector(50);
    return sheets;
}

TEST(Sheets, TakePointsToTexelSpaceAndBack) {
    Random random;
    for (int i = 0; i < 200; ++i) {
        const Sheets sheets = someSheets(random);
        const Vec3 p = random.vector(100);
        EXPECT_LT(glm::distance(sheets.wsPoint(sheets.tsPoint(p)), p), 1e-11);
        const Vec3 ts = random.vector(100);
        EXPECT_LT(glm::distance(sheets.tsPoint(sheets.wsPoint(ts)), ts), 1e-10);
    }
}

// U and V count texels, N sheets: one step of each is a texel or a thickness along a row of the rotation.
TEST(Sheets, MeasureInTexelsAndSheets) {
    Random random;
    for (int i = 0; i < 50; ++i) {
        const Sheets sheets = someSheets(random);
        const Vec3 at = sheets.wsPoint({3, 4, 5});
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 next(3, 4, 5);
            next[axis] += 1;
            const Vec3 step = sheets.wsPoint(next) - at;
            EXPECT_NEAR(glm::length(step), axis < 2 ? sheets.texel : sheets.thickness, 1e-12);
            const Vec3 row(sheets.ssFromWs[0][axis], sheets.ssFromWs[1][axis], sheets.ssFromWs[2][axis]);
            EXPECT_NEAR(glm::dot(glm::normalize(step), row), 1, 1e-12);
            EXPECT_LT(glm::distance(sheets.tsVector(step), next - Vec3(3, 4, 5)), 1e-12);
        }
        const Vec3 origin = sheets.wsAnchor + glm::transpose(sheets.ssFromWs) * sheets.ssOrigin;
        EXPECT_LT(glm::length(sheets.tsPoint(origin)), 1e-10);
    }
}

TEST(Sheets, MapAWholeSpaceAsTheyMapItsPoints) {
    Random random;
    for (int i = 0; i < 50; ++i) {
        const Sheets sheets = someSheets(random);
        Mat4 wsFromIs(1.0);
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 3; ++row) wsFromIs[column][row] = random.in(-3, 3);
        const Mat4 tsFromIs = sheets.tsFrom(wsFromIs);
        const Vec3 is = random.vector(40);
        EXPECT_LT(glm::distance(transformPoint(tsFromIs, is), sheets.tsPoint(transformPoint(wsFromIs, is))), 1e-9);
    }
}

// A million units away doubles resolve 1e-10; nothing is lost beyond that.
TEST(Sheets, KeepTheirPrecisionFarFromTheOrigin) {
    Random random;
    Sheets sheets = someSheets(random);
    sheets.wsAnchor = {1e6, -2e6, 3e6};
    Mat4 wsFromIs = glm::translate(Mat4(1.0), sheets.wsAnchor);
    const Vec3 near = transformPoint(sheets.tsFrom(wsFromIs), {1, 2, 3});
    sheets.wsAnchor = Vec3(0);
    EXPECT_LT(glm::distance(near, sheets.tsPoint({1, 2, 3})), 1e-8);
}

void expectRotation(const Mat3& m) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(glm::dot(m[i], m[j]), i == j ? 1 : 0, 1e-12);
    EXPECT_NEAR(glm::determinant(m), 1, 1e-12);  // right-handed
}

TEST(SweepRotation, SendsItsAxisToWAndUpIntoThePlaneOfVAndW) {
    Random random;
    for (int i = 0; i < 300; ++i) {
        const Vec3 axis = glm::normalize(random.vector(1)), up = random.vector(1);
        const Mat3 m = sweepRotation(axis, up);
        expectRotation(m);
        EXPECT_LT(glm::distance(m * axis, Vec3(0, 0, 1)), 1e-12);
        const Vec3 turned = m * up;
        EXPECT_NEAR(turned.x, 0, 1e-12);
        EXPECT_GT(turned.y, 0);
    }
}

TEST(SweepRotation, AlongUpIsARotationAllTheSame) {
    for (const Vec3& axis : {Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0)})
        for (const double side : {1.0, -1.0}) {
            const Mat3 m = sweepRotation(axis, side * axis);
            expectRotation(m);
            EXPECT_LT(glm::distance(m * axis, Vec3(0, 0, 1)), 1e-12);
        }
}

// A light that moves by a little moves texels by a little, as long as the axis stays away from up.
TEST(SweepRotation, IsContinuousAwayFromUp) {
    Random random;
    for (int i = 0; i < 200; ++i) {
        const Vec3 up(0, 1, 0);
        Vec3 axis = glm::normalize(random.vector(1));
        if (std::abs(axis.y) > 0.9) continue;
        const Vec3 nearby = glm::normalize(axis + random.vector(1e-6));
        const Mat3 a = sweepRotation(axis, up), b = sweepRotation(nearby, up);
        // u turns by at most the step over the sine of the angle to up: 2.3 at 26 degrees.
        for (int column = 0; column < 3; ++column) EXPECT_LT(glm::distance(a[column], b[column]), 1e-5);
    }
}

TEST(RasterArea, IsCountedInSixtyFourBitsAndRefusedBeyondThirtyTwo) {
    EXPECT_EQ(rasterArea(46340, 46340, "texels"), 2147395600u);
    const std::string error =
        errorOf(ErrorKind::render, [] { rasterArea(47824, 48224, "texels (a larger 'texel' needs fewer)"); });
    EXPECT_EQ(error,
              "a raster of 47824 x 48224 texels (a larger 'texel' needs fewer) is too large; expected at most "
              "2147483647 in all");
}

}  // namespace
}  // namespace scrim::test
