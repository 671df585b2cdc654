// SPDX-License-Identifier: Apache-2.0
// What is held out: volumes that hide and shadow and do not show, and what depth and deep pictures of other renderers
// hide. Closed forms; solids, which end rays by themselves; and the reference, which integrates numerically.
#include "scenes.h"
#include "support/meshes.h"
#include "support/verified.h"

#include <scrim/image/depth_picture.h>
#include <scrim/image/exr_deep.h>
#include <scrim/verify/path_tracer.h>
#include <scrim/verify/reference.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace scrim::test {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A flat depth for every pixel of the scene.
FileDepth flatDepth(const ViewScene& scene, const std::function<double(int, int)>& depth) {
    FileDepth file;
    file.x0 = scene.region.x0;
    file.y0 = scene.region.y0;
    file.width = scene.region.width();
    file.height = scene.region.height();
    for (int y = scene.region.y0; y < scene.region.y1; ++y)
        for (int x = scene.region.x0; x < scene.region.x1; ++x) file.depths.push_back(static_cast<float>(depth(x, y)));
    return file;
}

/// The same samples (z, zBack, alpha, ...) in every pixel.
FileDepth deepSamplesEverywhere(const ViewScene& scene, const std::vector<float>& samples) {
    FileDepth file = flatDepth(scene, [](int, int) { return 0; });
    file.deep = true;
    file.depths.clear();
    for (std::size_t i = 0; i < scene.region.pixelCount(); ++i) {
        file.counts.push_back(static_cast<std::uint32_t>(samples.size() / 3));
        file.samples.insert(file.samples.end(), samples.begin(), samples.end());
    }
    return file;
}

std::shared_ptr<const DepthPicture> pictureOf(const FileDepth& file, bool alongRay = false, double background = 1e9) {
    return std::make_shared<const DepthPicture>(depthPictureOf(file, {alongRay, background}));
}

/// The depth of the solids of a scene along each pixel's ray: what another renderer would write of them.
FileDepth depthOfSolids(const ViewScene& scene, bool alongRay) {
    const RayFamily rays = wsRays(scene.camera);
    return flatDepth(scene, [&](int x, int y) {
        const Vec3 origin = rays.origin(x + 0.5, y + 0.5), direction = rays.direction(x + 0.5, y + 0.5);
        const double depth = scene.solids->firstHit(SolidRole::holdout, origin, direction, 0, 1e30);
        return depth * (alongRay ? glm::length(direction) : 1);
    });
}

void perspective(ViewScene& s) {
    s.camera.type = CameraType::perspective;
    s.camera.wsPosition = {12, 9, 40};
    s.camera.wsFromCamera = lookAt(s.camera.wsPosition, Vec3(0), {0, 1, 0});
    s.camera.fov = 60;
}

double largestDifference(const Frame& a, const Frame& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.image.rgba.size(); ++i)
        most = std::max(most, std::abs(double(a.image.rgba[i]) - double(b.image.rgba[i])));
    return most;
}

/// Where the deep picture ends must be where the flat one does; of floats, summed over dozens of sheets.
void expectDeepEndsAsFlat(const Frame& frame, double tolerance) {
    ASSERT_TRUE(frame.deep);
    const PixelWindow& window = frame.image.window;
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x) {
            const auto curve = frame.deep->curve(x, y);
            const float* rgba = frame.image.rgba.data() + frame.image.indexOf(x, y);
            for (std::size_t c = 0; c < 4; ++c)
                ASSERT_NEAR(curve.empty() ? 0 : curve.back().shown[c], rgba[c], tolerance) << x << ", " << y;
        }
}

// ---- depth pictures

TEST(DepthHoldout, EndsTheHazeWhereverItLiesInASheet) {
    const double sigma = 0.07;
    for (const double slope : {0.0, 0.3, -1.1})
        for (int offset = 0; offset < 10; ++offset) {
            ViewScene scene = haze(sigma);
            scene.ambient = {1, 0.5, 0.25};
            const double eye = scene.camera.wsPosition.z;
            const auto z = [&](int x, int y) { return -1.3 + 0.13 * offset + slope * (x - 9.5) - 0.2 * (9.5 - y); };
            scene.depths = pictureOf(flatDepth(scene, [&](int x, int y) { return eye - z(x, y); }));
            const Frame frame = renderScene(scene);
            for (const Int2 pixel : {Int2(3, 4), Int2(10, 10), Int2(16, 7)}) {
                const double at = z(pixel.x, pixel.y), ramp = at > 8.5 || at < -9.5 ? 0.1 : 0;
                const double alpha = -std::expm1(-sigma * (9.5 - std::clamp(at, -10.5, 9.5)));
                const auto rgba = pixelOf(frame, pixel.x, pixel.y);
                EXPECT_NEAR(rgba[3], alpha, 3e-4 + ramp) << slope << " " << offset;
                EXPECT_NEAR(rgba[0], rgba[3], 2e-4) << slope << " " << offset;
                EXPECT_NEAR(rgba[1], 0.5 * rgba[3], 1e-4) << slope << " " << offset;
            }
        }
}

