// SPDX-License-Identifier: Apache-2.0
// Solids that hide volumes, take light from them and catch their shadows: closed forms, and the reference, which traces
// its own rays and knows neither sheets nor rasters.
#include "scenes.h"
#include "support/meshes.h"
#include "support/verified.h"

#include <scrim/verify/reference.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/exponential.hpp>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Solids, AreHitWhereTheyAre) {
    const auto ball = oneSolid(ballMesh({100000, 2, 3}, 5, 256));
    // Corners lie on the ball, so its faces lie inside of it by r (1 - cos) of a step's angle.
    const double sag = 5 * (1 - std::cos(kPi / 256)) + 1e-9;
    const double front = ball->firstHit(SolidRole::holdout, {0, 2.01, 3.02}, {2, 0, 0}, 0, kInfinity);
    const double exact = (100000 - std::sqrt(25 - 0.01 * 0.01 - 0.02 * 0.02)) / 2;
    EXPECT_GE(front, exact - 1e-9);
    EXPECT_LE(front, exact + sag);
    // From within, beyond, and beside.
    EXPECT_NEAR(ball->firstHit(SolidRole::shadow, {100000, 2, 3}, {0, 0, -1}, 0, kInfinity), 5, sag);
    EXPECT_EQ(ball->firstHit(SolidRole::holdout, {0, 2, 3}, {1, 0, 0}, 0, 99994), kInfinity);
    EXPECT_EQ(ball->firstHit(SolidRole::holdout, {0, 7.1, 3}, {1, 0, 0}, 0, kInfinity), kInfinity);
    EXPECT_EQ(ball->firstHit(SolidRole::catcher, {0, 2, 3}, {1, 0, 0}, 0, kInfinity), kInfinity);
}

// The haze in front of a surface under light from everywhere is A rho (1 - e^-tau), and its alpha 1 - e^-tau: wherever
// in a sheet the surface lies, and however it leans.
TEST(Holdout, EndsTheHazeWhereverItLiesInASheet) {
    const double sigma = 0.07;
    for (const Vec3& normal : {Vec3(0, 0, 1), Vec3(0.5, 0.2, 1), Vec3(2, -1, 1)})
        for (int offset = 0; offset < 10; ++offset) {
            ViewScene scene = haze(sigma);
            scene.ambient = {1, 0.5, 0.25};
            const Vec3 middle(0, 0, -1.3 + 0.13 * offset);
            scene.solids = oneSolid(squareMesh(middle, normal, 300));
            const Frame frame = renderScene(scene);
            for (const Int2 pixel : {Int2(3, 4), Int2(10, 10), Int2(16, 7)}) {
                const double x = pixel.x - 9.5, y = 9.5 - pixel.y;
                const double z = middle.z - (normal.x * x + normal.y * y) / normal.z;
                const double depth = 9.5 - std::clamp(z, -10.5, 9.5), alpha = -std::expm1(-sigma * depth);
                // The box's faces are ramps half a voxel to either side of where a voxel ends.
                const double ramp = z > 8.5 || z < -9.5 ? 0.1 : 0;
                const auto rgba = pixelOf(frame, pixel.x, pixel.y);
                EXPECT_NEAR(rgba[3], alpha, 3e-4 + ramp) << normal.x << " " << offset;
                EXPECT_NEAR(rgba[0], rgba[3], 2e-4) << normal.x << " " << offset;
                EXPECT_NEAR(rgba[1], 0.5 * rgba[3], 1e-4) << normal.x << " " << offset;
            }
        }
}

// A surface between the eye and all of the volume hides it, in the reference as in the picture.
TEST(Holdout, HidesAVolumeThatLiesWhollyBehindIt) {
    ViewScene scene = haze(0.07);
    scene.ambient = Rgb(1);
    ASSERT_GT(Reference(scene).pixel(10, 10)[3], 0.1);
    scene.solids = oneSolid(squareMesh({0, 0, 15}, {0.1, 0.2, 1}, 300));
    for (const double value : Reference(scene).pixel(10, 10)) EXPECT_EQ(value, 0);
    for (const double value : pixelOf(renderScene(scene), 10, 10)) EXPECT_EQ(value, 0);
}

// In front of it lies only what the light and the eye both reach. The plane is lit from the eye's side, or from behind.
double slantedError(double offset, const Vec3& light, const Vec3& normal, double thickness) {
    ViewScene scene = haze(0.05);
    scene.dials.texel = scene.dials.sheetThickness = thickness;
    scene.lights = {distantLight(light, 3)};
    scene.solids = oneSolid(squareMesh({0, 0, offset}, normal, 300));
    const Frame frame = renderScene(scene);
    const Reference reference(scene);
    double error = 0, sum = 0;
    for (int y = 4; y < 16; ++y)
        for (int x = 4; x < 16; ++x) {
            const double truth = reference.pixel(x, y)[0], seen = pixelOf(frame, x, y)[0];
            error += (seen - truth) * (seen - truth);
            sum += truth * truth;
        }
    return std::sqrt(error / std::max(sum, 1e-12));
}

