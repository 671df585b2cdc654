// SPDX-License-Identifier: Apache-2.0
// Volumes of unlike voxels, which have sheets of their own: what eye and light pass is the sum of all of them.
#include "soft_lights.h"
#include "support/fields.h"
#include "support/meshes.h"
#include "support/verified.h"

#include <scrim/engine/plan/culling.h>
#include <scrim/engine/plan/levels.h>
#include <scrim/geometry/camera.h>

#include <tbb/global_control.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// A ball of voxels of `voxel`, 2.4 wide, in haze of voxels of 1, lit at a slant: the ball's shadow runs through the
// haze in view.
ViewScene ballInHaze(double voxel, const Vec3& middle = Vec3(0.3, -0.2, 0.4)) {
    Medium thin;
    thin.densityScale = 0.08;
    thin.albedo = Rgb(0.9, 0.8, 0.7);
    const auto haze = makeField(Int3(-6), Int3(5), 1, [](const Vec3& is) { return 1 + 0.3 * std::sin(is.x + is.y); });
    ViewScene scene = orthographicScene(haze, thin, 9, 48);
    scene.camera.type = CameraType::perspective;
    scene.camera.wsPosition = {4, 3, 14};
    scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, middle, {0, 1, 0});
    scene.lights.push_back(distantLight({-1, -0.6, -0.5}, 3));
    ViewVolume& ball = scene.volumes.emplace_back(scene.volumes.front());
    ball.name = "ball";
    ball.place = 1;
    ball.field = smokeField(static_cast<int>(std::lround(1.2 / voxel)), voxel);
    ball.wsFromIs = ball.field->wsFromIs;
    ball.wsFromIs[3] += glm::dvec4(middle, 0);
    ball.medium.densityScale = 2;
    ball.medium.albedo = Rgb(0.6, 0.8, 0.9);
    scene.volumes.front().place = 0;
    return scene;
}

std::size_t levelsOf(const ViewScene& scene) {
    return makePlan(scene, 1).groups.front().finer.size() + 1;
}

Image imageOf(const ViewScene& scene) {
    return renderScene(scene).image;
}

double largestDifference(const Image& a, const Image& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i)
        most = std::max(most, std::abs(double(a.rgba[i]) - double(b.rgba[i])));
    return most;
}

TEST(Levels, AgreeWithBruteForceWhereverTheSmallVolumeIs) {
    // In the haze, across its border, and before it.
    for (const Vec3 middle : {Vec3(0.3, -0.2, 0.4), Vec3(5.3, 1, 2), Vec3(1, 1, 8)}) {
        const ViewScene scene = ballInHaze(0.1, middle);
        EXPECT_EQ(levelsOf(scene), 2u);
        expectConvergence(scene, 50, 0.9, 0.008, fmt::format("middle{}", middle.z));
    }
}

// Sixteen sheets of the ball fill one of the haze; a level without volumes lies between.
TEST(Levels, AgreeWithBruteForceWhereOneLiesBetween) {
    const ViewScene scene = ballInHaze(0.05);
    EXPECT_EQ(levelsOf(scene), 3u);
    expectConvergence(scene, 24, 0.9, 0.008);
}

TEST(Levels, AgreeWithBruteForceInLampsAndFromBehind) {
    ViewScene scene = ballInHaze(0.1);
    scene.lights = {lamp({3, 4, 3}, 60), distantLight({0.4, 0.2, 1}, 2)};
    scene.lights[1].name = "rim";
    scene.volumes[0].medium.scattering = Scattering::octaves;
    scene.ambient = Rgb(0.02);
    // A lamp's light changes as 1 / r^2 within the haze's sheets: 1.24 and 0.78 % were measured.
    expectConvergence(scene, 40, 0.5, 0.012);
}