TEST(DepthHoldout, SaysWhereNothingIs) {
    ViewScene scene = haze(0.07);
    const Frame plain = renderScene(scene);
    for (const float nothing : {1e10f, 1e30f, kInfinity, 0.0f, -1.0f, std::nanf("")}) {
        scene.depths = pictureOf(flatDepth(scene, [&](int, int) { return nothing; }));
        EXPECT_EQ(renderScene(scene).image.rgba, plain.image.rgba) << nothing;
    }
    const double near = scene.camera.wsPosition.z;
    scene.depths = pictureOf(flatDepth(scene, [&](int, int) { return near; }));
    EXPECT_GT(largestDifference(renderScene(scene), plain), 0.1);
    scene.depths = pictureOf(flatDepth(scene, [&](int, int) { return near; }), false, near);
    EXPECT_EQ(renderScene(scene).image.rgba, plain.image.rgba);
}

// The picture of a solid and the depths of that solid hide the same; what is measured along rays is not what is
// measured along the axis.
TEST(DepthHoldout, HidesWhatTheSolidHidesWhoseDepthsItHolds) {
    for (const int antialias : {1, 2}) {
        ViewScene scene = plainScene();
        perspective(scene);
        scene.dials.antialias = antialias;
        scene.layers = {Layer::depth, Layer::transmittance};
        scene.deep = ViewDeep{0};
        scene.solids = oneSolid(squareMesh({2, 1, 3}, {0.3, -0.2, 1}, 9), true, false);
        const Frame solid = renderScene(scene);
        expectDeepEndsAsFlat(solid, 2e-5);
        const FileDepth z = depthOfSolids(scene, false), distance = depthOfSolids(scene, true);
        scene.solids = nullptr;
        scene.depths = pictureOf(z);
        const Frame byZ = renderScene(scene);
        scene.depths = pictureOf(distance, true);
        const Frame byDistance = renderScene(scene);
        expectDeepEndsAsFlat(byZ, 2e-5);
        // Rays through the middles of pixels end where the solid's do, but for the roundings of floats; further ones of
        // a pixel end where its middle does.
        if (antialias == 1) {
            EXPECT_LE(largestDifference(solid, byZ), 1e-5);
            EXPECT_LE(largestDifference(solid, byDistance), 1e-5);
            for (std::size_t l = 0; l < solid.layers.size(); ++l)
                for (std::size_t i = 0; i < solid.layers[l].data.size(); ++i)
                    ASSERT_NEAR(solid.layers[l].data[i], byZ.layers[l].data[i], 1e-3) << l;
        } else {
            double sum = 0, difference = 0;
            for (std::size_t i = 0; i < solid.image.rgba.size(); ++i) {
                sum += solid.image.rgba[i];
                difference += std::abs(double(solid.image.rgba[i]) - double(byZ.image.rgba[i]));
            }
            EXPECT_LE(difference, 0.02 * sum);
        }
        // Taken for what they are not, they are off by 9 world units at the edges of the picture.
        scene.depths = pictureOf(distance, false);
        EXPECT_GT(largestDifference(solid, renderScene(scene)), 0.05);
    }
}

