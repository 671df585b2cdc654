// SPDX-License-Identifier: Apache-2.0
// The order of the method, measured: errors against the engine's own limit fall with the square of the sheets'
// thickness, at whatever slant.
#include "support/fields.h"

#include <scrim/geometry/camera.h>
#include <scrim/study/convergence_order.h>

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

ViewScene smokeUnder(const Vec3& lightDirection, double thickness) {
    Medium medium;
    medium.densityScale = 0.12;
    medium.albedo = Rgb(0.9);
    ViewScene scene = orthographicScene(smokeField(28), medium, 70, 48);
    scene.lights.push_back(distantLight(lightDirection));
    scene.dials.sheetThickness = thickness;
    scene.dials.footprintSteps = 32;
    // The smooth kernel: the order is that of the method, not of the tent's kinks.
    scene.dials.kernel = Kernel::bspline;
    return scene;
}

double relativeRmse(const Frame& a, const Frame& limit) {
    double squares = 0, sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < a.image.rgba.size(); i += 4) {
        if (limit.image.rgba[i + 3] <= 1e-3f) continue;
        const double d = a.image.rgba[i] - limit.image.rgba[i];
        squares += d * d;
        sum += limit.image.rgba[i];
        ++count;
    }
    return std::sqrt(squares / count) / (sum / count);
}

class OrderOfThickness : public testing::TestWithParam<Vec3> {};

TEST_P(OrderOfThickness, IsTwo) {
    const Frame limit = renderScene(smokeUnder(GetParam(), 0.25));
    const double coarse = relativeRmse(renderScene(smokeUnder(GetParam(), 4)), limit);
    const double medium = relativeRmse(renderScene(smokeUnder(GetParam(), 2)), limit);
    const double fine = relativeRmse(renderScene(smokeUnder(GetParam(), 1)), limit);
    RecordProperty("coarse", std::to_string(coarse));
    // The limit is itself off by (1/4)^2: orders come out slightly high, rounding of positions pulls them down.
    EXPECT_GT(std::log2(coarse / medium), 1.6) << coarse << " " << medium << " " << fine;
    EXPECT_GT(std::log2(medium / fine), 1.6) << coarse << " " << medium << " " << fine;
}

// Slants of 45, 6 and 22 degrees, and a light that faces the eye at an angle. (A light exactly along the view is
// exact at any thickness: the closed form of one sheet telescopes.)
INSTANTIATE_TEST_SUITE_P(Slants, OrderOfThickness,
                         testing::Values(Vec3(1, 0, 0), Vec3(0.2, 0, -1), Vec3(1, 0, -1), Vec3(0, 1, 1.5)));

// Errors of a classified step that throws shadows on itself, apart for pixels at edges and for those between them (the
// way of T. Etiene and others, "Verifying Volume Rendering Using Discretization Error Analysis", IEEE Transactions on
// Visualization and Computer Graphics, 2014).
constexpr int kEdge = 96;

ViewScene dentedBall(double size) {
    const auto dented = makeField(Int3(-15), Int3(15), 1, [](const Vec3& is) {
        const double dents = 0.9 * std::sin(0.7 * is.x) * std::sin(0.6 * is.y) * std::sin(0.8 * is.z);
        return std::clamp(0.5 + 0.08 * (11 - glm::length(is) + dents), 0.0, 1.0);
    });
    ViewScene scene = orthographicScene(dented, {}, 27, kEdge);
    Classified look;
    look.transfer = {{0.5, Rgb(1), 0}, {0.5, Rgb(1), 1.2}, {1, Rgb(1), 1.2}};
    scene.volumes[0].classified = std::make_shared<const Classified>(look);
    scene.lights.push_back(distantLight({1, -0.3, -0.8}));
    scene.dials.kernel = Kernel::bspline;
    scene.dials.footprintSteps = 32;
    scene.dials.texel = scene.dials.sheetThickness = size;
    scene.dials.opacityCutoff = 0;
    if (getenv("NOSH")) scene.lights[0].shadows = false;
    if (getenv("LIN")) scene.dials.kernel = Kernel::linear;
    if (getenv("SOFT")) { look.transfer = {{0.4, Rgb(1), 0}, {0.9, Rgb(1), 1.2}, {1, Rgb(1), 1.2}}; scene.volumes[0].classified = std::make_shared<const Classified>(look);}
    if (getenv("HARD")) { look.transfer = {{0.5, Rgb(1), 0}, {0.5, Rgb(1), 8}, {1, Rgb(1), 8}}; scene.volumes[0].classified = std::make_shared<const Classified>(look);}
    return scene;
}

TEST(OrderOfSurfaces, IsAtLeastOneAtEdgesAndTwoBetweenThem) {
    constexpr double kFinest = 0.2;
    const Image limit = renderScene(dentedBall(kFinest)).image;
    const auto at = [](const Image& image, int x, int y) { return double(image.rgba[image.indexOf(x, y)]); };
    // At an edge the next pixel is brighter or darker by a twentieth of the brightest.
    double brightest = 0;
    for (int y = 0; y < kEdge; ++y)
        for (int x = 0; x < kEdge; ++x) brightest = std::max(brightest, at(limit, x, y));
    const auto atEdge = [&](int x, int y) {
        double least = brightest, most = 0;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                least = std::min(least, at(limit, x + dx, y + dy));
                most = std::max(most, at(limit, x + dx, y + dy));
            }
        return most - least > 0.05 * brightest;
    };
    std::vector<DialDistance> edges, between;
    for (const double size : {2.0, 1.4, 1.0, 0.7, 0.5}) {
        const Image image = renderScene(dentedBall(size)).image;
        double sums[2] = {0, 0};
        int counts[2] = {0, 0};
        for (int y = 1; y < kEdge - 1; ++y)
            for (int x = 1; x < kEdge - 1; ++x) {
                const int kind = atEdge(x, y) ? 1 : 0;
                const double d = at(image, x, y) - at(limit, x, y);
                sums[kind] += d * d;
                counts[kind] += at(limit, x, y) > 0 ? 1 : 0;
            }
        between.push_back({size, std::sqrt(sums[0] / counts[0])});
        edges.push_back({size, std::sqrt(sums[1] / counts[1])});
        std::printf("%g %g %g %d %d\n", size, between.back().distance, edges.back().distance, counts[0], counts[1]);
    }
    std::printf("%g %g\n", *convergenceOrder(between, kFinest), *convergenceOrder(edges, kFinest));
}

}  // namespace
}  // namespace scrim::test
