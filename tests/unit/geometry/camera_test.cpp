// SPDX-License-Identifier: Apache-2.0
// Rays, matrices and frames of cameras, by plain trigonometry.
#include <scrim/geometry/camera.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

// At (1, 2, 3), looking along -x.
Camera someCamera(CameraType type) {
    Camera camera;
    camera.type = type;
    camera.wsPosition = {1, 2, 3};
    camera.wsFromCamera = lookAt({1, 2, 3}, {-4, 2, 3}, {0, 1, 0});
    camera.resolution = {400, 300};
    camera.fov = 50;
    camera.height = 12;
    return camera;
}

void expectNear(const Vec3& a, const Vec3& b, double tolerance = 1e-12) {
    EXPECT_LT(glm::distance(a, b), tolerance)
        << a.x << "," << a.y << "," << a.z << " and " << b.x << "," << b.y << "," << b.z;
}

// The raster position of a point.
Vec2 rasterOf(const Camera& camera, const Vec3& ws) {
    const RayFamily rays = wsRays(camera);
    const Vec3 p = glm::inverse(Mat3(rays.directionX, rays.directionY, rays.direction0)) * (ws - rays.origin0);
    return Vec2(p) / p.z;
}

// From all places on the lens a point at the focus is seen in one place, and others in a disk of half the blur.
TEST(Lens, KeepsTheFocusInItsPlace) {
    Camera camera = someCamera(CameraType::perspective);
    camera.shift = {0.1, -0.2};
    camera.pixelAspect = 1.25;
    const Lens lens{0.3, 7};
    for (const Vec2 place : {Vec2(0, 0), Vec2(1, 0), Vec2(-0.6, 0.8)}) {
        const Camera moved = throughLens(camera, lens, place);
        const Vec3 sharp(1 - 7, 2.4, 1.2), far(1 - 20, 3, 6);
        expectNear(Vec3(rasterOf(moved, sharp), 0), Vec3(rasterOf(camera, sharp), 0), 1e-9);
        Vec2 way = rasterOf(moved, far) - rasterOf(camera, far);
        way.y /= camera.pixelAspect;
        EXPECT_NEAR(glm::length(way), 0.5 * blurAt(camera, lens, 20) * glm::length(place), 1e-9);
    }
}

TEST(PerspectiveRays, MeetAtTheEyeAndHaveDepthAsParameter) {
    const RayFamily rays = wsRays(someCamera(CameraType::perspective));
    for (const double x : {0.0, 123.4, 400.0})
        for (const double y : {0.0, 77.7, 300.0}) {
            expectNear(rays.origin(x, y), {1, 2, 3});
            EXPECT_NEAR(glm::dot(rays.direction(x, y), Vec3(-1, 0, 0)), 1, 1e-12);
        }
}

TEST(PerspectiveRays, OpenByTheFieldOfViewAcrossThePicture) {
    const RayFamily rays = wsRays(someCamera(CameraType::perspective));
    expectNear(rays.direction(200, 150), {-1, 0, 0});
    const double half = std::tan(25 * kPi / 180);
    // Right of someone who looks along -x is -z; rows run downwards.
    expectNear(rays.direction(400, 150), {-1, 0, -half});
    expectNear(rays.direction(0, 150), {-1, 0, half});
    expectNear(rays.direction(200, 0), {-1, half * 300 / 400, 0});
    expectNear(rays.direction(0, 300), {-1, -half * 300 / 400, half});
    const Vec3 left = glm::normalize(rays.direction(0, 150)), right = glm::normalize(rays.direction(400, 150));
    EXPECT_NEAR(std::acos(glm::dot(left, right)), 50 * kPi / 180, 1e-12);
}

TEST(OrthographicRays, AreParallelAndSpanTheHeight) {
    const RayFamily rays = wsRays(someCamera(CameraType::orthographic));
    expectNear(rays.origin(200, 150), {1, 2, 3});
    expectNear(rays.origin(0, 0), {1, 2 + 6, 3 + 8});
    expectNear(rays.origin(400, 300), {1, 2 - 6, 3 - 8});
    for (const double x : {0.0, 399.0}) expectNear(rays.direction(x, 5), {-1, 0, 0});
}

