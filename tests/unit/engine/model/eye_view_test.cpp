// SPDX-License-Identifier: Apache-2.0
// The eye's rays in texel space against the camera's own, taken there point by point in double precision.
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/shade/shade_tile.h>

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <random>
#include <string>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

struct Case {
    std::string name;
    CameraType type;
    Vec3 far;  ///< where the scene stands
};
void PrintTo(const Case& c, std::ostream* out) {
    *out << c.name;
}

class Random {
  public:
    explicit Random(unsigned seed) : m_engine(seed) {}
    double in(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(m_engine); }
    Vec3 direction() { return glm::normalize(Vec3(in(-1, 1), in(-1, 1), in(-1, 1))); }

  private:
    std::mt19937 m_engine;
};

// A camera some 100 units away from sheets that it looks at at an angle of less than 50 degrees, from either side.
struct Setup {
    Camera camera;
    Sheets sheets;
};

Setup setup(const Case& c, unsigned seed) {
    Random random(seed);
    Setup s;
    s.camera.type = c.type;
    s.camera.wsPosition = c.far + random.in(80, 120) * random.direction();
    s.camera.wsFromCamera = lookAt(s.camera.wsPosition, c.far + Vec3(1, 2, 3), {0, 1, 0});
    s.camera.resolution = {640, 480};
    s.camera.fov = 25;
    s.camera.height = 40;
    s.camera.near = random.in(0, 50);
    const double side = seed % 2 ? 1 : -1;
    const Vec3 axis = glm::normalize(viewingAxis(s.camera) + 0.8 * random.direction());
    s.sheets.ssFromWs = sweepRotation(side * axis, {0, 1, 0});
    s.sheets.wsAnchor = c.far;
    s.sheets.texel = 0.31;
    s.sheets.thickness = 0.23;
    s.sheets.ssOrigin = {-20, -22, -18};
    s.sheets.width = s.sheets.height = 128;
    s.sheets.count = 160;
    return s;
}

class EyeViewOf : public testing::TestWithParam<Case> {
  protected:
    // Positions are doubles; the camera's own are as exact as the numbers of its world.
    double rounding() const { return 1e-9 + 1e-15 * glm::length(GetParam().far) / 0.23 * 100; }
};

TEST_P(EyeViewOf, RayIsTheCamerasRay) {
    for (unsigned seed = 1; seed <= 30; ++seed) {
        const auto [camera, sheets] = setup(GetParam(), seed);
        const EyeView eye(camera, sheets);
        const RayFamily ws = wsRays(camera);
        Random random(seed);
        for (int i = 0; i < 20; ++i) {
            const double x = random.in(-100, 740), y = random.in(-50, 500), reference = random.in(0, 160);
            const EyeView::Ray ray = eye.ray(x, y, reference);
            const Vec3 origin = ws.origin(x, y), direction = ws.direction(x, y);
            for (const double depth : {60.0, 100.0, 140.0}) {
                const Vec3 ts = sheets.tsPoint(origin + depth * direction);
                EXPECT_NEAR(ray.u + ray.slopeU * (ts.z - reference), ts.x, rounding());
                EXPECT_NEAR(ray.v + ray.slopeV * (ts.z - reference), ts.y, rounding());
            }
            EXPECT_NEAR(ray.startN, sheets.tsPoint(origin + camera.near * direction).z, rounding());
        }
    }
}

// The vectorised rays of a tile are those rays through the pixels' centres; floats of up to some 1000 texels.
TEST_P(EyeViewOf, RaysOfATileAreThoseOfItsPixelCentres) {
    for (unsigned seed = 1; seed <= 30; ++seed) {
        const auto [camera, sheets] = setup(GetParam(), seed);
        const EyeView eye(camera, sheets);
        const double reference = 8 * seed + 0.5;
        const int x0 = static_cast<int>(seed) * 16 - 32, y0 = static_cast<int>(seed) * 11 - 16;
        const RayTile tile = eye.rays(x0, y0, reference);
        for (int k = 0; k < kTileSize; ++k) {
            const EyeView::Ray ray = eye.ray(x0 + k % kTileEdge + 0.5, y0 + k / kTileEdge + 0.5, reference);
            const auto close = [&](double expected) { return 2e-7 * std::abs(expected) + 1e-7 + rounding(); };
            ASSERT_NEAR(tile.u[k], ray.u, close(ray.u)) << k;
            ASSERT_NEAR(tile.v[k], ray.v, close(ray.v)) << k;
            ASSERT_NEAR(tile.stepU[k], ray.slopeU, close(ray.slopeU)) << k;
            ASSERT_NEAR(tile.stepV[k], ray.slopeV, close(ray.slopeV)) << k;
            ASSERT_NEAR(tile.startN[k], ray.startN - reference, close(ray.startN - reference)) << k;
        }
    }
}

