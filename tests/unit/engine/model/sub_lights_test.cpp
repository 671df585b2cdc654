// SPDX-License-Identifier: Apache-2.0
// Sub-lights are the light that they stand for: its energy, its place, and, as their number grows, what it sends to any
// point. Closed forms of solid angles are the truth.
#include "support/fields.h"
#include "support/meshes.h"
#include "support/slides.h"

#include <scrim/engine/plan/effects.h>
#include <scrim/scene/picture_cells.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/sweep.h>
#include <scrim/scene/light_at.h>
#include <scrim/solid/triangle_mesh.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <set>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;

Light areaLight(AreaShape shape, double width, double height, double radius) {
    Light light;
    light.kind = Light::Area{shape, width, height, radius};
    return light;  // at the origin, facing -z
}

std::vector<Light> cut(Light light, int samples) {
    light.samples = samples;
    ViewScene scene = orthographicScene(boxField({-2, -2, -2}, {2, 2, 2}), Medium(), 8, 8);
    scene.lights = {light};
    return subLights(scene).lights;
}

// What the engine makes of sub-lights at a point: irradiance of each on whatever faces it, times f(direction to it).
double arriving(const std::vector<Light>& lights, const Vec3& ws, const std::function<double(const Vec3&)>& f) {
    double sum = 0;
    for (const Light& light : lights) {
        if (light.distant()) {
            sum += light.intensity.x * f(-light.wsDirection);
            continue;
        }
        const Vec3 to = light.wsPosition - ws;
        const double r2 = glm::dot(to, to), cosine = std::max(0.0, glm::dot(-to, light.wsDirection) / std::sqrt(r2));
        sum += light.intensity.x * cosine / std::max(r2, light.point().radius * light.point().radius) *
               f(to / std::sqrt(r2));
    }
    return sum;
}
double fluence(const std::vector<Light>& lights, const Vec3& ws) {
    return arriving(lights, ws, [](const Vec3&) { return 1.0; });
}

TEST(SubLights, OfSceneWithoutExtendedLightsAreItsLights) {
    ViewScene scene = orthographicScene(boxField({-2, -2, -2}, {2, 2, 2}), Medium(), 8, 8);
    scene.lights = {distantLight({0, 0, -1}), lamp({0, 9, 0}, 3)};
    scene.lights[0].samples = 7;  // of no meaning here
    const SubLights sub = subLights(scene);
    EXPECT_EQ(sub.lights.size(), 2U);
    EXPECT_EQ(sub.of(PlanLight(1)).wsPosition, Vec3(0, 9, 0));
    EXPECT_EQ(sub.ownerOf(PlanLight(1)), 1);
    EXPECT_EQ(sub.partOf(PlanLight(1)), 0);
    EXPECT_TRUE(sub.lit[0].empty());
}

// A disk seen from its axis fills 2 pi (1 - h / sqrt(h^2 + R^2)), a rectangle 4 asin(ab / sqrt((a^2+h^2)(b^2+h^2)))
// with half edges a and b, a sphere 2 pi (1 - sqrt(1 - R^2 / d^2)). At a distance of its size 64 sub-lights are 0.35 of
// it apart; what such a sum misses is of the order of e^(-2 pi h / spacing) inside and of the spacing squared, 1 / 64,
// at borders that are seen aslant: a hundredth is asked for, and a quarter of that of 16 times as many.
TEST(SubLights, FillTheSolidAngleOfTheirSurface) {
    struct Case {
        const char* name;
        Light light;
        double solidAngle;
    };
    const Vec3 ws(0, 0, -2);
    const Case cases[] = {{"disk", areaLight(AreaShape::disk, 0, 0, 1.5), 2 * kPi * (1 - 2 / std::hypot(2.0, 1.5))},
                          {"rectangle", areaLight(AreaShape::rectangle, 3, 2, 0),
                           4 * std::asin(1.5 / std::sqrt((1.5 * 1.5 + 4) * (1 + 4)))},
                          {"sphere", areaLight(AreaShape::sphere, 0, 0, 1), 2 * kPi * (1 - std::sqrt(1 - 0.25))}};
    for (const Case& c : cases) {
        EXPECT_NEAR(fluence(cut(c.light, 64), ws), c.solidAngle, 0.01 * c.solidAngle) << c.name;
        EXPECT_NEAR(fluence(cut(c.light, 1024), ws), c.solidAngle, 0.0025 * c.solidAngle) << c.name;
    }
}