TEST(DepthHoldout, MayBeCroppedAndMissPixels) {
    ViewScene scene = plainScene();
    const double eye = scene.camera.wsPosition.z;
    const auto depth = [&](int x, int y) { return eye + 0.3 * (x - 24) + 0.1 * y; };
    scene.depths = pictureOf(flatDepth(scene, depth));
    const Frame whole = renderScene(scene);
    ViewScene part = scene;
    part.picture = scene.region;
    part.region = {13, 9, 31, 40};
    const Frame crop = renderScene(part);
    for (int y = 9; y < 40; ++y)
        for (int x = 13; x < 31; ++x) ASSERT_EQ(pixelOf(crop, x, y), pixelOf(whole, x, y)) << x << ", " << y;
    // A data window that holds a part of the picture.
    ViewScene plain = scene;
    plain.depths = nullptr;
    const Frame free = renderScene(plain);
    scene.depths = pictureOf(flatDepth(part, depth));
    const Frame window = renderScene(scene);
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 48; ++x)
            ASSERT_EQ(pixelOf(window, x, y), pixelOf(part.region.contains(x, y) ? whole : free, x, y));
}

// ---- deep pictures

// Haze from 10.5 to -10.5 behind samples that hide a part: the closed form is a sum over the stretches between them.
TEST(DeepHoldout, WeighsTheHazeByWhatIsLeftAtItsDepth) {
    const double sigma = 0.07;
    for (int offset = 0; offset < 10; ++offset) {
        ViewScene scene = haze(sigma);
        scene.ambient = {1, 0.5, 0.25};
        scene.deep = ViewDeep{0};
        scene.layers = {Layer::transmittance};
        const double eye = scene.camera.wsPosition.z;
        // By depth into the haze: a veil at 2, a volume over [6, 11), and a wall at 15; in no order.
        const double into = 0.13 * offset, front = eye - 9.5 + into;
        const auto at = [&](double depth) { return static_cast<float>(front + depth); };
        const float wall = at(15), veil = at(2), begin = at(6), end = at(11);
        scene.depths = pictureOf(deepSamplesEverywhere(scene, {wall, wall, 1, begin, end, 0.6f, veil, veil, 0.5f}));
        const Frame frame = renderScene(scene);
        const double kappa = -std::log1p(-0.6) / 5;
        const auto slab = [&](double from, double to) {  // of the haze alone
            return std::exp(-sigma * (from + into)) - std::exp(-sigma * (to + into));
        };
        const double inVolume =
            0.5 * std::exp(-sigma * (6 + into)) * sigma / (sigma + kappa) * -std::expm1(-(sigma + kappa) * 5);
        const double alpha = slab(-into, 2) + 0.5 * slab(2, 6) + inVolume + 0.5 * 0.4 * slab(11, 15);
        const auto rgba = pixelOf(frame, 10, 10);
        EXPECT_NEAR(rgba[3], alpha, 3e-4) << offset;
        EXPECT_NEAR(rgba[0], rgba[3], 2e-4) << offset;
        EXPECT_NEAR(frame.layers[0].data[static_cast<std::size_t>(3 * (10 * 20 + 10))], 1 - rgba[3], 1e-6);
        expectDeepEndsAsFlat(frame, 2e-5);
        EXPECT_NEAR(Reference(scene).pixel(10, 10)[3], alpha, 3e-4) << offset;
    }
}

TEST(DeepHoldout, WithoutSamplesChangesNothing) {
    ViewScene scene = plainScene();
    const Frame plain = renderScene(scene);
    scene.depths = pictureOf(deepSamplesEverywhere(scene, {}));
    const Frame frame = renderScene(scene);
    EXPECT_EQ(frame.image.rgba, plain.image.rgba);
    EXPECT_EQ(frame.work, plain.work);
}

TEST(DeepHoldout, ConvergesToTheReference) {
    for (const ShadeMode shade : {ShadeMode::texel, ShadeMode::pixel})
        for (const char* effect : {"coloured extinction", "ambient", "emission"}) {
            ViewScene scene = sceneWith(effect);
            perspective(scene);
            scene.dials.shade = shade;
            // Cloud of the other renderer across the smoke, and a veil in front of a part of it.
            scene.depths = pictureOf(deepSamplesEverywhere(scene, {30, 50, 0.8f, 36, 36, 0.3f, 52, 52, 1}));
            expectConvergence(scene, 60, 0.7, 0.008, effect);
        }
}

// ---- pieces