TEST(Holdout, LitOnASlantDoesNotShowWhereTheSheetsLie) {
    for (const Vec3& light : {Vec3(-1, -0.5, -1), Vec3(0.3, 0.2, -1), Vec3(0.8, -1, -0.5)}) {
        double least = 1, most = 0;
        for (int offset = 0; offset < 10; ++offset) {
            const double error = slantedError(0.1 * offset, light, {0.6, 0.3, 1}, 1);
            least = std::min(least, error);
            most = std::max(most, error);
        }
        // 14 sheets are seen; one of them wrong by half would be some 4 %.
        EXPECT_LE(most, 0.01) << light.x;
        EXPECT_LE(most - least, 0.004) << light.x;
    }
}

// The sun is behind the plane, in front of the eye or beside it: in front of the plane all is dark: to half a
// hundredth of what it would be in the light, some 0.2.
TEST(Holdout, KeepsTheLightOfItsOtherSide) {
    for (const Vec3& light : {Vec3(0.4, 0.2, 1), Vec3(1, 0, -0.3)})
        for (int offset = 0; offset < 10; ++offset) {
            ViewScene scene = haze(0.05);
            scene.lights = {distantLight(light, 3)};
            scene.solids = oneSolid(squareMesh({0, 0, 0.1 * offset}, {0.6, 0.1, 1}, 300));
            const Frame frame = renderScene(scene);
            for (int y = 0; y < 20; ++y)
                for (int x = 0; x < 20; ++x)
                    ASSERT_LE(pixelOf(frame, x, y)[0], 1e-3) << offset << ": " << x << ", " << y;
        }
}

// Thin haze, a sun along x, a ball that throws a shadow and hides nothing: what is missing behind it is the way through
// a cylinder, 2 sqrt(R^2 - y^2) of 20.
TEST(ShadowOfASolid, OfABallInHazeIsACylinder) {
    const double sigma = 1e-5, radius = 4;
    ViewScene scene = haze(sigma);
    scene.lights = {distantLight({1, 0, 0}, 1)};
    scene.solids = oneSolid(ballMesh({-3, 0, 0}, radius), false);
    for (const double texel : {1.0, 0.5}) {
        scene.dials.texel = scene.dials.sheetThickness = texel;
        const Frame frame = renderScene(scene);
        double error = 0, darkest = 1;
        for (int row = 0; row < 20; ++row) {
            const double y = 9.5 - row;
            // Mean over the height of a pixel.
            double missing = 0;
            for (int i = 0; i < 100; ++i) {
                const double at = y - 0.5 + (i + 0.5) / 100;
                missing += std::abs(at) < radius ? 2 * std::sqrt(radius * radius - at * at) / 100 : 0;
            }
            const double lit = sigma / (4 * kPi) * (20 - missing), seen = pixelOf(frame, 14, row)[0];
            error = std::max(error, std::abs(seen / (sigma / (4 * kPi) * 20) - lit / (sigma / (4 * kPi) * 20)));
            darkest = std::min(darkest, seen / lit);
            EXPECT_NEAR(pixelOf(frame, 1, row)[0], sigma / (4 * kPi) * 20, 2e-3 * sigma) << row;  // before the ball
        }
        // A cell at the edge, lit or not, is a chord of at most 2 sqrt(2 R texel): a fifth of 20.
        EXPECT_LE(error, 0.12 * texel) << texel;
    }
}

TEST(Solids, ConvergeToTheReference) {
    for (const bool holdout : {true, false})
        for (const double z : {-0.8, 0.9}) {  // lit from the eye's side, and from behind
            ViewScene scene = plainScene();
            scene.lights.resize(1);
            scene.lights[0].wsDirection = glm::normalize(Vec3(-1, -0.7, z));
            scene.solids = oneSolid(ballMesh({6, 5, 3}, 7), holdout);
            scene.dials.antialias = 2;
            scene.dials.texel = scene.dials.sheetThickness = 0.7;
            const double coarse = errorOf(scene, 60);
            scene.dials.texel = scene.dials.sheetThickness = 0.35;
            const double fine = errorOf(scene, 60);
            // Edges of shadows are a cell wide: of first order, or half an order as a mean of squares.
            EXPECT_LE(fine, 0.75 * coarse) << holdout << " " << z << ": " << coarse << ", " << fine;
            EXPECT_LE(fine, 0.03) << holdout << " " << z;
        }
}