// Nine elements of a sphere are 5 to 9 % off, brighter on one side than on the other; points that shine evenly are not.
TEST(SubLights, OfASphereBesideTheVolumesFillItsSolidAngleOnAllSides) {
    Light light = areaLight(AreaShape::sphere, 0, 0, 1);
    light.wsPosition = {30, 0, 0};
    const std::vector<Light> lights = cut(light, 9);
    ASSERT_EQ(lights.size(), 9u);
    for (const double d : {4.0, 27.0})
        for (const Vec3& way : {Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, -1), glm::normalize(Vec3(1, -2, 3))}) {
            double fluence = 0;
            for (const Light& one : lights) {
                ASSERT_NE(std::get_if<Light::Point>(&one.kind), nullptr);
                const Vec3 to = one.wsPosition - light.wsPosition - d * way;
                fluence += one.intensity.x / glm::dot(to, to);
            }
            const double solidAngle = 2 * kPi * (1 - std::sqrt(1 - 1 / (d * d)));
            EXPECT_NEAR(fluence, solidAngle, 0.02 * solidAngle) << d;
        }
}

// A tube bent to a ring of radius 5, of which the volume in its middle sees all: parts of it shine as the tube does
// there, and few are enough. Beside the middle, too.
TEST(SubLights, OfAMeshShineAsTheirPartsOfIt) {
    TriangleMesh ring;
    constexpr std::uint32_t kAlong = 60, kAround = 24;
    for (std::uint32_t i = 0; i < kAlong; ++i)
        for (std::uint32_t j = 0; j < kAround; ++j) {
            const double t = 2 * kPi * i / kAlong, a = 2 * kPi * j / kAround;
            const Vec3 out(std::cos(t), 0, std::sin(t));
            ring.points.push_back(5.0 * out + 0.2 * (std::cos(a) * out + std::sin(a) * Vec3(0, 1, 0)));
            const std::uint32_t b = i * kAround + (j + 1) % kAround, across = (i + 1) % kAlong * kAround;
            ring.triangles.push_back({i * kAround + j, b, across + (j + 1) % kAround});
            ring.triangles.push_back({i * kAround + j, across + (j + 1) % kAround, across + j});
        }
    Light light;
    light.kind = Light::Area{AreaShape::mesh};
    shineFrom(light, ring, Mat4(1));
    const MeshPlaces places(*light.area()->surface);
    for (const Vec3& ws : {Vec3(0, 0, 0), Vec3(2, -1, 0), Vec3(-1, 1.5, 2)}) {
        double expected = 0, found = 0;
        constexpr int kPlaces = 40000;
        for (int i = 0; i < kPlaces; ++i) {
            const auto [at, normal] = places.at({(i + 0.5) / kPlaces, std::fmod(i * std::numbers::phi, 1.0)});
            const Vec3 way = ws - at;
            expected += places.area() / kPlaces * std::max(glm::dot(way, normal), 0.0) / std::pow(glm::length(way), 3);
        }
        for (const Light& one : cut(light, 40)) found += LightAt(one, 0).at(ws).irradiance.x;
        EXPECT_NEAR(found, expected, 0.02 * expected) << ws.x;
    }
}

// The front and the back of a sheet, whose triangles lie in the same places, are not taken for one part, which would
// shine like neither (and be 13 % off).
TEST(SubLights, OfASheetThatShinesToBothSidesFillTheSolidAngleOfARectangle) {
    TriangleMesh sheet;
    sheet.points = {{-1.5, -1, 0}, {1.5, -1, 0}, {1.5, 1, 0}, {-1.5, 1, 0}};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}, {2, 1, 0}, {3, 2, 0}};
    Light light;
    light.kind = Light::Area{AreaShape::mesh};
    shineFrom(light, sheet, Mat4(1));
    const double solidAngle = 4 * std::asin(1.5 / std::sqrt((1.5 * 1.5 + 4) * (1 + 4)));
    for (const double z : {-2.0, 2.0})
        EXPECT_NEAR(fluence(cut(light, 128), {0, 0, z}), solidAngle, 0.02 * solidAngle) << z;
}