TEST(DepthPicture, AddsUpWhatOverlaps) {
    ViewScene one = haze(0.1);
    one.region = {0, 0, 1, 1};
    // Two volumes that overlap, and a surface within both.
    const auto picture = pictureOf(deepSamplesEverywhere(one, {2, 6, 0.5f, 4, 8, 0.75f, 5, 5, 0.5f}));
    const double a = std::log(2.0) / 4, b = std::log(4.0) / 4;
    const auto tauBefore = [&](double z) {
        return a * (std::clamp(z, 2.0, 6.0) - 2) + b * (std::clamp(z, 4.0, 8.0) - 4) + (z > 5 ? std::log(2.0) : 0);
    };
    for (const double z : {1.0, 3.0, 4.5, 5.5, 7.0, 9.0})
        EXPECT_NEAR(seenShare(picture->at(0, 0), z - 1e-7, z + 1e-7, 0), std::exp(-tauBefore(z)), 1e-6) << z;
    // Over all of it, of something of optical depth 3, by brute force.
    double sum = 0;
    constexpr int kSteps = 100000;
    for (int i = 0; i < kSteps; ++i) {
        const double z = 1 + 8 * (i + 0.5) / kSteps;
        sum += std::exp(-tauBefore(z)) * std::exp(-3 * (z - 1) / 8) * 3 / kSteps;
    }
    EXPECT_NEAR(seenShare(picture->at(0, 0), 1, 9, 3), sum / -std::expm1(-3), 1e-5);
    EXPECT_TRUE(std::isinf(opaqueFrom(picture->at(0, 0))));
    EXPECT_TRUE(picture->at(1, 0).empty());
}

// A deep picture of coloured extinction has one alpha, the mean. What is held out of each colour it knows to 1 / 510.
TEST(DeepHoldout, OfColouredExtinctionAgreesWithTheFlatPicture) {
    for (const bool volume : {true, false}) {
        ViewScene scene = sceneWith("two tints");
        scene.ambient = Rgb(0.3);
        scene.deep = ViewDeep{0};
        if (volume)
            scene.volumes.back().holdout = true;
        else
            scene.depths = pictureOf(deepSamplesEverywhere(scene, {100, 115, 0.8f, 120, 120, 1}));
        const Frame frame = renderScene(scene);
        double worst = 0, alpha = 0, colour = 0;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 48; ++x) {
                const auto curve = frame.deep->curve(x, y);
                const auto flat = pixelOf(frame, x, y);
                for (std::size_t c = 0; c < 3; ++c)
                    colour = std::max(colour, std::abs((curve.empty() ? 0 : curve.back().shown[c]) - flat[c]));
                worst = std::max(worst, std::abs((curve.empty() ? 0 : curve.back().shown[3]) - flat[3]));
                alpha = std::max(alpha, flat[3]);
            }
        EXPECT_GT(alpha, 0.3);
        EXPECT_LE(colour, 2e-5) << volume;
        EXPECT_LE(worst, 0.002) << volume;
        testing::Test::RecordProperty(volume ? "volume" : "picture", fmt::format("{}", worst));
    }
}

// ---- volumes

// A slab of tau in front of one of tau2, of which only the second is seen: e^-tau (1 - e^-tau2).
ViewScene twoSlabs(double sigma, double sigma2) {
    Medium medium;
    medium.densityScale = sigma2;
    medium.albedo = Rgb(1);
    ViewScene scene = orthographicScene(boxField({-40, -40, -10}, {39, 39, -1}), medium, 20, 20);
    medium.densityScale = sigma;
    scene.volumes.push_back(scene.volumes.front());
    scene.volumes.back().field = boxField({-40, -40, 2}, {39, 39, 11});
    scene.volumes.back().medium = medium;
    scene.volumes.back().holdout = true;
    scene.dials.sheetThickness = 0.7;
    return scene;
}

TEST(VolumeHoldout, HidesAndAddsNothing) {
    for (const Rgb& tint : {Rgb(1), Rgb(1, 0.5, 0.2)})
        for (const ShadeMode shade : {ShadeMode::texel, ShadeMode::pixel}) {
            ViewScene scene = twoSlabs(0.08, 0.13);
            scene.dials.shade = shade;
            scene.ambient = {1, 0.5, 0.25};
            scene.volumes.back().medium.extinctionTint = tint;
            scene.layers = {Layer::ambient, Layer::albedo, Layer::depth, Layer::transmittance};
            scene.deep = ViewDeep{0};
            const Frame frame = renderScene(scene);
            Rgb seen;
            for (int c = 0; c < 3; ++c) seen[c] = std::exp(-0.8 * tint[c]) * -std::expm1(-1.3);
            const auto rgba = pixelOf(frame, 10, 10);
            EXPECT_NEAR(rgba[3], (seen.x + seen.y + seen.z) / 3, 3e-4);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(rgba[std::size_t(c)], scene.ambient[c] * seen[c], 3e-4) << c;
                const auto at = static_cast<std::size_t>(3 * (10 * 20 + 10) + c);
                EXPECT_NEAR(frame.layers[3].data[at], 1 - seen[c], 3e-4) << c;
            }
            // What is seen begins where the slab does, behind the one that is not: -0.5, 0.5 of a voxel about.
            const double depth = scene.camera.wsPosition.z + 0.5;
            EXPECT_NEAR(frame.layers[2].data[2 * (10 * 20 + 10)], depth, 0.7);
            expectDeepEndsAsFlat(frame, 2e-5);
            const auto truth = Reference(scene).pixel(10, 10);
            for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(truth[c], rgba[c], 5e-4) << c;
        }
}