// A pixel twice as wide as high: the fov is across the picture, the height is up it; the other side follows.
TEST(PixelAspect, StretchesTheOtherSide) {
    Camera wide = someCamera(CameraType::perspective);
    wide.pixelAspect = 2;
    const double half = std::tan(25 * kPi / 180);
    expectNear(wsRays(wide).direction(400, 0), {-1, half * 300 / 800, -half});
    wide = someCamera(CameraType::orthographic);
    wide.pixelAspect = 2;
    expectNear(wsRays(wide).origin(400, 0), {1, 2 + 6, 3 - 16});
}

TEST(Supersampled, CutsPixelsAndMovesNoRay) {
    for (const CameraType type : {CameraType::perspective, CameraType::orthographic}) {
        const Camera camera = someCamera(type);
        const RayFamily one = wsRays(camera), three = wsRays(supersampled(camera, 3));
        expectNear(one.origin(12.5, 7.25), three.origin(37.5, 21.75));
        expectNear(one.direction(12.5, 7.25), three.direction(37.5, 21.75));
    }
}

TEST(WorldToNdc, SendsEveryPointOfARayToItsPixel) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const CameraType type : {CameraType::perspective, CameraType::orthographic}) {
        Camera camera = someCamera(type);
        camera.pixelAspect = 1.5;
        camera.wsFromCamera = lookAt(camera.wsPosition, {5, -3, 8}, {0, 1, 0});
        const RayFamily rays = wsRays(camera);
        const Mat4 ndc = worldToNdc(camera), view = worldToCamera(camera);
        for (int i = 0; i < 200; ++i) {
            const double x = 400 * unit(random), y = 300 * unit(random), depth = 0.1 + 50 * unit(random);
            const Vec3 p = rays.origin(x, y) + depth * rays.direction(x, y);
            const glm::dvec4 clip = ndc * glm::dvec4(p, 1);
            EXPECT_NEAR(clip.x / clip.w, 2 * x / 400 - 1, 1e-10);
            EXPECT_NEAR(clip.y / clip.w, 1 - 2 * y / 300, 1e-10);
            EXPECT_NEAR((view * glm::dvec4(p, 1)).z, -depth, 1e-10);
        }
    }
}

TEST(WorldToCamera, IsTheInverseOfTheCamerasFrame) {
    const Camera camera = someCamera(CameraType::perspective);
    const glm::dvec4 origin = worldToCamera(camera) * glm::dvec4(camera.wsPosition, 1);
    expectNear(Vec3(origin), Vec3(0));
    const glm::dvec4 up = worldToCamera(camera) * glm::dvec4(camera.wsPosition + Vec3(0, 1, 0), 1);
    expectNear(Vec3(up), {0, 1, 0});
}

void expectRotation(const Mat3& m) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(glm::dot(m[i], m[j]), i == j ? 1 : 0, 1e-12);
    EXPECT_NEAR(glm::determinant(m), 1, 1e-12);
}

TEST(LookAt, IsARotationThatLooksAtItsTargetWithUpUp) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 200; ++i) {
        const Vec3 position(unit(random), unit(random), unit(random)), target(unit(random), unit(random), unit(random)),
            up(unit(random), unit(random), unit(random));
        const Mat3 m = lookAt(position, target, up);
        expectRotation(m);
        expectNear(-m[2], glm::normalize(target - position));
        EXPECT_NEAR(glm::dot(m[0], up), 0, 1e-12);  // right is level
        EXPECT_GT(glm::dot(m[1], up), 0);
    }
}

// Looking straight up or down: any turn will do, as long as it is always the same.
TEST(LookAt, AlongUpIsARotationThatRoundingDoesNotTurn) {
    for (const Vec3& up : {Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(3, 4, 5)})
        for (const double side : {1.0, -1.0}) {
            const Mat3 m = lookAt({1, 2, 3}, Vec3(1, 2, 3) + side * up, up);
            expectRotation(m);
            expectNear(-m[2], side * glm::normalize(up));
            const Mat3 nearby = lookAt({1, 2, 3}, Vec3(1, 2, 3) + side * up + Vec3(1e-15, -1e-15, 1e-15), up);
            expectNear(m[0], nearby[0], 1e-9);
        }
}

}  // namespace
}  // namespace scrim::test