// Beside a part there is no point that stands for it, so what arrives there does not count for how strong the part is:
// the middle of a box is as near to it as its sides are large. Its side at 0.2 is all that a place in front of it sees.
TEST(SubLights, OfABoxAmongTheVolumesFillTheSolidAngleOfItsSides) {
    TriangleMesh box;
    for (int i = 0; i < 8; ++i) box.points.push_back(0.2 * Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    for (const auto& [a, b, c, d] : {std::array<std::uint32_t, 4>{0, 2, 3, 1},
                                     {4, 5, 7, 6},
                                     {0, 1, 5, 4},
                                     {2, 6, 7, 3},
                                     {0, 4, 6, 2},
                                     {1, 3, 7, 5}}) {
        box.triangles.push_back({a, b, c});
        box.triangles.push_back({a, c, d});
    }
    Light light;
    light.kind = Light::Area{AreaShape::mesh};
    shineFrom(light, box, Mat4(1));
    const double h2 = 1.3 * 1.3, solidAngle = 4 * std::asin(0.04 / (0.04 + h2));
    for (const Vec3& ws : {Vec3(1.5, 0, 0), Vec3(0, -1.5, 0), Vec3(0, 0, 1.5)})
        EXPECT_NEAR(fluence(cut(light, 256), ws), solidAngle, 0.02 * solidAngle) << ws.x << " " << ws.y;
}

// Irradiance of a surface that faces the light: a disk on its axis pi L R^2 / (R^2 + h^2), a sphere pi L R^2 / d^2.
TEST(SubLights, GiveTheIrradianceOfTheirSurface) {
    const auto facing = [](const Vec3& to) { return std::max(0.0, to.z); };
    EXPECT_NEAR(arriving(cut(areaLight(AreaShape::disk, 0, 0, 1.5), 1024), {0, 0, -2}, facing), kPi * 2.25 / (2.25 + 4),
                0.0025 * kPi * 2.25 / 6.25);
    EXPECT_NEAR(arriving(cut(areaLight(AreaShape::sphere, 0, 0, 1), 1024), {0, 0, -2}, facing), kPi / 4,
                0.0025 * kPi / 4);
}

TEST(SubLights, ShineToTheirFrontAlone) {
    EXPECT_EQ(fluence(cut(areaLight(AreaShape::disk, 0, 0, 1), 50), {0.3, 0, 0.5}), 0);
    EXPECT_EQ(fluence(cut(areaLight(AreaShape::rectangle, 1, 2, 0), 50), {0.3, 0, 0.5}), 0);
    EXPECT_EQ(fluence(cut(areaLight(AreaShape::sphere, 0, 0, 1), 50), {0.2, 0.1, 0}), 0);
}

// Whatever their number, nowhere more than the half-space in front of a surface holds: 2 pi, and as much again from a
// few neighbours of the one that a point is closest to.
TEST(SubLights, StayFiniteAtTheirSurface) {
    for (const int samples : {1, 8, 64}) {
        const std::vector<Light> lights = cut(areaLight(AreaShape::rectangle, 2, 2, 0), samples);
        for (const Light& light : lights)
            EXPECT_LE(fluence(lights, light.wsPosition - Vec3(0, 0, 1e-3)), 4 * kPi) << samples;
    }
}

TEST(SubLights, OfADomeAreTheWholeSphere) {
    Light sky;
    sky.kind = Light::Dome();
    sky.intensity = Rgb(0.5);
    for (const int samples : {2, 50, 200}) {
        const std::vector<Light> lights = cut(sky, samples);
        ASSERT_EQ(int(lights.size()), samples);
        Vec3 sum(0);
        for (const Light& light : lights) sum += light.wsDirection / double(samples);
        EXPECT_NEAR(fluence(lights, Vec3(0)), 4 * kPi * 0.5, 1e-9);
        // Half of them up, half down; around the axis within one of them.
        EXPECT_LT(glm::length(sum), 1.0 / std::sqrt(samples));
    }
}

TEST(SubLights, OfASunShareItsIrradianceOverItsDisk) {
    Light sun = distantLight({1, -2, 0.5}, 3);
    sun.kind = Light::Distant(10);
    const std::vector<Light> lights = cut(sun, 40);
    ASSERT_EQ(lights.size(), 40u);
    EXPECT_NEAR(fluence(lights, Vec3(0)), 3, 1e-12);
    Vec3 mean(0);
    double widest = 1;
    for (const Light& light : lights) {
        mean += light.wsDirection / 40.0;
        widest = std::min(widest, glm::dot(light.wsDirection, sun.wsDirection));
    }
    EXPECT_GE(widest, std::cos(5 * kPi / 180));
    EXPECT_LT(widest, std::cos(4.5 * kPi / 180));
    // The mean of a disk evenly lit is its middle: within a part of the sub-lights' spacing, 10 / sqrt(40) degrees.
    EXPECT_GT(glm::dot(glm::normalize(mean), sun.wsDirection), std::cos(0.5 * kPi / 180));
    EXPECT_EQ(cut(sun, 1)[0].wsDirection, sun.wsDirection);
}

TEST(SubLights, LieInAllRowsAndColumnsOfTheirSquare) {
    for (const int samples : {1, 2, 7, 21, 30, 64}) {
        std::set<long> columns, rows;
        for (const Light& light : cut(areaLight(AreaShape::rectangle, samples, samples, 0), samples)) {
            columns.insert(std::lround(2 * light.wsPosition.x));
            rows.insert(std::lround(2 * light.wsPosition.y));
        }
        EXPECT_EQ(int(columns.size()), samples);
        EXPECT_EQ(int(rows.size()), samples);
    }
}

TEST(DomeDirection, IsThatOfUsdLux) {
    Light sky;
    sky.kind = Light::Dome();
    const auto expect = [&](double u, double v, const Vec3& expected) {
        EXPECT_LT(glm::distance(domeDirection(sky, u, v), expected), 1e-12) << u << ", " << v;
    };
    expect(0.5, 0.5, {0, 0, 1});
    expect(0.75, 0.5, {-1, 0, 0});
    expect(0.25, 0.5, {1, 0, 0});
    expect(0, 0.5, {0, 0, -1});
    expect(0.3, 0, {0, 1, 0});
    expect(0.3, 1, {0, -1, 0});
    sky.kind = Light::Dome{90};
    expect(0.5, 0.5, {1, 0, 0});
    sky.kind = Light::Dome();
    sky.wsUp = {0, 0, 2};
    expect(0.5, 0, {0, 0, 1});
    expect(0.5, 0.5, {0, -1, 0});
}

Light pictureSky(std::shared_ptr<const Texture> picture) {
    Light sky;
    sky.kind = Light::Dome();
    sky.slide.emplace();
    sky.slide->image = std::move(picture);
    return sky;
}

// The sum over pixels of their radiance times their solid angle, whatever the number of cells, of a picture with more
// pixels than cells are made of.
TEST(DomeCells, HoldAllLightOfThePicture) {
    constexpr int kWidth = 1100, kHeight = 550;
    const auto colour = [](int x, int y) { return Rgb(1 + x % 7, y % 5, x == 900 && y == 200 ? 5e4 : 0.25); };
    const Light sky = pictureSky(makeTexture(kWidth, kHeight, colour));
    Rgb expected(0);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            expected += colour(x, y) * 2.0 * kPi / double(kWidth) *
                        (std::cos(kPi * y / kHeight) - std::cos(kPi * (y + 1) / kHeight));
    for (const int samples : {1, 5, 60}) {
        const std::vector<Light> lights = cut(sky, samples);
        EXPECT_EQ(int(lights.size()), samples);
        Rgb sum(0);
        for (const Light& light : lights) sum += light.intensity;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], expected[c], 1e-9 * expected[c]) << samples;
    }
}