TEST(VolumeHoldout, AloneShowsNothing) {
    for (const bool classified : {false, true}) {
        ViewScene scene = plainScene();
        scene.volumes[0].holdout = true;
        if (classified) {
            Classified look;
            look.transfer = {{0.1, {1, 0.8, 0.6}, 0.0}, {0.4, {1, 0.8, 0.6}, 0.5}, {0.9, {0.2, 0.8, 0.6}, 2}};
            scene.volumes[0].classified = std::make_shared<const Classified>(look);
        }
        scene.ambient = Rgb(1);
        scene.layers = {Layer::light, Layer::albedo, Layer::transmittance, Layer::depth};
        scene.deep = ViewDeep{};
        const Frame frame = renderScene(scene);
        for (const float v : frame.image.rgba) ASSERT_EQ(v, 0);
        for (const FrameLayer& layer : frame.layers)
            for (const float v : layer.data) ASSERT_EQ(v, layer.layer == Layer::transmittance ? 1 : 0);
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 48; ++x) ASSERT_TRUE(frame.deep->curve(x, y).empty());
    }
}

// Two pictures, each with the other's volume held out, add up to the picture of both: whoever has both adds them.
TEST(VolumeHoldout, OfEitherAddsUpToBoth) {
    for (const ShadeMode shade : {ShadeMode::texel, ShadeMode::pixel})
        for (const char* effect : {"two tints", "light linking"}) {
            ViewScene scene = sceneWith(effect);
            scene.ambient = Rgb(0.3);
            scene.dials.shade = shade;
            scene.layers = {Layer::light, Layer::ambient};
            const Frame both = renderScene(scene);
            scene.volumes.back().holdout = true;
            const Frame first = renderScene(scene);
            scene.volumes.back().holdout = false;
            scene.volumes.front().holdout = true;
            const Frame second = renderScene(scene);
            double brightest = 0;
            for (const float v : both.image.rgba) brightest = std::max(brightest, double(v));
            const auto expectSum = [&](const std::vector<float>& a, const std::vector<float>& b,
                                       const std::vector<float>& sum) {
                for (std::size_t i = 0; i < sum.size(); ++i) ASSERT_NEAR(a[i] + b[i], sum[i], 1e-5 * brightest) << i;
            };
            expectSum(first.image.rgba, second.image.rgba, both.image.rgba);
            for (std::size_t l = 0; l < both.layers.size(); ++l)
                expectSum(first.layers[l].data, second.layers[l].data, both.layers[l].data);
        }
}

// A cloud that glows beside one that does not, in both of which light scatters more than once.
ViewScene fireBesideSmoke() {
    ViewScene scene = plainScene();
    scene.lights.clear();
    scene.volumes[0].medium.scattering = Scattering::full;
    ViewVolume fire = scene.volumes[0];
    fire.name = "fire";
    fire.medium.albedo = Rgb(0.5, 0.6, 0.4);  // so that it is not splatted together with the smoke
    fire.emission = {{flameField(), Rgb(0.3, 0.2, 0.1)}};
    fire.wsFromIs = glm::translate(Mat4(1.0), Vec3(10, 2, -6)) * fire.wsFromIs;
    for (ViewEmission& emission : fire.emission)
        emission.field.wsFromIs = glm::translate(Mat4(1.0), Vec3(10, 2, -6)) * emission.field.wsFromIs;
    scene.volumes.push_back(fire);
    scene.dials.scatterCell = 2;
    scene.dials.scatterDirections = 64;
    return scene;
}

ViewScene withHeldOut(ViewScene scene, std::size_t volume) {
    scene.volumes[volume].holdout = true;
    return scene;
}

