// SPDX-License-Identifier: Apache-2.0
// Solids as walls for light that has scattered: closed forms, and the path tracer, which knows no cells.
#include "scenes.h"
#include "support/meshes.h"
#include "support/slides.h"

#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/solve/scattered_light.h>
#include <scrim/verify/path_tracer.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtx/string_cast.hpp>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;

// A box of haze of 40^3 voxels around the origin, in which light scatters until it is lost.
ViewScene fullHaze(double sigma, double albedo) {
    Medium medium;
    medium.densityScale = sigma;
    medium.albedo = Rgb(albedo);
    medium.scattering = Scattering::full;
    return orthographicScene(boxField({-20, -20, -20}, {19, 19, 19}), medium, 44, 48);
}

std::shared_ptr<const Solids> wall(const std::shared_ptr<const TriangleMesh>& mesh, double albedo = 0,
                                   const Mat4& wsFromMesh = Mat4(1.0)) {
    return std::make_shared<const Solids>(
        std::vector<Solid>{{"wall", mesh, wsFromMesh, false, true, false, Rgb(albedo)}});
}

// The light that shading looks up.
class LookedUp {
  public:
    explicit LookedUp(const ViewScene& scene) {
        std::size_t bytes = 0;
        m_lights = scatteredLight(
            scene, planTransport(scene), {}, [] {}, solved, bytes);
    }
    double at(const Vec3& ws) const {
        Real rgb[3];
        m_lights.at(0).ofVolume.at(0)->sample(ws, rgb);
        return double(rgb[1]);
    }
    Solved solved;

  private:
    std::vector<CellLight> m_lights;
};

std::vector<Vec3> placesWithin(double half, double step) {
    std::vector<Vec3> places;
    for (double z = -half; z <= half; z += step)
        for (double y = -half; y <= half; y += step)
            for (double x = -half; x <= half; x += step) places.emplace_back(x, y, z);
    return places;
}

// A closed box in a cloud, aligned with the cells or not, keeps the light of a lamp in it, and the light around it out.
// Places are anywhere, so that the look-up next to a wall counts, too.
TEST(Walls, OfAClosedBoxKeepLightInAndOut) {
    const double half = 7.3;
    const Mat4 turned = glm::rotate(Mat4(1.0), 0.7, glm::normalize(Vec3(1, 2, 0.5)));
    for (const Mat4& wsFromMesh : {Mat4(1.0), turned})
        for (const bool lampInside : {false, true}) {
            ViewScene scene = fullHaze(0.1, 0.95);
            if (lampInside)
                scene.lights = {lamp({0.3, 0.2, 0.1}, 100)};
            else
                scene.ambient = Rgb(1);
            const LookedUp open(scene);
            scene.solids = wall(roomMesh(Vec3(-half), Vec3(half)), 0, wsFromMesh);
            const LookedUp closed(scene);
            EXPECT_TRUE(closed.solved.converged);
            int dark = 0;
            for (const Vec3& ws : placesWithin(15, 1.37)) {
                const Vec3 inMesh = glm::abs(transformPoint(glm::inverse(wsFromMesh), ws));
                const double out = std::max({inMesh.x, inMesh.y, inMesh.z}) - half;
                if (std::abs(out) < 1e-3) continue;
                if ((out < 0) != lampInside) {
                    EXPECT_LT(closed.at(ws), 1e-3 * open.at(ws)) << glm::to_string(ws);
                    ++dark;
                } else {
                    EXPECT_GT(closed.at(ws), 0.01 * open.at(ws)) << glm::to_string(ws);
                }
            }
            EXPECT_GT(dark, 100);
        }
}

// Light from outside of all cells does not come through walls that stand there.
TEST(Walls, BeyondTheCellsKeepTheSkyOut) {
    ViewScene scene = fullHaze(0.05, 0.9);
    scene.ambient = Rgb(1);
    scene.solids = wall(roomMesh(Vec3(-100), Vec3(90)));
    EXPECT_EQ(LookedUp(scene).at({1, 2, 3}), 0);
    // Half of the sky, above a floor: the mean over all directions is half of it where the haze is thin.
    scene = fullHaze(1e-4, 0.9);
    scene.ambient = Rgb(1);
    scene.solids = wall(squareMesh({0, -30, 0}, {0, 1, 0}, 3000));
    EXPECT_NEAR(LookedUp(scene).at({1, 2, 3}), 0.5, 0.01);
}