// What hides adds nothing: the picture with it is the picture of what is in front of it, and where it covers nothing
// all is as it was, to the last bit.
TEST(Holdout, LeavesOtherPixelsAlone) {
    ViewScene scene = plainScene();
    const Frame plain = renderScene(scene);
    scene.solids = oneSolid(squareMesh({15, 15, 22}, {0, 0, 1}, 6), true, false);
    const Frame held = renderScene(scene);
    int hidden = 0;
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 48; ++x) {
            const double wsX = (x - 23.5) * 44 / 48, wsY = (23.5 - y) * 44 / 48;
            const bool covered = std::abs(wsX - 15) < 6 && std::abs(wsY - 15) < 6;
            hidden += covered ? 1 : 0;
            for (std::size_t c = 0; c < 4; ++c)
                ASSERT_EQ(pixelOf(held, x, y)[c], covered ? 0 : pixelOf(plain, x, y)[c]) << x << ", " << y;
        }
    EXPECT_GT(hidden, 100);
}

TEST(Solids, WithoutARoleChangeNothing) {
    ViewScene scene = plainScene();
    const Frame plain = renderScene(scene);
    scene.solids = oneSolid(ballMesh({6, 5, 3}, 7), false, false);
    const Frame frame = renderScene(scene);
    EXPECT_EQ(frame.image.rgba, plain.image.rgba);
    EXPECT_EQ(frame.work, plain.work);
}

// Light through a slab of haze onto a floor behind it: e^(-sigma 20 / cos), in each channel.
TEST(CaughtShadow, IsTheTransmittanceOfASlab) {
    ViewScene scene = haze(0.02);
    scene.volumes[0].medium.extinctionTint = {1, 0.5, 0};
    scene.lights = {distantLight({0.6, 0, -0.8}, 3), distantLight({0, 0, -1})};
    scene.lights[1].shadows = false;
    scene.layers = {Layer::shadow};
    scene.solids = oneSolid(squareMesh({0, 0, -15}, {0, 0, 1}, 6), false, false, true);
    const Frame frame = renderScene(scene);
    ASSERT_EQ(frame.layers.size(), 2u);
    const auto shadow = [&](std::size_t light, int x, int y, int c) {
        return frame.layers[light].data[static_cast<std::size_t>(3 * (y * 20 + x) + c)];
    };
    for (int c = 0; c < 3; ++c) {
        const double tau = 0.02 * 20 / 0.8 * scene.volumes[0].medium.extinctionTint[c];
        EXPECT_NEAR(shadow(0, 10, 10, c), std::exp(-tau), 1e-3);
        EXPECT_EQ(shadow(1, 10, 10, c), 1);  // it throws none
        EXPECT_EQ(shadow(0, 1, 1, c), 1);    // beside the floor
    }
    scene.volumes[0].shadows = {false, true};
    EXPECT_EQ(renderScene(scene).layers[0].data[3 * (10 * 20 + 10)], 1) << "it casts none in this light";
    scene.volumes[0].shadows = {};
    // Something that does not catch stands in front.
    scene.solids = std::make_shared<const Solids>(
        std::vector<Solid>{{"floor", squareMesh({0, 0, -15}, {0, 0, 1}, 6), Mat4(1.0), true, false, true},
                           {"card", squareMesh({-3, 0, 12}, {0, 0, 1}, 2), Mat4(1.0), true, false, false}});
    const Frame behind = renderScene(scene);
    const auto red = [&](int x) { return behind.layers[0].data[static_cast<std::size_t>(3 * (10 * 20 + x))]; };
    EXPECT_EQ(red(6), 1);
    EXPECT_NEAR(red(12), std::exp(-0.5), 1e-3);
}

// Two balls of one mesh, of which the smoke is in front of one: what they send falls with the square of their distance.
TEST(CaughtShadow, OfALightThatIsAMeshIsThatOfWhatItsPartsSend) {
    ViewScene scene = haze(0.02);
    const Vec3 behind(0, 0, 30), beside(80, 0, -10), floor(0, 0, -15);
    TriangleMesh balls = *ballMesh(behind, 1, 8);
    const auto other = ballMesh(beside, 1, 8);
    const auto first = static_cast<std::uint32_t>(balls.points.size());
    balls.points.insert(balls.points.end(), other->points.begin(), other->points.end());
    for (const auto& [a, b, c] : other->triangles) balls.triangles.push_back({first + a, first + b, first + c});
    Light light;
    light.name = "balls";
    light.kind = Light::Area{AreaShape::mesh};
    shineFrom(light, balls, Mat4(1));
    scene.lights = {light};
    scene.layers = {Layer::shadow};
    scene.solids = oneSolid(squareMesh(floor, {0, 0, 1}, 6), false, false, true);
    const double a = 1 / glm::dot(behind - floor, behind - floor), b = 1 / glm::dot(beside - floor, beside - floor);
    const double expected = (a * std::exp(-0.02 * 20) + b) / (a + b);  // 0.75; 0.83 if both counted alike
    EXPECT_NEAR(renderScene(scene).layers[0].data[3 * (10 * 20 + 10)], expected, 0.01);
}