// Two balls, of voxels of 0.1 and 0.2, at these places.
ViewScene twoBalls(const Vec3& fine, const Vec3& coarse) {
    ViewScene scene = ballInHaze(0.1, fine);
    scene.camera.wsPosition = {0, 0, 14};
    scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, {0, 0, 0}, {0, 1, 0});
    ViewVolume& other = scene.volumes.front();
    other.field = smokeField(6, 0.2);
    other.wsFromIs = other.field->wsFromIs;
    other.wsFromIs[3] += glm::dvec4(coarse, 0);
    other.medium = scene.volumes[1].medium;
    return scene;
}

// Each of them in turn is where the camera does not see it, on the light's way to the other.
TEST(Levels, AgreeWithBruteForceWhereOneIsOutOfViewAndShadowsTheOther) {
    const Vec3 away(12.1, 7.2, 6);
    for (const std::size_t out : {0u, 1u}) {
        const ViewScene scene = out == 0 ? twoBalls(Vec3(0), away) : twoBalls(away, Vec3(0));
        EXPECT_EQ(levelsOf(scene), 2u);
        const std::vector<Vec3> corners = wsCorners(scene.volumes[out], Kernel::linear);
        ASSERT_TRUE(visibleParts(scene.camera, scene.region, corners).empty()) << out;
        expectConvergence(scene, 50, 0.9, 0.05, fmt::format("out{}", out));  // small dense balls
    }
}

TEST(Levels, ShowInASkyWhatIsInViewBesideWhatIsNot) {
    ViewScene scene = twoBalls(Vec3(0), Vec3(9, 0, 0));
    scene.lights = {domeLight(24)};
    ViewScene alone = scene;
    alone.volumes.erase(alone.volumes.begin());
    alone.volumes.front().place = 0;
    EXPECT_LT(errorOf(scene, 40), 1.1 * errorOf(alone, 40));
}

TEST(Levels, AgreeWithBruteForceInASkyOnCells) {
    ViewScene scene = ballInHaze(0.1);
    scene.lights = {domeLight(24)};
    scene.lights[0].intensity = Rgb(0.5);
    ASSERT_TRUE(makePlan(scene, 1).cellLights.has(0));
    EXPECT_LT(errorOf(scene, 10), 0.02);
}

// The ball's shadow is twelve of its own voxels wide, and the haze's sheets are as thick as ten: pixels beside the ball
// must find it, and no line where finer sheets end. Neighbours across such a line differ by no more than elsewhere.
TEST(Levels, LeaveNoLineInTheShaft) {
    ViewScene scene = ballInHaze(0.1);
    scene.camera.resolution = {160, 160};
    scene.region = {0, 0, 160, 160};
    scene.dials.texel = scene.dials.sheetThickness = 0.5;
    const Image image = imageOf(scene);
    // Second differences along rows, relative to the mean; outside of the ball's own disk the picture is smooth.
    double most = 0, sum = 0;
    const auto green = [&](int x, int y) { return double(image.rgba[image.indexOf(x, y) + 1]); };
    for (int y = 0; y < 160; ++y)
        for (int x = 1; x < 159; ++x) {
            sum += green(x, y);
            if (std::hypot(x - 80, y - 80) < 30) continue;
            most = std::max(most, std::abs(green(x + 1, y) + green(x - 1, y) - 2 * green(x, y)));
        }
    EXPECT_LT(most, 0.01 * sum / (160 * 158));
}

TEST(Levels, GiveCropsTheBitsOfTheWhole) {
    ViewScene scene = ballInHaze(0.1);
    const Image whole = imageOf(scene);
    for (const PixelWindow crop :
         {PixelWindow{13, 9, 41, 30}, PixelWindow{20, 20, 28, 28}, PixelWindow{0, 33, 48, 48}}) {
        scene.picture = {0, 0, 48, 48};
        scene.region = crop;
        const Image part = imageOf(scene);
        for (int y = crop.y0; y < crop.y1; ++y)
            for (int x = crop.x0; x < crop.x1; ++x)
                for (int c = 0; c < 4; ++c)
                    ASSERT_EQ(part.rgba[part.indexOf(x, y) + std::size_t(c)],
                              whole.rgba[whole.indexOf(x, y) + std::size_t(c)])
                        << x << " " << y;
    }
}