// A sky is as wide as it is, however few pixels its picture has: the mean of cos^2 to any direction is a third. Cells
// of 4 pi / 256 are 13 degrees wide; what their middles miss is of second order in that, 0.01.
TEST(DomeCells, OfAPictureOfOnePixelAreTheWholeSky) {
    for (const Int2 size : {Int2(1, 1), Int2(4, 2), Int2(2, 100)}) {
        const std::vector<Light> lights =
            cut(pictureSky(makeTexture(size.x, size.y, [](int, int) { return Rgb(1); })), 256);
        EXPECT_EQ(lights.size(), 256u) << size.x;
        for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.6, 0, 0.8)}) {
            const double squares =
                arriving(lights, Vec3(0), [&](const Vec3& to) { return std::pow(glm::dot(to, axis), 2); });
            EXPECT_NEAR(squares, 4 * kPi / 3, 0.01 * 4 * kPi / 3) << size.x << " x " << size.y;
        }
    }
}

// What is black shines on nothing, alone or beside others, and is no reason to look for lights in the wrong list.
TEST(SubLights, OfABlackPictureAreOneThatIsCulled) {
    ViewScene scene = orthographicScene(boxField({-2, -2, -2}, {2, 2, 2}), Medium(), 8, 8);
    Light screen = areaLight(AreaShape::rectangle, 4, 2, 0);
    screen.slide.emplace();
    screen.slide->image = makeTexture(8, 4, [](int, int) { return Rgb(0); });
    for (const Light& black : {pictureSky(makeTexture(8, 4, [](int, int) { return Rgb(0); })), screen})
        for (const bool alone : {true, false}) {
            scene.lights = {black};
            if (!alone) scene.lights.push_back(distantLight({0, 0, -1}));
            const Plan plan = makePlan(scene, 1);
            ASSERT_EQ(plan.culledLights.size(), scene.lights.size());
            EXPECT_EQ(plan.culledLights[0], "its picture is black");
            const Frame frame = render(scene, plan);
            EXPECT_EQ(frame.image.rgba[frame.image.indexOf(4, 4)] > 0, !alone);
            EXPECT_GT(frame.image.rgba[frame.image.indexOf(4, 4) + 3], 0);
        }
}