// Slopes for shading are slopes in world units: du/dw of the ray that passes the texel.
TEST_P(EyeViewOf, SlopesAreThoseOfTheRayThroughATexel) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const auto [camera, sheets] = setup(GetParam(), seed);
        const EyeView eye(camera, sheets);
        SampleTile samples;
        eye.setTexels(70.5, 48, 64, samples);
        for (int k = 0; k < kTileSize; k += 37) {
            const Vec3 ws = sheets.wsPoint({samples.u[k], samples.v[k], 70.5});
            const Vec3 travel = sheets.ssFromWs * (camera.type == CameraType::orthographic ? viewingAxis(camera)
                                                                                           : ws - camera.wsPosition);
            EXPECT_NEAR(samples.eyeA[k], travel.x / travel.z, 1e-5 * (1 + std::abs(travel.x / travel.z)));
            EXPECT_NEAR(samples.eyeB[k], travel.y / travel.z, 1e-5 * (1 + std::abs(travel.y / travel.z)));
        }
    }
}

TEST_P(EyeViewOf, BoxOfTexelsHoldsEveryPixelWhoseRayMeetsThem) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const auto [camera, sheets] = setup(GetParam(), seed);
        const EyeView eye(camera, sheets);
        Random random(seed);
        int held = 0;
        for (int i = 0; i < 200; ++i) {
            const double x = random.in(0, 640), y = random.in(0, 480), middle = random.in(0, 160);
            const EyeView::Ray ray = eye.ray(x, y, middle);
            const auto seen = eye.seenBy(
                {ray.u - random.in(0, 9), ray.v - random.in(0, 9), ray.u + random.in(0, 9), ray.v + random.in(0, 9)},
                middle);
            ASSERT_TRUE(seen);
            const double slack = 1e-6 + 100 * rounding();
            EXPECT_LE(seen->x0, x + slack);
            EXPECT_GE(seen->x1, x - slack);
            EXPECT_LE(seen->y0, y + slack);
            EXPECT_GE(seen->y1, y - slack);
            // And it is not simply the whole picture: nine texels are about as many hundredths of it.
            held += seen->x1 - seen->x0 < 320 ? 1 : 0;
        }
        EXPECT_GT(held, 180);
    }
}

INSTANTIATE_TEST_SUITE_P(Cameras, EyeViewOf,
                         testing::Values(Case{"perspective", CameraType::perspective, Vec3(0)},
                                         Case{"orthographic", CameraType::orthographic, Vec3(0)},
                                         Case{"perspectiveFarAway", CameraType::perspective, {1e6, -2e6, 3e6}},
                                         Case{"orthographicFarAway", CameraType::orthographic, {1e6, -2e6, 3e6}}),
                         [](const auto& test) { return test.param.name; });

// Texels on the eye's own plane, or behind it, are seen by no pixel in particular: no bound is known.
TEST(EyeView, HasNoBoxBehindTheEye) {
    auto [camera, sheets] = setup({"", CameraType::perspective, Vec3(0)}, 2);
    sheets.ssFromWs = sweepRotation(viewingAxis(camera), {0, 1, 0});
    const EyeView eye(camera, sheets);
    const Vec3 at = sheets.tsPoint(camera.wsPosition);
    EXPECT_TRUE(eye.seenBy({at.x - 4, at.y - 4, at.x + 4, at.y + 4}, at.z + 10));
    EXPECT_FALSE(eye.seenBy({at.x - 4, at.y - 4, at.x + 4, at.y + 4}, at.z));
    EXPECT_FALSE(eye.seenBy({at.x - 4, at.y - 4, at.x + 4, at.y + 4}, at.z - 10));
}

// An eye that looks along the sheets' normal from a point in texel space.
EyeView eyeAt(const Vec3& ts, const Sheets& sheets) {
    Camera camera;
    camera.wsPosition = ts * Vec3(sheets.texel, sheets.texel, sheets.thickness);
    camera.wsFromCamera = lookAt(camera.wsPosition, camera.wsPosition + Vec3(0, 0, 1), {0, 1, 0});
    return {camera, sheets};
}

TEST(TexelSamples, LieOnTexelsAndLookAwayFromTheEye) {
    Sheets sheets;
    sheets.texel = 0.5;
    sheets.thickness = 0.8;
    SampleTile samples;
    eyeAt({20, 7, -30}, sheets).setTexels(4.5, 32, 48, samples);
    for (int j = 0; j < kTileEdge; ++j)
        for (int i = 0; i < kTileEdge; ++i) {
            const int k = j * kTileEdge + i;
            EXPECT_EQ(samples.u[k], static_cast<float>(32 + i));
            EXPECT_EQ(samples.v[k], static_cast<float>(48 + j));
            const double w = (4.5 + 30) * 0.8;
            EXPECT_NEAR(samples.eyeA[k], (32 + i - 20) * 0.5 / w, 1e-6);
            EXPECT_NEAR(samples.eyeB[k], (48 + j - 7) * 0.5 / w, 1e-6);
        }
}

TEST(TexelSamples, StayFiniteOnTheEyesOwnPlane) {
    const Sheets sheets;
    const EyeView eye = eyeAt({8, 8, 3.5}, sheets);
    for (const double middle : {3.4, 3.5, 3.6}) {
        SampleTile samples;
        eye.setTexels(middle, 0, 0, samples);
        for (int k = 0; k < kTileSize; ++k)
            EXPECT_TRUE(std::isfinite(samples.eyeA[k]) && std::isfinite(samples.eyeB[k])) << middle;
    }
}

}  // namespace
}  // namespace scrim::test
