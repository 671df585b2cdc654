// SPDX-License-Identifier: Apache-2.0
// The reference's view of extended lights, against closed forms and sums over surfaces.
#include "support/meshes.h"
#include "support/slides.h"

#include <scrim/image/sky_parts.h>
#include <scrim/verify/light_rays.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;

Light areaLight(AreaShape shape, double width, double height, double radius) {
    Light light;
    light.kind = Light::Area{shape, width, height, radius};
    return light;  // at the origin, facing -z
}

// Integral of radiance times f(direction) over the light, by the middles of n x n squares.
double integral(const Light& light, const Vec3& ws, int n, const std::function<double(const Vec3&)>& f) {
    const LightRays rays(light);
    double sum = 0;
    for (int i = 0; i < n * n; ++i) {
        const LightRay ray = rays.ray(ws, (Vec2(i % n, i / n) + 0.5) / double(n));
        if (ray.weight != Rgb(0)) sum += ray.weight.x * f(ray.toLight);
    }
    return sum / (n * n);
}
double solidAngle(const Light& light, const Vec3& ws, int n = 16) {
    return integral(light, ws, n, [](const Vec3&) { return 1.0; });
}

// The same by brute force: pieces of the surface, each with its cosine over its squared distance.
double overSurface(const Light& light, const Vec3& ws, const std::function<double(const Vec3&)>& f) {
    const Light::Area& area = *light.area();
    constexpr int kPieces = 1500;
    const double edge = area.shape == AreaShape::disk ? 2 * area.radius : 0;
    const double width = edge > 0 ? edge : area.width, height = edge > 0 ? edge : area.height;
    double sum = 0;
    for (int i = 0; i < kPieces; ++i)
        for (int j = 0; j < kPieces; ++j) {
            const Vec3 at((i + 0.5) / kPieces * width - width / 2, (j + 0.5) / kPieces * height - height / 2, 0);
            if (edge > 0 && glm::length(at) > area.radius) continue;
            const Vec3 to = at - ws;
            const double r = glm::length(to);
            sum += f(to / r) * std::max(0.0, to.z / r) / (r * r);
        }
    return sum * width * height / (double(kPieces) * kPieces);
}

TEST(LightRays, FillTheSolidAngleOfTheLightOnItsAxis) {
    for (const double h : {0.01, 0.5, 2.0, 40.0, 3e4}) {
        const Vec3 ws(0, 0, -h);
        const double s = std::hypot(h, 1.5);
        EXPECT_NEAR(solidAngle(areaLight(AreaShape::disk, 0, 0, 1.5), ws) / (2 * kPi * 2.25 / (s * (s + h))), 1, 1e-6);
        // Far away they are differences of cosines and of angles that are nearly the same.
        const double rectangle = 4 * std::asin(1.5 / std::sqrt((2.25 + h * h) * (1 + h * h)));
        EXPECT_NEAR(solidAngle(areaLight(AreaShape::rectangle, 3, 2, 0), ws) / rectangle, 1, 1e-6) << h;
        if (h > 1.5) {
            const double sine2 = 2.25 / (h * h);
            EXPECT_NEAR(solidAngle(areaLight(AreaShape::sphere, 0, 0, 1.5), ws),
                        2 * kPi * sine2 / (1 + std::sqrt(1 - sine2)), 1e-9);
        }
    }
}

// Pieces of 1 / 1500 of the light, and a disk's border in steps of them: three digits.
TEST(LightRays, AddUpToTheSurfaceFromAnywhereWithAnyWeight) {
    const auto slanted = [](const Vec3& to) { return 1 + 0.5 * to.x - 0.3 * to.y * to.z; };
    for (const Vec3& ws : {Vec3(0.2, 0.1, -0.4), Vec3(0.9, -0.4, -1), Vec3(2.5, 1, -0.7), Vec3(-4, 6, -3)})
        for (const Light& light :
             {areaLight(AreaShape::disk, 0, 0, 1.2), areaLight(AreaShape::rectangle, 2.6, 1.1, 0)}) {
            const double expected = overSurface(light, ws, slanted);
            EXPECT_NEAR(integral(light, ws, 48, slanted), expected, 2e-3 * expected) << ws.x << ", " << ws.y;
        }
}

// Rays of a cylinder are spread over what it fills of the sky: few of them find that right next to it, too. Its ends
// are far away there, so that it fills 2 asin(radius / distance) times 2.
TEST(LightRays, FillTheSolidAngleOfALongCylinder) {
    for (const double distance : {0.301, 0.4, 1.0}) {
        const double solid = 4 * std::asin(0.3 / distance);
        EXPECT_NEAR(solidAngle(areaLight(AreaShape::cylinder, 400, 0, 0.3), {3, 0, -distance}, 6), solid, 1e-3 * solid);
    }
}

