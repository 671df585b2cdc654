// SPDX-License-Identifier: Apache-2.0
// A Gaussian ball: its optical depth has a closed form along every line, and so single scattering is a plain
// one-dimensional integral, whatever the directions of eye and light.
#include "support/fields.h"

#include <scrim/geometry/camera.h>

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

// sigma(r) = sigma0 exp(-r^2 / 2 s^2). The tent kernel widens a Gaussian by a variance of 1/6 voxel^2 an axis.
struct Ball {
    double sigma0 = 0.4, s = 7;

    double width() const { return std::sqrt(s * s + 1.0 / 6); }
    double peak() const { return sigma0 * std::pow(s / width(), 3); }
    double sigma(const Vec3& p) const { return peak() * std::exp(-glm::dot(p, p) / (2 * width() * width())); }
    /// Optical depth from far away against `direction` up to `p`.
    double depthTo(const Vec3& p, const Vec3& direction) const {
        const double along = glm::dot(p, direction), w = width();
        const double aside2 = glm::dot(p, p) - along * along;
        return peak() * std::exp(-aside2 / (2 * w * w)) * w * std::sqrt(kPi / 2) *
               (1 + std::erf(along / (w * std::sqrt(2.0))));
    }
    std::shared_ptr<SparseField> field() const {
        const Ball ball = *this;
        return makeField(Int3(-36), Int3(36), 1,
                         [ball](const Vec3& is) { return std::exp(-glm::dot(is, is) / (2 * ball.s * ball.s)); });
    }
    /// Radiance along the ray through `p`, for irradiance 1, albedo 1 and an isotropic phase function.
    double radiance(const Vec3& p, const Vec3& eye, const Vec3& light) const {
        double sum = 0;
        const double step = 0.02;
        for (double t = -45; t < 45; t += step) {
            const Vec3 q = p + (t - glm::dot(p, eye)) * eye;
            sum += step * sigma(q) * std::exp(-depthTo(q, light) - depthTo(q, eye)) / (4 * kPi);
        }
        return sum;
    }
};

class BallLitFrom : public testing::TestWithParam<Vec3> {};

TEST_P(BallLitFrom, MatchesTheIntegralOfItsClosedFormDepth) {
    const Ball ball;
    Medium medium;
    medium.densityScale = ball.sigma0;
    medium.albedo = Rgb(1);
    ViewScene scene = orthographicScene(ball.field(), medium, 48, 24);
    const Light light = distantLight(GetParam());
    scene.lights.push_back(light);
    const Frame frame = renderScene(scene);
    double brightest = 0;
    for (int i = 0; i < 24 * 24; ++i) brightest = std::max(brightest, pixelOf(frame, i % 24, i / 24)[0]);
    for (int y = 1; y < 24; y += 2)
        for (int x = 1; x < 24; x += 2) {
            const Vec3 p((x + 0.5 - 12) * 2, (12 - y - 0.5) * 2, 0);
            const double expected = ball.radiance(p, {0, 0, -1}, light.wsDirection);
            // Bilinear look-ups widen the ball, each by up to 1/4 voxel^2 of variance (half a percent at s = 7):
            // once for the eye, once for the light.
            EXPECT_NEAR(pixelOf(frame, x, y)[0], expected, 0.01 * brightest) << "pixel " << x << "," << y;
        }
}

INSTANTIATE_TEST_SUITE_P(EverySide, BallLitFrom,
                         testing::Values(Vec3(0, 0, -1), Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(0, -1, 0),
                                         Vec3(-1, -1, -0.5), Vec3(1, -1, 1), Vec3(0.01, -1, 1e-7)));

}  // namespace
}  // namespace scrim::test