// The volumes' light is kept on cells for all that, and costs no shadow buffers.
TEST(CaughtShadow, OfASkyOrALampIsTheSameWhereverTheVolumesHaveTheirLight) {
    for (const bool sky : {true, false}) {
        ViewScene scene = haze(0.02);
        Light& light = scene.lights.emplace_back();
        if (sky)
            light.kind = Light::Dome();
        else
            light.kind = Light::Area{AreaShape::sphere, 1, 1, 1}, light.wsPosition = {2, 1, -3};
        light.name = "soft";
        light.samples = 20;
        scene.lights = {light};
        scene.layers = {Layer::shadow};
        scene.solids = oneSolid(squareMesh({0, 0, -15}, {0, 0, 1}, 6), false, false, true);
        ASSERT_TRUE(makePlan(scene, 2).cellLights.has(0));
        const Frame onCells = renderScene(scene);
        scene.lights[0].shadow = ShadowMethod::buffers;
        ASSERT_FALSE(makePlan(scene, 2).cellLights.has(0));
        const Frame inBuffers = renderScene(scene);
        EXPECT_EQ(onCells.layers[0].data, inBuffers.layers[0].data);
        EXPECT_LT(onCells.layers[0].data[3 * (10 * 20 + 10)], 0.95);
    }
}

// Eight pixels a voxel: few of the rays to the light are marched, and between them what arrives is nearly straight over
// half a voxel. A crop is the same.
TEST(CaughtShadow, OfSmokeIsThatOfARayFromEachPixel) {
    ViewScene scene = orthographicScene(smokeField(12), {0.25, Rgb(0.9), {}}, 30, 240);
    scene.lights = {distantLight({0.3, 0.2, -1}, 1)};
    scene.layers = {Layer::shadow};
    scene.dials.sheetThickness = 0.5;
    scene.solids = oneSolid(squareMesh({3, 2, -16}, {0.3, 0.1, 1}, 10), false, false, true);
    const Frame frame = renderScene(scene);
    const Reference reference(scene);
    const RayFamily rays = wsRays(scene.camera);
    int count = 0, shadowed = 0;
    double squares = 0, worst = 0;
    for (int y = 3; y < 240; y += 7)
        for (int x = 3; x < 240; x += 7) {
            const Vec3 origin = rays.origin(x + 0.5, y + 0.5), direction = rays.direction(x + 0.5, y + 0.5);
            const double t = scene.solids->firstHit(SolidRole::catcher, origin, direction, rays.near, 1e6);
            const Vec3 ws = origin + t * direction;
            const double tau = t < 1e6 ? reference.opticalDepth(ws, ws - 60.0 * scene.lights[0].wsDirection).x : 0;
            const double truth = std::exp(-tau);
            const double off = frame.layers[0].data[std::size_t(3 * (y * 240 + x))] - truth;
            squares += off * off;
            worst = std::max(worst, std::abs(off));
            shadowed += truth < 0.9 ? 1 : 0;
            ++count;
        }
    EXPECT_GT(shadowed, count / 6);
    EXPECT_LT(std::sqrt(squares / count), 0.001);
    EXPECT_LT(worst, 0.01);
    EXPECT_LT(frame.work.caughtRays, 240u * 240u / 6);

    const CaughtDifference seen = differenceOfCaught(scene, frame, 100);
    EXPECT_EQ(seen.values, 300);
    EXPECT_LT(seen.rms, 0.002);
    Frame wrong = frame;
    for (float& value : wrong.layers[0].data) value -= 0.01f;
    EXPECT_NEAR(differenceOfCaught(scene, wrong, 100).rms, 0.01, 0.002);

    scene.picture = scene.region;
    scene.region = {57, 70, 131, 122};
    const Frame crop = renderScene(scene);
    for (int y = 70; y < 122; ++y)
        for (int x = 57; x < 131; ++x)
            ASSERT_EQ(crop.layers[0].data[std::size_t(3 * ((y - 70) * 74 + x - 57))],
                      frame.layers[0].data[std::size_t(3 * (y * 240 + x))])
                << x << ", " << y;
}

}  // namespace
}  // namespace scrim::test