// A mesh that shines to one side, behind which are the volumes, and one without an area. Neither is black.
TEST(SubLights, OfAMeshThatFacesAwayAreOneThatIsCulled) {
    ViewScene scene = orthographicScene(boxField({-2, -2, -2}, {2, 2, 2}), Medium(), 8, 8);
    const auto shining = [](const TriangleMesh& mesh) {
        Light light;
        light.name = "panel";
        light.kind = Light::Area{AreaShape::mesh};
        shineFrom(light, mesh, Mat4(1));
        return light;
    };
    TriangleMesh line;
    line.points = {{9, 0, 0}, {9, 1, 0}, {9, 2, 0}};
    line.triangles = {{0, 1, 2}};
    const std::pair<Light, std::string> cases[] = {
        {shining(*squareMesh({9, 0, 0}, {1, 0, 0}, 1)), "it faces away from every volume"},
        {shining(*squareMesh({9, 0, 0}, {-1, 0, 0}, 1)), ""},
        {shining(line), "its surface has no area"}};
    for (const auto& [light, reason] : cases) {
        scene.lights = {light};
        const Plan plan = makePlan(scene, 1);
        EXPECT_EQ(plan.culledLights.at(0), reason);
        for (const Effect& effect : effectsOf(scene, plan)) {
            if (effect.name != "extended lights") continue;
            EXPECT_EQ(effect.on, reason.empty());
            EXPECT_EQ(effect.reason == "every extended light is culled", !reason.empty()) << effect.reason;
        }
    }
}

// Where a mesh touches media, each place there is lit by a few of its triangles, and their parts as points would be too
// bright. Elements are four times as many.
TEST(SubLights, OfAMeshThatTouchesMediaAreElements) {
    constexpr int kSamples = 24, kOfNormals = 4;
    ViewScene scene = orthographicScene(boxField({-2, -2, -2}, {2, 2, 2}), Medium(), 8, 8);
    const auto countAt = [&](double y) {
        Light light;
        light.name = "panel";
        light.samples = kSamples;
        light.kind = Light::Area{AreaShape::mesh};
        shineFrom(light, *squareMesh({0, y, 0}, {1, 0, 0}, 1), Mat4(1));
        scene.lights = {light};
        return int(subLights(scene).lights.size());
    };
    EXPECT_EQ(countAt(0), kOfNormals * kSamples);
    EXPECT_EQ(countAt(3.7), kOfNormals * kSamples);  // only its lowest third is where the kernels of voxels reach
    EXPECT_LE(countAt(4.5), kSamples);
}

