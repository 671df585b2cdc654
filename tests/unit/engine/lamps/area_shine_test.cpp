// SPDX-License-Identifier: Apache-2.0
// The solid angle of surfaces that shine, the directions towards them and what phase functions show of them, beside
// sums over their elements, and the mean over paths, beside sums over many points of these.
#include <scrim/engine/lamps/area_shine.h>

#include "support/meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;

Light areaOf(AreaShape shape, double width, double height, double radius) {
    Light light;
    Light::Area area;
    area.shape = shape;
    area.width = width;
    area.height = height;
    area.radius = radius;
    light.kind = area;
    light.wsPosition = {0.4, -1.3, 2.1};
    light.wsDirection = glm::normalize(Vec3(0.3, -0.8, 0.5));
    return light;
}

std::vector<Light> smoothLights() {
    return {areaOf(AreaShape::rectangle, 3, 0.7, 0), areaOf(AreaShape::disk, 0, 0, 1.2),
            areaOf(AreaShape::cylinder, 4, 0, 0.3), areaOf(AreaShape::cylinder, 0.8, 0, 1.5)};
}

Light meshOf(std::shared_ptr<const TriangleMesh> mesh) {
    Light light = areaOf(AreaShape::mesh, 0, 0, 0);
    std::get<Light::Area>(light.kind).surface = std::move(mesh);
    return light;
}

// A ball of flat faces, and a bowl, whose triangles see each other.
std::vector<Light> meshLights() {
    const Vec3 middle = smoothLights().front().wsPosition;
    const auto ball = std::make_shared<TriangleMesh>(*ballMesh(middle, 0.8, 5)),
               bowl = std::make_shared<TriangleMesh>(*ballMesh(middle, 1.4, 6));
    turnOver(*ball);  // ballMesh has its front inside, and triangles without an area at its poles
    for (TriangleMesh* mesh : {ball.get(), bowl.get()})
        std::erase_if(mesh->triangles, [&](const auto& t) {
            return glm::length(glm::cross(mesh->points[t[1]] - mesh->points[t[0]],
                                          mesh->points[t[2]] - mesh->points[t[0]])) < 1e-9;
        });
    std::erase_if(bowl->triangles, [&](const auto& t) {
        return bowl->points[t[0]].z + bowl->points[t[1]].z + bowl->points[t[2]].z > 3 * middle.z;
    });
    return {meshOf(ball), meshOf(bowl)};
}

std::vector<Light> lights() {
    std::vector<Light> all = smoothLights();
    for (const Light& light : meshLights()) all.push_back(light);
    return all;
}

// To all sides alike, so that what is shown is the solid angle.
AreaShine evenShine(const Light& light) {
    return {light, {Octave{{}, 1, 4 * kPi}}, {}};
}

// The sum over n x n elements of weight(direction to the element) times area times the cosine over the squared
// distance.
template <class Sum, class Weight>
Sum sumOfElements(const Light& light, const Vec3& ws, int n, const Weight& weight) {
    const Light::Area& area = *light.area();
    const Mat3 frame = lightFrame(light);
    Sum sum(0);
    if (area.surface) {
        const int parts = n / 10;
        for (std::size_t t = 0; t < area.surface->triangles.size(); ++t)
            for (int i = 0; i < parts * parts; ++i) {
                const Vec3 cross = area.surface->cross(t) / double(2 * parts * parts),
                           way = ws - area.surface->place(t, {(i % parts + 0.5) / parts, (i / parts + 0.5) / parts});
                const double r = glm::length(way);
                sum += std::max(glm::dot(way, cross), 0.0) / (r * r * r) * weight(-way / r);
            }
        return sum;
    }
    for (int i = 0; i < n * n; ++i) {
        const double u = (i % n + 0.5) / n, v = (i / n + 0.5) / n, turn = 2 * kPi * v;
        Vec3 at((u - 0.5) * area.width, (v - 0.5) * area.height, 0), normal(0, 0, 1);
        if (area.shape == AreaShape::disk) at = area.radius * std::sqrt(u) * Vec3(std::cos(turn), std::sin(turn), 0);
        if (area.shape == AreaShape::cylinder) {
            normal = {0, std::cos(turn), std::sin(turn)};
            at = area.radius * normal + Vec3((u - 0.5) * area.width, 0, 0);
        }
        const Vec3 way = ws - (light.wsPosition + frame * at);
        const double r = glm::length(way);
        sum += area.area() / (n * n) * std::max(glm::dot(way, frame * normal), 0.0) / (r * r * r) * weight(-way / r);
    }
    return sum;
}

