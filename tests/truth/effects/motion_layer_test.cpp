// SPDX-License-Identifier: Apache-2.0
// The layer `motion`: how far what is seen moves until the next frame, against closed forms and a march of its own.
#include "scenes.h"

#include <scrim/verify/reference.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr int kPixels = 24;

// Pixels of half a unit; a slab of 60 x 60 x 8 voxels that fills the picture.
ViewScene slabScene() {
    Medium medium;
    medium.densityScale = 0.15;
    ViewScene scene = orthographicScene(boxField({-30, -30, -4}, {29, 29, 3}), medium, 12, kPixels);
    scene.lights = {distantLight({-0.3, -0.2, -1}, 2)};
    scene.layers = {Layer::motion};
    return scene;
}

std::shared_ptr<VolumeMotion> moved(const Vec3& way) {
    auto motion = std::make_shared<VolumeMotion>();
    motion->wsNextFromWs[3] = glm::dvec4(way, 1);
    return motion;
}

// The field's density times velocity, as the shot makes it.
std::shared_ptr<VolumeMotion> flowing(const ViewVolume& volume, const Int3& lower, const Int3& upper,
                                      const std::function<Vec3(const Vec3&)>& velocity, double most) {
    auto motion = std::make_shared<VolumeMotion>();
    motion->least = Vec3(-most);
    motion->most = Vec3(most);
    motion->wsPerVelocity = Mat3(1.0);
    const FieldSampler probe(*volume.field, Kernel::linear);
    for (int c = 0; c < 3; ++c)
        motion->flow.push_back(
            {makeField(lower, upper, 1,
                       [&](const Vec3& is) { return probe.voxel(Int3(is)) * (velocity(is)[c] + most); }),
             volume.wsFromIs});
    return motion;
}

const std::vector<float>& motionOf(const Frame& frame) {
    return std::find_if(frame.layers.begin(), frame.layers.end(),
                        [](const FrameLayer& layer) { return layer.layer == Layer::motion; })
        ->data;
}

void expectEverywhere(const ViewScene& scene, const Vec2& expected, double tolerance) {
    for (const ShadeMode shade : {ShadeMode::texel, ShadeMode::pixel}) {
        ViewScene own = scene;
        own.dials.shade = shade;
        const Frame frame = renderScene(own);
        const std::vector<float>& motion = motionOf(frame);
        ASSERT_EQ(motion.size(), std::size_t(2 * kPixels * kPixels));
        for (std::size_t i = 0; i < motion.size(); ++i)
            ASSERT_NEAR(motion[i], expected[static_cast<int>(i % 2)], tolerance) << "float " << i;
    }
}

TEST(MotionLayer, IsZeroWithoutMotion) {
    expectEverywhere(slabScene(), {0, 0}, 0);
}

TEST(MotionLayer, OfATranslationIsItInPixels) {
    ViewScene scene = slabScene();
    scene.volumes[0].motion = moved({1.5, -0.5, 4});
    expectEverywhere(scene, {3, -1}, 1e-4);
    scene.volumes[0].medium.extinctionTint = {1, 0.5, 0.1};
    expectEverywhere(scene, {3, -1}, 1e-4);
    scene.lights[0].wsDirection = glm::normalize(Vec3(0.2, 0.3, 1));  // back to front
    expectEverywhere(scene, {3, -1}, 1e-4);
}

TEST(MotionLayer, OfAPanIsAgainstTheCamera) {
    ViewScene scene = slabScene();
    scene.nextCamera = scene.camera;
    scene.nextCamera->wsPosition += Vec3(1, 2, 0);
    expectEverywhere(scene, {-2, -4}, 1e-4);
    scene.volumes[0].motion = moved({1, 2, 0});  // it goes along
    expectEverywhere(scene, {0, 0}, 1e-4);
}

TEST(MotionLayer, OfAVelocityIsThatOfTheTranslation) {
    ViewScene scene = slabScene();
    scene.volumes[0].motion = flowing(
        scene.volumes[0], {-30, -30, -4}, {29, 29, 3}, [](const Vec3&) { return Vec3(1.5, -0.5, 1); }, 3);
    expectEverywhere(scene, {3, -1}, 1e-3);
}

TEST(MotionLayer, OfVolumesInOnePlaceIsTheirMean) {
    ViewScene scene = slabScene();
    scene.volumes.push_back(scene.volumes[0]);
    scene.volumes[1].medium.densityScale *= 3;
    scene.volumes[0].motion = moved({2, 0, 0});
    expectEverywhere(scene, {1, 0}, 1e-3);
}