// A sky that brightens towards its zenith, and in it a sun of 0.53 degrees whose light is a third of all.
TEST(LightInSpots, IsThatOfTheSunAndNotOfTheSky) {
    constexpr int kWidth = 2048, kHeight = 1024;
    const Vec3 sun = glm::normalize(Vec3(0.3, 0.7, 0.4));
    const auto sky = [&](double sunRadiance, int width, int height) {
        const Light blank = pictureSky(makeTexture(1, 1, [](int, int) { return Rgb(1); }));
        return pictureSky(makeTexture(width, height, [&](int x, int y) {
            const Vec3 to = domeDirection(blank, (x + 0.5) / width, (y + 0.5) / height);
            const double cosine = std::cos(0.5 * 0.53 * kPi / 180);
            return Rgb(1 + std::max(to.y, 0.0) + (glm::dot(to, sun) > cosine ? sunRadiance : 0));
        }));
    };
    // The sky holds 4 pi + pi, the sun its radiance times 2 pi (1 - cos).
    const double radiance = 0.5 * 5 * kPi / (2 * kPi * (1 - std::cos(0.5 * 0.53 * kPi / 180)));
    EXPECT_NEAR(lightInSpots(sky(radiance, kWidth, kHeight), 64), 1.0 / 3, 0.02);  // the disk is some 4 pixels wide
    EXPECT_EQ(lightInSpots(sky(0, 64, 32), 64), 0);
    EXPECT_EQ(lightInSpots(pictureSky(makeTexture(1, 1, [](int, int) { return Rgb(1); })), 64), 0);
    EXPECT_EQ(lightInSpots(pictureSky(makeTexture(8, 4, [](int, int y) { return Rgb(y < 2 ? 1 : 0); })), 64), 0);
}

TEST(DomeCells, GiveABrightPixelALightOfItsOwn) {
    const auto colour = [](int x, int y) { return x == 900 && y == 200 ? Rgb(1e7) : Rgb(1); };
    const Light sky = pictureSky(makeTexture(1100, 550, colour));
    const std::vector<Light> lights = cut(sky, 30);
    const Light* brightest = &lights[0];
    for (const Light& light : lights)
        if (light.intensity.x > brightest->intensity.x) brightest = &light;
    // A pixel is a third of a degree; what else its cell holds is nothing beside it.
    EXPECT_GT(glm::dot(-brightest->wsDirection, domeDirection(sky, 900.5 / 1100, 200.5 / 550)), std::cos(1e-3));
    EXPECT_EQ(lights.size(), 30u);  // the rest of the sky keeps its own
}

TEST(RectangleCells, ShowThePictureAsAScreenDoes) {
    Light screen = areaLight(AreaShape::rectangle, 4, 2, 0);
    screen.slide.emplace();
    // A light window above on the right, and black otherwise.
    screen.slide->image = makeTexture(64, 32, [](int x, int y) { return x >= 48 && y < 8 ? Rgb(1, 0.5, 0) : Rgb(0); });
    screen.intensity = Rgb(2);
    Rgb sum(0);
    for (const Light& light : cut(screen, 24)) {
        sum += light.intensity;
        // Whoever is shone at looks along +z and has +x to the left.
        EXPECT_TRUE(light.wsPosition.x < -1 && light.wsPosition.x > -2);
        EXPECT_TRUE(light.wsPosition.y > 0.5 && light.wsPosition.y < 1);
        EXPECT_EQ(light.wsPosition.z, 0);
    }
    // A sixteenth of an area of 8, at radiance 2.
    EXPECT_NEAR(sum.x, 1, 1e-9);
    EXPECT_NEAR(sum.y, 0.5, 1e-9);
    EXPECT_EQ(sum.z, 0);
}

TEST(SubLightCount, GrowsWithTheLightAndTheErrorThatIsAskedFor) {
    ViewScene scene = orthographicScene(boxField({-20, -20, -20}, {20, 20, 20}), Medium(), 60, 8);
    const auto count = [&](const Light& light, double error) {
        scene.dials.lightError = error;
        return subLightCount(scene, light);
    };
    Light sun = distantLight({0, -1, 0}), sky;
    EXPECT_EQ(count(sun, 0.01), 1);
    sky.kind = Light::Dome();
    sun.kind = Light::Distant(0.5);
    const int small = count(sun, 0.01);
    sun.kind = Light::Distant(20);
    EXPECT_LT(small, count(sun, 0.01));
    EXPECT_LT(count(sun, 0.01), count(sky, 0.01));
    EXPECT_LT(count(sky, 0.01), count(sky, 0.001));
    EXPECT_LE(count(sky, 1e-4), kMostSubLights);
    Light box = areaLight(AreaShape::rectangle, 20, 20, 0);
    box.wsPosition = {0, 0, 30};
    const int near = count(box, 0.01);
    box.wsPosition = {0, 0, 300};
    EXPECT_LT(count(box, 0.01), near);
    box.samples = 5;
    EXPECT_EQ(count(box, 0.01), 5);
}

}  // namespace
}  // namespace scrim::test