// Windows that see one of them alone.
TEST(Levels, GiveCropsTheBitsOfTheWholeWhereTheyLieSideBySide) {
    ViewScene scene = twoBalls({-2.5, 0, 0}, {3, 0, 0});
    scene.lights = {domeLight(24)};
    scene.dials.texel = 0.25;
    const Image whole = imageOf(scene);
    for (const PixelWindow crop : {PixelWindow{0, 0, 16, 48}, PixelWindow{32, 0, 48, 48}}) {
        scene.picture = {0, 0, 48, 48};
        scene.region = crop;
        const Image part = imageOf(scene);
        double sum = 0;
        for (int y = crop.y0; y < crop.y1; ++y)
            for (int x = crop.x0; x < crop.x1; ++x) {
                const Real *of = &part.rgba[part.indexOf(x, y)], *expected = &whole.rgba[whole.indexOf(x, y)];
                ASSERT_TRUE(std::equal(of, of + 4, expected)) << x << " " << y;
                sum += double(of[3]);
            }
        EXPECT_GT(sum, 1);
    }
}

TEST(Levels, DoNotChangeABitWithThreadsAndMemory) {
    const tbb::global_control seven(tbb::global_control::max_allowed_parallelism, 7);
    ViewScene scene = ballInHaze(0.05);
    const auto with = [&](int threads) { return render(scene, makePlan(scene, threads)).image.rgba; };
    const auto one = with(1);
    EXPECT_EQ(one, with(2));
    EXPECT_EQ(one, with(7));
    scene.memoryLimit = std::size_t{24} << 20;
    EXPECT_EQ(one, with(2));
}

TEST(Levels, AddUpInLayersOfVolumesAndLights) {
    ViewScene scene = ballInHaze(0.1);
    scene.lights.push_back(distantLight({0.5, -1, -0.3}, 1));
    scene.lights[1].name = "fill";
    scene.layers = {Layer::light, Layer::volume};
    const Frame frame = renderScene(scene);
    std::vector<double> volumes(frame.image.rgba.size()), lights(volumes.size());
    double brightest = 0;
    for (const FrameLayer& layer : frame.layers)
        for (std::size_t i = 0; i < layer.data.size(); ++i) {
            auto& sum = layer.layer == Layer::volume ? volumes : lights;
            if (layer.layer == Layer::volume || layer.layer == Layer::light)
                sum[i / 3 * 4 + i % 3] += double(layer.data[i]);
        }
    for (const float value : frame.image.rgba) brightest = std::max(brightest, double(value));
    for (std::size_t i = 0; i < volumes.size(); ++i) {
        if (i % 4 == 3) continue;
        EXPECT_NEAR(volumes[i], double(frame.image.rgba[i]), 2e-6 * brightest);
        EXPECT_NEAR(lights[i], double(frame.image.rgba[i]), 2e-6 * brightest);
    }
}

// Which volume is named first does not matter, and neither does one that is not there.
TEST(Levels, DoNotDependOnTheOrderOfVolumes) {
    const ViewScene scene = ballInHaze(0.1);
    ViewScene other = scene;
    std::swap(other.volumes[0], other.volumes[1]);
    EXPECT_LT(largestDifference(imageOf(scene), imageOf(other)), 1e-6);
}

// Shadows by lists: without the haze's own, light reaches the ball as if it were alone; of the ball's, the haze shows
// nothing.
TEST(Levels, KeepShadowsOfListedVolumesApart) {
    ViewScene scene = ballInHaze(0.1);
    scene.volumes[0].shadows = {false};
    expectConvergence(scene, 40, 0.8, 0.01, "haze");
    scene.volumes[0].shadows.clear();
    scene.volumes[1].shadows = {false};
    expectConvergence(scene, 40, 0.8, 0.01, "ball");
}

TEST(Levels, HoldOutWhatIsBehind) {
    ViewScene scene = ballInHaze(0.1);
    scene.volumes[1].holdout = true;
    expectConvergence(scene, 40, 0.8, 0.012);
}