// A perspective camera comes closer, and turns; a thin slab lies at a known depth.
TEST(MotionLayer, OfAPerspectiveCameraIsThatOfItsRays) {
    Medium medium;
    medium.densityScale = 2;
    ViewScene scene = orthographicScene(boxField({-40, -40, 0}, {39, 39, 0}), medium, 12, kPixels);
    scene.camera.type = CameraType::perspective;
    scene.camera.fov = 30;
    scene.camera.wsPosition = {0, 0, 40};
    scene.layers = {Layer::motion};
    Camera next = scene.camera;
    next.wsPosition = {1, 0.5, 36};
    next.wsFromCamera = lookAt(next.wsPosition, {0, 1, 0}, {0, 1, 0});
    scene.nextCamera = next;
    const Frame frame = renderScene(scene);
    const RayFamily rays = wsRays(scene.camera);
    const Mat4 ndc = worldToNdc(next);
    for (const Int2 p : {Int2(2, 3), Int2(12, 12), Int2(20, 7), Int2(23, 23)}) {
        const Vec3 o = rays.origin(p.x + 0.5, p.y + 0.5), d = rays.direction(p.x + 0.5, p.y + 0.5);
        const glm::dvec4 at = ndc * glm::dvec4(o + -o.z / d.z * d, 1);
        const Vec2 raster((at.x / at.w + 1) / 2 * kPixels, (1 - at.y / at.w) / 2 * kPixels);
        const float* motion = motionOf(frame).data() + 2 * (p.y * kPixels + p.x);
        EXPECT_NEAR(motion[0], raster.x - (p.x + 0.5), 0.02) << p.x;
        EXPECT_NEAR(motion[1], (p.y + 0.5) - raster.y, 0.02) << p.y;
    }
}

// Smoke that turns about z and shears: rays are marched, and weigh velocities by what they hide.
TEST(MotionLayer, OfAVelocityAgreesWithBruteForce) {
    ViewScene scene = plainScene();
    scene.layers = {Layer::motion};
    const auto velocity = [](const Vec3& p) {
        return Vec3(-0.1 * p.y, 0.1 * p.x + 0.05 * p.z, 2 * std::sin(0.2 * p.x));
    };
    scene.volumes[0].motion = flowing(scene.volumes[0], Int3(-20), Int3(20), velocity, 4);
    scene.volumes[0].motion = [&] {
        auto motion = std::make_shared<VolumeMotion>(*scene.volumes[0].motion);
        motion->wsNextFromWs[3] = {0.5, 0, 0, 1};
        return motion;
    }();
    scene.dials.texel = scene.dials.sheetThickness = 0.7;
    const Frame frame = renderScene(scene);
    const Reference reference(scene);
    const RayFamily rays = wsRays(scene.camera);
    const double pixel = scene.camera.height / scene.camera.resolution.y;
    double square = 0, mean = 0, count = 0;
    for (int y = 8; y < 40; y += 5)
        for (int x = 8; x < 40; x += 5) {
            const Vec3 o = rays.origin(x + 0.5, y + 0.5), d = rays.direction(x + 0.5, y + 0.5);
            const double begin = o.z - 22, step = 0.25;
            Vec2 sum(0);
            double hidden = 0, tau = 0;
            for (double t = begin; t < begin + 44; t += step) {
                const double own = reference.opticalDepth(o + t * d, o + (t + step) * d).x;
                const double weight = std::exp(-tau) * -std::expm1(-own);
                sum += weight * (Vec2(velocity(o + (t + step / 2) * d)) + Vec2(0.5, 0)) / pixel;
                hidden += weight;
                tau += own;
            }
            if (hidden < 0.01) continue;
            const float* motion = motionOf(frame).data() + 2 * (y * scene.camera.resolution.x + x);
            const Vec2 error = Vec2(motion[0], motion[1]) - sum / hidden;
            square += glm::dot(error, error);
            mean += glm::length(sum / hidden);
            ++count;
        }
    ASSERT_GT(count, 20);
    std::printf("motion of smoke: mean %.2f pixels, error %.3f\n", mean / count, std::sqrt(square / count));
    EXPECT_LT(std::sqrt(square / count), 0.02 * mean / count);
}

TEST(MotionLayer, CostsNothingWhereNobodyAsks) {
    ViewScene scene = plainScene();
    const Frame plain = renderScene(scene);
    scene.volumes[0].motion = flowing(
        scene.volumes[0], Int3(-20), Int3(20), [](const Vec3&) { return Vec3(1); }, 2);
    scene.nextCamera = scene.camera;
    const Frame same = renderScene(scene);
    EXPECT_EQ(same.image.rgba, plain.image.rgba);
    EXPECT_EQ(same.work, plain.work);
    scene.layers = {Layer::motion};
    const Frame with = renderScene(scene);
    EXPECT_GT(with.work.voxelsFed, plain.work.voxelsFed);
    for (std::size_t i = 0; i < plain.image.rgba.size(); ++i)
        ASSERT_NEAR(with.image.rgba[i], plain.image.rgba[i], 2e-6 * 5);
}

}  // namespace
}  // namespace scrim::test