TEST(LightRays, EndOnTheLight) {
    const Vec3 ws(0.7, -0.4, -3);
    for (int i = 0; i < 100; ++i) {
        const Vec2 square((i % 10 + 0.5) / 10, (i / 10 + 0.5) / 10);
        const auto endOf = [&](const Light& light) {
            const LightRay ray = LightRays(light).ray(ws, square);
            return ws + ray.distance * ray.toLight;
        };
        const Vec3 disk = endOf(areaLight(AreaShape::disk, 0, 0, 1));
        EXPECT_NEAR(disk.z, 0, 1e-12);
        EXPECT_LE(glm::length(disk), 1 + 1e-9);
        const Vec3 rectangle = endOf(areaLight(AreaShape::rectangle, 2, 1, 0));
        EXPECT_NEAR(rectangle.z, 0, 1e-12);
        EXPECT_LE(std::abs(rectangle.x), 1 + 1e-9);
        EXPECT_LE(std::abs(rectangle.y), 0.5 + 1e-9);
        EXPECT_NEAR(glm::length(endOf(areaLight(AreaShape::sphere, 0, 0, 1))), 1, 1e-9);
    }
}

Light shining(const TriangleMesh& mesh) {
    Light light;
    light.kind = Light::Area{AreaShape::mesh};
    shineFrom(light, mesh, Mat4(1));
    return light;
}

// The same as `integral`, by rays to places spread evenly over all triangles of a mesh, each of which squares in rows
// would miss. 20,000 places leave a thousandth.
double integralOverMesh(const Light& light, const Vec3& ws, const std::function<double(const Vec3&)>& f) {
    std::vector<Vec2> places;
    for (int i = 0; i < 20000; ++i)
        places.push_back(glm::fract(double(i) * Vec2(0.7548776662466927, 0.5698402909980532)));
    double sum = 0;
    for (const LightRay& ray : LightRays(light).rays(ws, places)) sum += ray.weight.x * f(ray.toLight);
    return sum / double(places.size());
}

// A ball of 19,600 triangles: the same as their sum, from afar and from near. Triangles are 0.045 wide, and their
// middles stand for them in the sum, which is off by a twelfth of the square of that over the distance, 0.2 or more:
// 0.004. From afar all rays have about the same weight, so that few are enough.
TEST(LightRays, OfAMeshOfManyTrianglesAddUpToThem) {
    const Light light = shining(*ballMesh({0.3, 0, 0}, 1, 70));
    const TriangleMesh& mesh = *light.area()->surface;
    const auto slanted = [](const Vec3& to) { return 1 + 0.5 * to.x - 0.3 * to.y * to.z; };
    const LightRays rays(light);
    for (const Vec3& ws : {Vec3(1.5, 0, 0), Vec3(-1, 0.9, 0.4), Vec3(0.3, -3, 2), Vec3(40, 20, 10)}) {
        double expected = 0, sum = 0, squares = 0;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            const Vec3 to = mesh.middle(t) - ws;
            const double r = glm::length(to);
            expected += slanted(to / r) * std::max(-0.5 * glm::dot(mesh.cross(t), to), 0.0) / (r * r * r);
        }
        EXPECT_NEAR(integralOverMesh(light, ws, slanted), expected, 5e-3 * expected) << ws.x;
        for (int i = 0; i < 4096; ++i) {
            const double weight = rays.ray(ws, (Vec2(i % 64, i / 64) + 0.5) / 64.0).weight.x;
            sum += weight / 4096;
            squares += weight * weight / 4096;
        }
        EXPECT_LT(std::sqrt(squares / (sum * sum) - 1), 0.05) << ws.x;
    }
}

// Triangles that lie in the same places and face away from each other, of which each place sees half.
TEST(LightRays, OfASheetOfTwoSidesComeFromTheSideThatIsSeen) {
    TriangleMesh sheet = *squareMesh({0, 0, 0}, {0, 0, 1}, 1);
    for (std::size_t t = 0; t < 2; ++t) {
        const auto [a, b, c] = sheet.triangles[t];
        sheet.triangles.push_back({b, a, c});
    }
    const Light light = shining(sheet);
    for (const Vec3& ws : {Vec3(0, 0, 2), Vec3(0, 0, -2)}) {
        const double expected = 4 * std::asin(1 / (1 + 4.0));
        EXPECT_NEAR(integralOverMesh(light, ws, [](const Vec3&) { return 1.0; }), expected, 1e-3 * expected) << ws.z;
    }
}

TEST(LightRays, ComeFromTheFrontAlone) {
    EXPECT_EQ(solidAngle(areaLight(AreaShape::disk, 0, 0, 1), {0.2, 0, 1}), 0);
    EXPECT_EQ(solidAngle(areaLight(AreaShape::rectangle, 1, 1, 0), {0.2, 0, 1}), 0);
    EXPECT_EQ(solidAngle(areaLight(AreaShape::sphere, 0, 0, 1), {0.2, 0, 0.5}), 0);
}