// Black walls on both sides of an eternal slab of haze under an even glow: the mean radiance in its middle is 1 - E2 of
// half its optical depth, for haze that only glows.
TEST(Walls, OnBothSidesOfASlabAreDark) {
    const double sigma = 0.1, half = 6;
    ViewScene scene = fullHaze(sigma, 1e-9);
    scene.volumes[0].emission = {{densityOf(scene.volumes[0]), Rgb(sigma)}};
    // The haze's edge is 14 and more away from the middle, so what is missing of the slab there is e^-1.4 of the light
    // in a band of 2 half / 14 of the solid angle: cells, too, are within less than that of it.
    auto plates = std::make_shared<TriangleMesh>(*squareMesh({0, half, 0}, {0, 1, 0}, 500));
    const auto lower = squareMesh({0, -half, 0}, {0, 1, 0}, 500);
    for (const Vec3& p : lower->points) plates->points.push_back(p);
    for (const auto& t : lower->triangles) plates->triangles.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
    scene.solids = wall(plates);
    scene.dials.scatterCell = 1;
    // Brute force over directions, with the box's sides.
    const auto radiance = [&](const Vec3& ws, const Vec3& way) {
        double length = 1e9;
        for (int axis = 0; axis < 3; ++axis) {
            const double far = axis == 1 ? half : 20, low = axis == 1 ? -half : -20.5, high = axis == 1 ? far : 19.5;
            if (way[axis] != 0) length = std::min(length, ((way[axis] > 0 ? high : low) - ws[axis]) / way[axis]);
        }
        return -std::expm1(-sigma * length);
    };
    const LookedUp light(scene);
    for (const Vec3& ws : {Vec3(0, 0.1, 0), Vec3(2, 3.2, 1), Vec3(-4, -4.4, 3)}) {
        double sum = 0;
        constexpr int kSteps = 200;
        for (int i = 0; i < kSteps; ++i)
            for (int j = 0; j < 2 * kSteps; ++j) {
                const double y = -1 + (i + 0.5) * 2 / kSteps, turn = kPi * (j + 0.5) / kSteps;
                const double across = std::sqrt(1 - y * y);
                sum += radiance(ws, {across * std::cos(turn), y, across * std::sin(turn)}) / (2 * kSteps * kSteps);
            }
        // Diamond differences are of second order: cells of 0.1 mean free paths, and 64 directions.
        EXPECT_NEAR(light.at(ws) / sum, 1, 0.02) << glm::to_string(ws);
    }
}

// A lamp in the middle of a white ball: the radiance in it is Phi / (pi A) rho / (1 - rho), an integrating sphere.
// Cells make stairs of the ball, in which light is reflected more often than by the ball.
TEST(Walls, OfAWhiteBallAreAnIntegratingSphere) {
    const double radius = 17.2, albedo = 0.8, sigma = 1e-4;
    ViewScene scene = fullHaze(sigma, 1);
    scene.lights = {lamp({0.2, 0.1, 0.3}, 1)};
    scene.solids = wall(ballMesh({0.2, 0.1, 0.3}, radius), albedo);
    const double area = 4 * kPi * radius * radius;
    const double expected = 4 * kPi / (kPi * area) * albedo / (1 - albedo);
    const LookedUp light(scene);
    EXPECT_TRUE(light.solved.converged);
    double worst = 0;
    // Stairs have the ball's volume and surface but for half a cell here and there: 3 % of the radius are half of one.
    for (const Vec3& ws : placesWithin(9, 3)) worst = std::max(worst, std::abs(light.at(ws) / expected - 1));
    EXPECT_LT(worst, 0.03);
    // So it is for the path tracer, but for the light that scatters twice, which is less than sigma times the radius.
    const PathTracer tracer(scene);
    double mean = 0, variance = 0;
    const int pixels[] = {20, 22, 24, 26};
    for (const int x : pixels)
        for (const int y : pixels) {
            const Estimate estimate = tracer.pixel(x, y, 4096);
            const double wsX = (x + 0.5) * 44 / 48 - 22 - 0.2, wsY = 22 - (y + 0.5) * 44 / 48 - 0.1;
            const double chord = 2 * std::sqrt(radius * radius - wsX * wsX - wsY * wsY);
            mean += estimate.mean.y / (expected * sigma * chord) / 16;
            variance += estimate.variance.y / std::pow(expected * sigma * chord * 16, 2);
        }
    EXPECT_NEAR(mean, 1, 0.01 + 3 * std::sqrt(variance));
}