TEST(Levels, SumTheWorkOfTheirParts) {
    ViewScene scene = ballInHaze(0.05), haze = scene, ball = scene;
    haze.volumes.pop_back();
    ball.volumes.erase(ball.volumes.begin());
    ball.volumes[0].place = 0;
    const auto samples = [](const ViewScene& s) { return double(renderScene(s).work.shade.samples); };
    // Where the ball is seen, pixels walk its sheets through those of the haze that it is in.
    EXPECT_LT(samples(scene), 4 * (samples(haze) + samples(ball)));
}

// A solid in the haze, whose shadow runs over the ball.
TEST(Levels, AgreeWithBruteForceInShadowsOfSolids) {
    ViewScene scene = ballInHaze(0.1);
    scene.solids = oneSolid(ballMesh({1.6, 0.6, 1}, 0.4, 32));
    EXPECT_EQ(levelsOf(scene), 2u);
    EXPECT_LT(errorOf(scene, 60), 0.015);
}

// Surfaces are in the finest level, and the haze before them and in their light in another one.
TEST(Levels, AgreeWithBruteForceForAScanInHaze) {
    ViewScene scene = ballInHaze(0.1);
    Classified look;
    look.transfer = {{0.2, Rgb(0.8), 0}, {0.6, Rgb(0.8), 6}};
    scene.volumes[1].classified = std::make_shared<const Classified>(look);
    EXPECT_EQ(levelsOf(scene), 2u);
    EXPECT_LT(errorOf(scene, 24), 0.03);
}

// All volumes in sheets of the same voxels.
ViewScene onOneLattice(ViewScene scene) {
    scene.dials.splat = SplatMode::perView;
    return scene;
}

TEST(Levels, HaveDeepCurvesInWhichBothAreWhereTheyAre) {
    ViewScene scene = ballInHaze(0.1);
    scene.deep = ViewDeep{1e-4};
    ASSERT_EQ(levelsOf(scene), 2u);
    ASSERT_EQ(levelsOf(onOneLattice(scene)), 1u);
    const Frame frame = renderScene(scene), lattice = renderScene(onOneLattice(scene));
    // A sheet of the haze hides a tenth, and its samples are no finer; the ball hides that in a twentieth of a sheet.
    constexpr double kPart = 0.02;
    for (int y = 0; y < 48; y += 3)
        for (int x = 0; x < 48; x += 3) {
            const auto curve = frame.deep->curve(x, y), truth = lattice.deep->curve(x, y);
            EXPECT_NEAR(shownBefore(curve, 1e9)[3], pixelOf(frame, x, y)[3], 1e-5);
            for (double depth = 6; depth < 26; depth += 0.5)
                for (std::size_t c = 0; c < 4; ++c)
                    EXPECT_NEAR(shownBefore(curve, depth)[c], shownBefore(truth, depth)[c], kPart)
                        << x << ", " << y << " to " << depth << ", channel " << c;
        }
}

TEST(Levels, MoveEachVolumeByItsOwnMotion) {
    ViewScene scene = ballInHaze(0.1);
    scene.layers = {Layer::motion};
    for (std::size_t v = 0; v < 2; ++v) {
        VolumeMotion motion;
        motion.wsNextFromWs = glm::translate(Mat4(1.0), Vec3(v == 0 ? 0.1 : -0.3, 0, 0));
        scene.volumes[v].motion = std::make_shared<const VolumeMotion>(motion);
    }
    ASSERT_EQ(levelsOf(scene), 2u);
    const Frame frame = renderScene(scene), lattice = renderScene(onOneLattice(scene));
    double most = 0;
    for (std::size_t i = 0; i < frame.layers.front().data.size(); ++i) {
        EXPECT_NEAR(frame.layers.front().data[i], lattice.layers.front().data[i], 0.05);
        most = std::max(most, std::abs(double(lattice.layers.front().data[i])));
    }
    EXPECT_GT(most, 0.5);
}

}  // namespace
}  // namespace scrim::test