TEST(LightRays, OfASunStayWithinItsDisk) {
    Light sun;
    sun.kind = Light::Distant(8);
    sun.intensity = Rgb(3);
    EXPECT_NEAR(solidAngle(sun, Vec3(0)), 3, 1e-12);
    // Of a disk of half angle a the mean of the cosine to its axis is (1 + cos a) / 2.
    const double mean = integral(sun, Vec3(0), 32, [](const Vec3& to) { return to.z; });
    EXPECT_NEAR(mean, 1.5 * (1 + std::cos(4 * kPi / 180)), 1e-6);
}

// Against the sum over all pixels of radiance times solid angle times a smooth weight; the pixels are 4 degrees large,
// and their weight is taken at their middle: (4 / 57)^2 / 24 of it.
TEST(LightRays, OfADomeAreItsPicture) {
    constexpr int kWidth = 90, kHeight = 45;
    Light sky;
    sky.kind = Light::Dome{25};
    sky.slide.emplace();
    const auto colour = [](int x, int y) { return Rgb(x > 50 && x < 54 && y == 9 ? 300 : 1 + x % 3); };
    sky.slide->image = makeTexture(kWidth, kHeight, colour);
    const auto weight = [](const Vec3& to) { return 2 + to.x + 0.5 * to.y * to.z; };
    double expected = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            expected += colour(x, y).x * 2 * kPi / kWidth *
                        (std::cos(kPi * y / kHeight) - std::cos(kPi * (y + 1) / kHeight)) *
                        weight(domeDirection(sky, (x + 0.5) / kWidth, (y + 0.5) / kHeight));
    EXPECT_NEAR(integral(sky, Vec3(0), 300, weight), expected, 1e-3 * expected);
}

// A sun beside the picture, of light 2 and 6 in its lower and upper half: rays choose it by its light.
TEST(LightRays, OfADomeHoldTheSunBesideItsPicture) {
    Light sky;
    sky.kind = Light::Dome{25};
    sky.slide.emplace();
    sky.slide->image = makeTexture(90, 45, [](int x, int) { return Rgb(1 + x % 3); });
    const double solidAngle = 2 * kPi * (1 - std::cos(2 * kPi / 180));
    SkyParts parts{{}, sky.slide->image};
    parts.suns.push_back({0.5, 0.3, 4, Rgb(4), {Rgb(2 / solidAngle), Rgb(6 / solidAngle)}});
    const auto weight = [](const Vec3& to) { return 2 + to.x + 0.5 * to.y * to.z; };
    const double without = integral(sky, Vec3(0), 300, weight);
    sky.slide->parts = std::make_shared<const SkyParts>(parts);
    const Vec3 toSun = domeDirection(sky, 0.5, 0.3);
    EXPECT_NEAR(integral(sky, Vec3(0), 300, weight) - without, 4 * weight(toSun), 5e-3 * 4 * weight(toSun));
    const LightRays rays(sky);
    const Vec3 beside = domeDirection(sky, 0.5, 0.32);
    EXPECT_NEAR(rays.from(Vec3(0), toSun).weight.x, 4 / solidAngle, 3);
    const Vec3 lower = domeDirection(sky, 0.5, 0.3 + 1.5 / 180), upper = domeDirection(sky, 0.5, 0.3 - 1.5 / 180);
    EXPECT_NEAR(rays.from(Vec3(0), lower).weight.x, 2 / solidAngle, 3);  // at the middle of the lower strip and below
    EXPECT_NEAR(rays.from(Vec3(0), upper).weight.x, 6 / solidAngle, 3);
    EXPECT_LT(rays.from(Vec3(0), beside).weight.x, 4);
    // The density is that of the rays: as many of them are in the sun, and its integral is 1.
    double within = 0, whole = 0;
    constexpr int kSquares = 200, kRows = 900;
    for (int i = 0; i < kSquares * kSquares; ++i) {
        const LightRay ray = rays.ray(Vec3(0), (Vec2(i % kSquares, i / kSquares) + 0.5) / double(kSquares));
        if (glm::dot(ray.toLight, toSun) > std::cos(2 * kPi / 180)) within += 1.0 / (kSquares * kSquares);
    }
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < 2 * kRows; ++x)
            whole += rays.density(domeDirection(sky, (x + 0.5) / (2 * kRows), (y + 0.5) / kRows)) *
                     std::sin(kPi * (y + 0.5) / kRows) * kPi * kPi / (kRows * kRows);
    EXPECT_NEAR(within / solidAngle / rays.density(toSun), 1, 0.02);
    EXPECT_NEAR(whole, 1, 2e-3);
}

}  // namespace
}  // namespace scrim::test