// A room full of haze, 0.3 mean free paths wide, into which the sun shines through a window.
TEST(Walls, OfARoomOfHazeAgreeWithThePathTracer) {
    struct Case {
        double albedo, cell, most;
        int paths;
    };
    // The room is 20 cells of two voxels wide. Walls move by up to half a cell, and what white ones send back is
    // inverse to their surface: if faces did not make up for it, 3.4 % would be left with cells of two voxels.
    for (const Case& c : {Case{0, 2, 0.01, 1024}, Case{0.8, 1, 0.02, 2048}, Case{0.8, 2, 0.03, 1024}}) {
        ViewScene scene = fullHaze(0.3 / 40, 0.9);
        scene.lights = {distantLight({-1, -0.6, -0.3})};
        scene.solids =
            wall(roomMesh({-20.7, -20.9, -20.6}, {20.3, 20.2, 20.1}, 1, {0.3, 0.35}, {0.65, 0.75}), c.albedo);
        scene.dials.scatterCell = c.cell;
        const BlockError e = blockError(scene, c.paths);
        EXPECT_LT(e.error, c.most + e.noise) << c.albedo << " " << c.cell << ", noise " << e.noise;
        EXPECT_GT(e.share, 0.1) << c.albedo;
    }
}

// Where walls stand in a cloud 20 mean free paths thick, larger cells cannot help, but the solve needs few sweeps as
// well: less than for every order of scattering, of which there are 100.
TEST(Walls, InAThickCloudNeedFewSweeps) {
    for (const double g : {0.0, 0.6})
        for (const double albedo : {0.0, 0.9}) {
            ViewScene scene = fullHaze(0.5, 0.99);
            scene.volumes[0].medium.phase.g = g;
            scene.lights = {distantLight({-1, -0.6, -0.3})};
            scene.solids = wall(squareMesh({1, 2, 3}, {1, 0.5, 0.2}, 12.3), albedo);
            const LookedUp light(scene);
            EXPECT_TRUE(light.solved.converged) << albedo;
            EXPECT_LT(light.solved.sweeps, 40) << albedo << " " << g;
        }
}

// White walls light the haze before them, the darker the less, each in its colour.
TEST(Walls, SendBackTheirOwnColour) {
    ViewScene scene = fullHaze(1e-4, 0.5);
    scene.lights = {distantLight({0, -1, 0})};
    scene.solids = std::make_shared<const Solids>(std::vector<Solid>{
        {"floor", squareMesh({0, -20.2, 0}, {0, 1, 0}, 20), Mat4(1.0), false, true, false, {0.8, 0.4, 0}}});
    const TransportPlan plan = planTransport(scene);
    EXPECT_EQ(solvesOf(scene, plan), 3);
    std::size_t bytes = 0;
    Solved solved;
    const auto lights = scatteredLight(
        scene, plan, {}, [] {}, solved, bytes);
    Real rgb[3];
    lights.at(0).ofVolume.at(0)->sample({0, -10, 0}, rgb);
    EXPECT_NEAR(double(rgb[1] / rgb[0]), 0.5, 1e-3);
    EXPECT_NEAR(double(rgb[2]), 0, 3e-3 * double(rgb[0]));
}

// The sum of all light of the picture's rows with these cells, relative to that with cells of half a voxel.
double sumWithCells(ViewScene scene, double cell) {
    const auto sum = [&](double edge) {
        scene.dials.scatterCell = edge;
        scene.dials.scatterDirections = 64;
        const Image image = renderScene(scene).image;
        double all = 0;
        for (std::size_t i = 1; i < image.rgba.size(); i += 4) all += double(image.rgba[i]);
        return all;
    };
    return sum(cell) / sum(0.5);
}

// A picture of squares of two voxels: at the centres of cells of four voxels it is white or black by chance, and the
// light that scatters was up to 47 % off.
TEST(FirstLight, OfASlideIsTheMeanOverEachCell) {
    ViewScene scene = fullHaze(0.03, 0.9);
    scene.lights = {
        distantSlide({-1, -0.15, -0.1}, 16, makeTexture(8, 8, [](int x, int y) { return Rgb((x + y) % 2); }))};
    for (const double cell : {2.4, 4.0}) EXPECT_NEAR(sumWithCells(scene, cell), 1, 0.03) << cell;
}

// A lamp's cone of a voxel or two.
TEST(FirstLight, OfANarrowConeIsTheMeanOverEachCell) {
    ViewScene scene = fullHaze(0.03, 0.9);
    Light light = lamp({30, 0.7, 0.4}, 1000);
    Light::Spot spot;
    spot.coneAngle = 4;
    light.kind = spot;
    light.wsDirection = {-1, 0, 0};
    scene.lights = {light};
    for (const double cell : {2.4, 4.0}) EXPECT_NEAR(sumWithCells(scene, cell), 1, 0.06) << cell;
}

}  // namespace
}  // namespace scrim::test