class Draw {
  public:
    double in(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(m_engine); }
    Vec3 around(double half) { return {in(-half, half), in(-half, half), in(-half, half)}; }

  private:
    std::mt19937 m_engine{7};
};

// Elements of a size e sum up to their surface at a distance d to about (e / d)^2. Parts of a mesh of a radius r that
// count as their middle are off by that of (r / d)^2, a hundredth.
TEST(AreaShine, IsTheSumOfElements) {
    constexpr int kElements = 500;
    Draw draw;
    for (const Light& light : lights()) {
        const AreaShine shine = evenShine(light);
        for (int n = 0; n < 40; ++n) {
            const Vec3 ws = light.wsPosition + draw.around(3);
            if (shine.distance(ws) < 0.1) continue;
            const double expected = sumOfElements<double>(light, ws, kElements, [](const Vec3&) { return 1.0; });
            EXPECT_NEAR(shine.at(ws), expected, (light.area()->surface ? 1e-2 : 2e-3) * expected + 1e-5)
                << int(light.area()->shape) << ", " << shine.distance(ws);
        }
    }
}

// For disks by a polygon of twelve corners, which is a tenth of the radius off between them.
TEST(AreaShine, KnowsTheMeanOfTheDirectionsTowardsIt) {
    constexpr int kElements = 300;
    Draw draw;
    for (const Light& light : lights()) {
        const AreaShine shine = evenShine(light);
        for (int n = 0; n < 40; ++n) {
            const Vec3 ws = light.wsPosition + draw.around(3);
            if (shine.distance(ws) < 0.3) continue;
            const Vec3 expected = sumOfElements<Vec3>(light, ws, kElements, [](const Vec3& way) { return way; });
            EXPECT_LT(glm::distance(shine.towards(ws), expected),
                      (light.area()->surface ? 1e-2 : 4e-3) * glm::length(expected) + 1e-5)
                << int(light.area()->shape) << ", " << shine.distance(ws);
        }
    }
}

// Light is shown by its angle to the eye. The lobe is 0.4 wide, as wide as parts of the surface, whose shapes differ
// from caps: a surface as a whole, one cap, would be 10 to 40 % off at places close to it.
TEST(AreaShine, ShowsWhatPhaseFunctionsMakeOfItsDirections) {
    constexpr int kElements = 300;
    Phase phase;
    phase.type = PhaseType::henyeyGreenstein;
    phase.g = 0.6;
    Camera camera;
    camera.wsPosition = {3, 1, 4};
    Draw draw;
    for (const Light& light : lights()) {
        const AreaShine shine(light, {Octave{phase, 1, 2}}, camera);
        double squares = 0, all = 0;
        for (int n = 0; n < 200; ++n) {
            const Vec3 ws = light.wsPosition + draw.around(1.5);
            if (shine.distance(ws) < 0.15) continue;
            const Vec3 toEye = glm::normalize(camera.wsPosition - ws);
            const double expected = sumOfElements<double>(
                light, ws, kElements, [&](const Vec3& way) { return 2 * phaseValue(phase, -glm::dot(way, toEye)); });
            squares += std::pow(shine.shown(ws) - expected, 2);
            all += expected * expected;
        }
        EXPECT_LT(std::sqrt(squares / all), 0.02) << int(light.area()->shape);
    }
}

TEST(AreaShine, FillsAHalfOfAllDirectionsAtItsSurfaceAndNoneBehind) {
    for (const Light& light : smoothLights()) {
        const AreaShine shine = evenShine(light);
        const Mat3 frame = lightFrame(light);
        const bool round = light.area()->shape == AreaShape::cylinder;
        const Vec3 normal = round ? frame[1] : frame[2],
                   surface = light.wsPosition + light.area()->radius * (round ? normal : Vec3(0));
        // A cylinder fills 4 asin(R / r), which is 4 sqrt(2e-6 / R) less.
        EXPECT_NEAR(shine.at(surface + 1e-6 * normal), 2 * kPi, 0.011);
        EXPECT_EQ(shine.at(surface - 1e-6 * normal), 0);
    }
}