// All that a held-out volume scatters and emits lights the others, as where it is seen. The solve is the same to the
// bit, and sheets add it up in floats.
TEST(VolumeHoldout, LightsWhatScattersMoreThanOnceAsWhereItIsSeen) {
    for (const bool lit : {false, true}) {
        ViewScene scene = fireBesideSmoke();
        if (lit) scene.lights = plainScene().lights;
        const Frame both = renderScene(scene), smoke = renderScene(withHeldOut(scene, 1)),
                    fire = renderScene(withHeldOut(scene, 0));
        double brightest = 0, bySmoke = 0;
        for (std::size_t i = 0; i < both.image.rgba.size(); ++i) {
            if (i % 4 == 3) continue;
            brightest = std::max(brightest, double(both.image.rgba[i]));
            bySmoke = std::max(bySmoke, double(smoke.image.rgba[i]));
        }
        EXPECT_GT(bySmoke, 1e-3 * brightest) << "the fire lights the smoke";
        for (std::size_t i = 0; i < both.image.rgba.size(); ++i) {
            if (i % 4 == 3) continue;  // alpha is that of volumes in which light scatters once
            ASSERT_NEAR(smoke.image.rgba[i] + fire.image.rgba[i], both.image.rgba[i], 1e-5 * std::max(brightest, 1.0))
                << i << (lit ? " lit" : "");
        }
    }
}

// So it is for the path tracer, to within five times its own noise in the mean over pixels.
TEST(VolumeHoldout, LightsTheOthersOfThePathTracer) {
    ViewScene scene = fireBesideSmoke();
    scene.lights = plainScene().lights;
    const ViewScene scenes[] = {scene, withHeldOut(scene, 1), withHeldOut(scene, 0)};
    Rgb sum[3], variance(0);
    for (std::size_t s = 0; s < 3; ++s) {
        sum[s] = Rgb(0);
        const PathTracer tracer(scenes[s]);
        for (int y = 0; y < 48; y += 6)
            for (int x = 0; x < 48; x += 6) {
                const Estimate own = tracer.pixel(x, y, 2000, s + 1);
                sum[s] += own.mean;
                variance += own.variance;
            }
    }
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(sum[1][c] + sum[2][c], sum[0][c], 5 * std::sqrt(variance[c])) << c;
        EXPECT_GT(std::min(sum[1][c], sum[2][c]), 10 * std::sqrt(variance[c])) << "either shows light: " << c;
    }
}

// It takes light as it did before: what is behind it is as dark, only it is not seen.
TEST(VolumeHoldout, ConvergesToTheReference) {
    for (const ShadeMode shade : {ShadeMode::texel, ShadeMode::pixel})
        for (const char* effect : {"two tints", "tints in each other's shadow", "all at once"}) {
            ViewScene scene = sceneWith(effect);
            scene.dials.shade = shade;
            scene.volumes.back().holdout = true;
            scene.volumes.back().emission.clear();
            scene.volumes.back().scatter.clear();
            expectConvergence(scene, 24, 0.7, 0.006, effect);
        }
}

TEST(VolumeHoldout, OfSurfacesBesideSmokeConvergesToTheReference) {
    ViewScene scene = sceneWith("light linking");
    Classified look;
    look.transfer = {{0.1, {1, 0.8, 0.6}, 0.0}, {0.4, {1, 0.8, 0.6}, 0.3}, {0.9, {0.2, 0.8, 0.6}, 0.5}};
    scene.volumes.back().classified = std::make_shared<const Classified>(look);
    scene.volumes.back().holdout = true;
    expectConvergence(scene, 24, 0.7, 0.008, "surface held out");
    scene.volumes.back().holdout = false;
    scene.volumes.front().holdout = true;
    expectConvergence(scene, 24, 0.7, 0.1, "smoke held out");  // what is seen is the surface alone
}

// Instances of which some are held out do not share planes with those that are not.
TEST(VolumeHoldout, IsNotTakenForItsTwin) {
    ViewScene scene = plainScene();
    scene.ambient = Rgb(0.3);
    scene.volumes.push_back(scene.volumes.front());
    scene.volumes.back().wsFromIs[3] = {12, 0, 0, 1};
    scene.volumes.back().holdout = true;
    EXPECT_LE(errorOf(scene, 80), 0.02);
}

}  // namespace
}  // namespace scrim::test