// Within a closed mesh no side that shines is seen.
TEST(AreaShine, OfAMeshFillsAHalfOfAllDirectionsAtAFaceAndNoneWithin) {
    const Light light = meshLights().front();
    const TriangleMesh& mesh = *light.area()->surface;
    const AreaShine shine = evenShine(light);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3 normal = glm::normalize(mesh.cross(t));
        EXPECT_NEAR(shine.at(mesh.middle(t) + 1e-6 * normal), 2 * kPi, 1e-4);
        EXPECT_NEAR(shine.at(mesh.middle(t) - 1e-6 * normal), 0, 1e-9);
        // From the middle to as far again beyond the face.
        const double r = glm::distance(mesh.middle(t), light.wsPosition);
        const auto pieces = shine.along(light.wsPosition, 2.0 * (mesh.middle(t) - light.wsPosition), 0);
        for (const AreaShine::Piece& piece : pieces.used())
            EXPECT_GT(glm::distance(piece.ws, light.wsPosition), 0.99 * r);
    }
}

TEST(AreaShine, ServesWhatShinesEvenly) {
    Light light = areaOf(AreaShape::disk, 0, 0, 1);
    EXPECT_TRUE(AreaShine::serves(light));
    light.slide.emplace();
    EXPECT_FALSE(AreaShine::serves(light));
    light = areaOf(AreaShape::rectangle, 1, 1, 0);
    std::get<Light::Area>(light.kind).spread = 120;
    EXPECT_FALSE(AreaShine::serves(light));
    EXPECT_FALSE(AreaShine::serves(areaOf(AreaShape::sphere, 0, 0, 1)));
    EXPECT_FALSE(AreaShine::serves(areaOf(AreaShape::mesh, 0, 0, 1)));
}

// Paths towards surfaces and past them, from a tenth of their size up to it. Those that graze a rim, where light is a
// step, have the most of the error: a few per cent of what paths have on average, and no bias.
TEST(AreaShine, HasItsMeanOverPaths) {
    constexpr int kPaths = 300;
    Draw draw;
    for (const Light& light : lights()) {
        const AreaShine shine = evenShine(light);
        const int points = light.area()->surface ? 1'000 : 10'000;
        double squares = 0, all = 0, sum = 0;
        for (int n = 0; n < kPaths; ++n) {
            const double length = std::pow(10, draw.in(-1, 0.2)), tau = draw.in(0, 1);
            const Vec3 way = length * glm::normalize(draw.around(1)),
                       begin = light.wsPosition + draw.around(2) - draw.in(0, 1) * way;
            double mean = 0, seen = 0, found = 0;
            for (int i = 0; i < points; ++i) {
                const double s = (i + 0.5) / points, weight = std::exp(-tau * s);
                mean += weight * shine.at(begin + s * way);
                seen += weight;
            }
            mean /= seen;
            for (const AreaShine::Piece& piece : shine.along(begin, way, tau).used()) found += piece.shown;
            squares += std::pow(found - mean, 2);
            all += mean;
            sum += found;
        }
        EXPECT_LT(std::sqrt(squares / kPaths), 0.04 * all / kPaths) << int(light.area()->shape);
        EXPECT_NEAR(sum, all, 0.004 * all) << int(light.area()->shape);
    }
}

// The places of pieces are those about which light that changes evenly is to be looked up.
TEST(AreaShine, HasTheMiddleOfItsLightOnPaths) {
    constexpr int kPoints = 2'000;
    Draw draw;
    for (const Light& light : lights()) {
        const AreaShine shine = evenShine(light);
        for (int n = 0; n < 100; ++n) {
            const double length = std::pow(10, draw.in(-1, 0.5));
            const Vec3 way = length * glm::normalize(draw.around(1)),
                       begin = light.wsPosition + draw.around(2) - draw.in(0, 1) * way;
            double sum = 0, places = 0, found = 0;
            for (int i = 0; i < kPoints; ++i) {
                const double s = (i + 0.5) / kPoints, own = shine.at(begin + s * way) / kPoints;
                sum += own, places += own * s;
            }
            for (const AreaShine::Piece& piece : shine.along(begin, way, 0).used())
                found += piece.shown * glm::dot(piece.ws - begin, way) / (length * length);
            EXPECT_NEAR(found, places, 0.03 * sum + 1e-3) << int(light.area()->shape) << ", " << length;
        }
    }
}

}  // namespace
}  // namespace scrim::test
