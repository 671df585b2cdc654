// SPDX-License-Identifier: Apache-2.0
// Points that the eye sees as balls: what a picture sums up to is what their chords do, whatever pixels and voxels are,
// and what lies in front of them hides them.
#include "support/expect_error.h"
#include "support/fields.h"

#include <scrim/engine/balls/ball_profile.h>
#include <scrim/verify/verify.h>
#include <scrim/volume/field_builder.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;

using Numbers = std::vector<double>;

/// One number of each point, in a field's form.
std::shared_ptr<SparseField> listOf(const Numbers& values, const Mat4& wsFromIs = Mat4(1.0)) {
    FieldPieces pieces;
    pieces.name = "points";
    pieces.wsFromIs = wsFromIs;
    for (std::size_t i = 0; i < values.size(); i += kBlockVoxels)
        pieces.blockOrigins.emplace_back(static_cast<int>(i / kBlockVoxels) * kBlockEdge, 0, 0);
    pieces.fill = [&](std::size_t b, float* to) {
        for (std::size_t i = 0; i < kBlockVoxels; ++i) {
            const std::size_t at = b * kBlockVoxels + i;
            to[i] = at < values.size() ? static_cast<float>(values[at]) : 0;
        }
    };
    return std::make_shared<SparseField>(buildField(std::move(pieces)));
}

struct Points {
    std::vector<Vec3> at;
    Numbers radius;
    Numbers emission = {};
    std::vector<Vec3> velocity = {};
};

/// Places are kept in a box of 64 units around the origin.
std::shared_ptr<ViewBalls> ballsOf(const Points& points) {
    const Mat4 box = glm::scale(glm::translate(Mat4(1.0), Vec3(-32)), Vec3(64));
    auto out = std::make_shared<ViewBalls>();
    for (int axis = 0; axis < 3; ++axis) {
        Numbers values;
        for (const Vec3& at : points.at) values.push_back((at[axis] + 32) / 64);
        out->place[std::size_t(axis)] = listOf(values, box);
        if (points.velocity.empty()) continue;
        Numbers positive, negative;
        for (const Vec3& v : points.velocity) {
            positive.push_back(std::max(v[axis], 0.0));
            negative.push_back(std::max(-v[axis], 0.0));
        }
        out->velocity.push_back(listOf(positive, box));
        out->velocity.push_back(listOf(negative, box));
    }
    out->radius = listOf(points.radius, box);
    out->density = listOf(Numbers(points.at.size(), 1), box);
    if (!points.emission.empty()) out->emission.push_back({{listOf(points.emission, box)}, Rgb(1)});
    return out;
}

/// A scene of balls whose voxels, of this edge, are too thin to shade anything: 64 pixels show 16 units.
ViewScene sceneOf(const Points& points, double sigma, int voxel = 2, int resolution = 64) {
    const int edge = 8 / voxel;
    const auto thin = makeField(Int3(-edge), Int3(edge), voxel, [](const Vec3&) { return 1e-6; });
    Medium medium;
    medium.densityScale = sigma;
    medium.albedo = Rgb(0);
    ViewScene scene = orthographicScene(thin, medium, 16, resolution);
    scene.volumes[0].balls = ballsOf(points);
    return scene;
}

/// Sums over a picture, times the area of a pixel: red, alpha, and the mean place of alpha in world units.
struct Sums {
    double red = 0, alpha = 0;
    Vec2 at{0};
};

Sums sumsOf(const ViewScene& scene, const Image& image) {
    Sums out;
    const double edge = scene.camera.height / scene.camera.resolution.y;
    for (int y = scene.region.y0; y < scene.region.y1; ++y)
        for (int x = scene.region.x0; x < scene.region.x1; ++x) {
            const int width = scene.region.x1 - scene.region.x0;
            const float* const pixel = image.rgba.data() + 4 * ((y - scene.region.y0) * width + x - scene.region.x0);
            const double alpha = double(pixel[3]) * edge * edge;
            out.red += double(pixel[0]) * edge * edge;
            out.alpha += alpha;
            out.at += alpha * edge *
                      Vec2(x + 0.5 - 0.5 * scene.camera.resolution.x, 0.5 * scene.camera.resolution.y - y - 0.5);
        }
    out.at /= out.alpha;
    return out;
}

Sums sumsOf(const ViewScene& scene) {
    return sumsOf(scene, renderScene(scene).image);
}

/// The integral of 1 - exp(-sigma chord) over a ball's disc.
double opacityOf(double radius, double sigma) {
    const double h = 2 * radius * sigma;
    return kPi * radius * radius * (1 - 2 * (1 - (1 + h) * std::exp(-h)) / (h * h));
}

// A ball is lit as a sheet of an optical depth of 1/8192, whose opacity is less than that by half of it: 6e-5. The rest
// is for sums of floats.
constexpr double kExact = 2e-4;

// Of opaque balls larger than a pixel 0.2 % is lost where the points that draw them overlap (kRing in ball_sheets.cpp).
constexpr double kOpaque = 2.5e-3;

TEST(BallProfile, SharesOfRingsAreIntegralsOfChords) {
    for (const double h : {0.0, 1e-7, 1e-3, 0.049, 0.051, 0.7, 6.0, 90.0, 1e5}) {
        const auto integral = [&](double from, double to) {
            constexpr int kSteps = 20000;
            double sum = 0;
            for (int i = 0; i < kSteps; ++i) {
                // Evenly in s, where the integrand has no root: q dq = -s ds.
                const double a = std::sqrt(1 - from * from), b = std::sqrt(1 - to * to);
                const double s = b + (i + 0.5) / kSteps * (a - b);
                sum += 2 * s * (a - b) / kSteps * (h > 0 ? -std::expm1(-h * s) / h : s);
            }
            return sum;
        };
        const double all = ballShare(h, 0, 1);
        EXPECT_NEAR(all, integral(0, 1), 2e-6 * all + 1e-9) << h;
        EXPECT_NEAR(ballShare(h, 0.3, 0.6), integral(0.3, 0.6), 2e-6 * all + 1e-9) << h;
        double rings = 0;
        for (int i = 0; i < 7; ++i) rings += ballShare(h, i / 7.0, (i + 1) / 7.0);
        EXPECT_NEAR(rings, all, 1e-12) << h;
    }
}

TEST(Balls, HideWhatTheirChordsDoWhateverTheirSizeAndTheVoxels) {
    for (const double radius : {0.004, 0.11, 0.2, 0.9, 3.1})  // a pixel is 0.25
        for (const double h : {0.01, 1.0, 25.0})
            for (const int voxel : {1, 4}) {
                const double sigma = h / (2 * radius);
                const Vec3 at(0.37, -1.21, 0.6);
                const Sums sums = sumsOf(sceneOf({{at}, {radius}}, sigma, voxel));
                const double exact = radius > 0.25 && h > 10 ? kOpaque : kExact;
                EXPECT_NEAR(sums.alpha / opacityOf(radius, sigma), 1, exact) << radius << " " << h << " " << voxel;
                EXPECT_LT(glm::distance(sums.at, Vec2(at)), 2e-3) << radius << " " << h << " " << voxel;
            }
}

TEST(Balls, AreAsSharpAsTheirRadiiAndSeenAtTheirPlace) {
    const ViewScene scene = sceneOf({{{0.5, 0.25, 1}}, {2}}, 1e4);
    const Frame frame = renderScene(scene);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            const double distance = glm::distance(Vec2(0.25 * (x + 0.5) - 8, 8 - 0.25 * (y + 0.5)), Vec2(0.5, 0.25));
            const double alpha = pixelOf(frame, x, y)[3];
            // Pixels are bilinear: they reach the diagonal of one, 0.36, from their centres.
            if (distance < 2 - 0.36) {
                EXPECT_NEAR(alpha, 1, 0.03) << x << " " << y;
            }
            if (distance > 2 + 0.36) {
                EXPECT_EQ(alpha, 0) << x << " " << y;
            }
        }
}

TEST(Balls, ManyAddUpInAnyOrder) {
    Points points;
    double expected = 0;
    for (int i = 0; i < 3000; ++i) {
        const auto part = [&](double step) { return 14 * std::fmod(0.5 + step * (i + 1), 1.0) - 7; };
        points.at.emplace_back(part(0.8191725), part(0.6710436), part(0.5497005));
        points.radius.push_back(0.01 + 0.02 * std::fmod(0.618 * i, 1.0));
        expected += opacityOf(points.radius.back(), 0.5);
    }
    // So thin that two of them hide what both do, less a ten-thousandth.
    const Sums sums = sumsOf(sceneOf(points, 0.5));
    EXPECT_NEAR(sums.alpha / expected, 1, 3e-4);
    std::reverse(points.at.begin(), points.at.end());
    std::reverse(points.radius.begin(), points.radius.end());
    EXPECT_NEAR(sumsOf(sceneOf(points, 0.5)).alpha / sums.alpha, 1, 1e-5);
}

TEST(Balls, SendWhatTheirChordsEmit) {
    for (const double radius : {0.02, 1.1})
        for (const double sigma : {0.0, 0.5, 40.0}) {
            const Sums sums = sumsOf(sceneOf({{{1, 0.3, -0.2}}, {radius}, {7}}, sigma));
            const double expected =
                7 * (sigma > 0 ? opacityOf(radius, sigma) / sigma : 4.0 / 3 * kPi * radius * radius * radius);
            EXPECT_NEAR(sums.red / expected, 1, radius * sigma > 10 ? kOpaque : kExact) << radius << " " << sigma;
        }
}

TEST(Balls, DiscsAreAsOpaqueAsTheyWeigh) {
    for (const double weight : {0.25, 1.0, 8.0}) {
        ViewScene scene = sceneOf({{{1, 0.3, -0.2}}, {0.5}, {3}}, weight);
        auto discs = std::make_shared<ViewBalls>(*scene.volumes[0].balls);
        discs->discs = true;
        scene.volumes[0].balls = discs;
        const Sums sums = sumsOf(scene);
        EXPECT_NEAR(sums.alpha / (kPi * 0.25), std::min(weight, 1.0), weight < 1 ? kExact : kOpaque) << weight;
        EXPECT_NEAR(sums.red / (kPi * 0.25), 3, 3 * (weight < 1 ? kExact : kOpaque)) << weight;
    }
}

/// A slab of optical depth 1 from z = -1 to 1, which balls are in front of, within, or behind.
ViewScene withSlab(ViewScene scene) {
    const auto slab = boxField(Int3(-12, -12, -2), Int3(12, 12, 2), 0.5);
    Medium medium;
    medium.densityScale = 0.4;  // 2.5 units of it, with the rims that tents have
    medium.albedo = Rgb(0);
    scene.volumes.push_back({"slab", slab, slab->wsFromIs, medium});
    return scene;
}

TEST(Balls, AreHiddenByWhatLiesInFrontOfThem) {
    for (const double towards : {-1.0, 1.0})  // lights on either side make sheets be swept from there
        for (const double z : {4.0, 0.0, -4.0}) {
            ViewScene scene = withSlab(sceneOf({{{0.3, 0.2, z}}, {0.03}, {5}}, 0.5));
            scene.lights = {distantLight({0.3, 0.2, towards})};
            const double tau = z > 1 ? 0 : z < -1 ? 1 : 0.5;
            const Sums sums = sumsOf(scene);
            // Half a sheet of the slab, whose sheets are half a unit thick, is mixed evenly.
            EXPECT_NEAR(sums.red / (5 * opacityOf(0.03, 0.5) / 0.5 * std::exp(-tau)), 1, z == 0 ? 0.02 : 1e-3)
                << towards << " " << z;
        }
}

TEST(Balls, AreLitThroughWhatShadesTheirPlaceAndHaveItsAlbedo) {
    for (const double towards : {-1.0, 1.0})
        for (const bool shaded : {false, true}) {
            ViewScene scene = sceneOf({{{0.3, 0.2, towards > 0 ? -3.0 : 3.0}}, {0.03}}, 0.5);
            scene.volumes[0].medium.albedo = Rgb(0.6);
            if (shaded) scene = withSlab(std::move(scene));
            // The ball lies beyond the slab for the light, and for the eye if this looks along the light.
            scene.lights = {distantLight({0, 0, -towards}, 4)};
            scene.volumes[0].balls = ballsOf({{{0.3, 0.2, towards > 0 ? -3.0 : 3.0}}, {0.03}});
            const double tau = shaded ? (towards > 0 ? 2 : 1) : 0;
            const double expected = 0.6 * 4 / (4 * kPi) * opacityOf(0.03, 0.5) * std::exp(-tau);
            EXPECT_NEAR(sumsOf(scene).red / expected, 1, shaded ? 0.01 : 1e-3) << towards << " " << shaded;
        }
}

// Where everything emits what it hides times a radiance of 1, light is seen as opacity is, however much overlaps.
TEST(Balls, ThatOverlapInASheetAndInSmokeKeepTheirLight) {
    for (const double sigma : {0.4, 3.0, 80.0})
        for (const double towards : {-1.0, 1.0}) {
            Points points;
            for (int i = 0; i < 400; ++i) {
                const auto part = [&](double step) { return std::fmod(0.5 + step * (i + 1), 1.0) - 0.5; };
                points.at.emplace_back(6 * part(0.8191725), 6 * part(0.6710436), 2.4 * part(0.5497005));
                points.radius.push_back(0.02 + 0.5 * std::fmod(0.618 * i, 1.0));
                points.emission.push_back(sigma);
            }
            ViewScene scene = withSlab(sceneOf(points, sigma));
            scene.volumes[1].emission = {{{scene.volumes[1].field, scene.volumes[1].wsFromIs}, Rgb(0.4)}};
            scene.lights = {distantLight({0.3, 0.2, towards})};
            const Frame frame = renderScene(scene);
            double most = 0;
            for (int y = 0; y < 64; ++y)
                for (int x = 0; x < 64; ++x) {
                    const auto pixel = pixelOf(frame, x, y);
                    EXPECT_NEAR(pixel[0], pixel[3], 3e-4) << sigma << " " << towards << " " << x << " " << y;
                    most = std::max(most, pixel[3]);
                }
            EXPECT_GT(most, sigma > 1 ? 0.999 : 0.85);
        }
}

// Four opaque balls in one sheet: the first one is seen, in whatever order the file has them.
TEST(Balls, ThatOverlapInASheetAreSeenFromFrontToBack) {
    for (const double towards : {-1.0, 1.0})
        for (const bool reversed : {false, true}) {
            Points points;
            for (int i = 0; i < 4; ++i) {
                points.at.emplace_back(0, 0, 0.2 + 0.1 * (reversed ? 3 - i : i));
                points.radius.push_back(2);
                points.emission.push_back(100 * (reversed ? i + 1 : 4 - i));
            }
            ViewScene scene = sceneOf(points, 100);
            scene.lights = {distantLight({0.3, 0.2, towards})};
            const Frame frame = renderScene(scene);
            for (int x = 28; x < 36; ++x) {
                // A pixel sees up to 2.5 % less of the first one than all.
                EXPECT_NEAR(pixelOf(frame, x, 32)[0], 1, 0.03) << towards << " " << reversed;
                EXPECT_LE(pixelOf(frame, x, 32)[3], 1);
            }
        }
}

// What hides everything is not brighter than it is.
TEST(Balls, ThatAreOpaqueAreAsBrightAsTheyAre) {
    const double sigma = 1000;
    const Frame frame = renderScene(sceneOf({{{0.1, 0.07, 0}}, {3.1}, {sigma}}, sigma));
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) EXPECT_LT(pixelOf(frame, x, y)[0], 1.0002) << x << " " << y;
}

TEST(Balls, MoveByTheirVelocitiesInTheLayerOfMotion) {
    ViewScene scene = sceneOf({{{-3, 0.3, -2}, {4, 1, 2}}, {0.7, 0.04}, {}, {{3, 1.5, 8}, {-1, 0.25, 0}}}, 2);
    scene.layers = {Layer::motion};
    auto motion = std::make_shared<VolumeMotion>();
    motion->wsPerVelocity = Mat3(0.5);
    scene.volumes[0].motion = motion;
    for (const Rgb tint : {Rgb(1), Rgb(1, 0.5, 0.25)})
        for (const bool moves : {false, true}) {
            scene.volumes[0].medium.extinctionTint = tint;
            motion->wsNextFromWs[3] = {0, moves ? 1 : 0, 0, 1};
            const Frame frame = renderScene(scene);
            int seen = 0;
            for (int y = 0; y < 64; ++y)
                for (int x = 0; x < 64; ++x) {
                    const float* const at = frame.layers[0].data.data() + 2 * std::size_t(y * 64 + x);
                    if (pixelOf(frame, x, y)[3] < 1e-4) continue;
                    ++seen;
                    EXPECT_NEAR(at[0], x < 32 ? 6 : -2, 1e-3) << x << " " << y;
                    EXPECT_NEAR(at[1], (x < 32 ? 3 : 0.5) + (moves ? 4 : 0), 1e-3) << x << " " << y;
                }
            EXPECT_GT(seen, 20);
        }
}

TEST(Balls, DrawTheirWaysWhileTheShutterIsOpen) {
    Points points{{{0.5, -0.4, 1}}, {0.02}, {}, {{3, 1.5, 0}}};
    ViewScene scene = sceneOf(points, 0.5);
    auto moving = std::make_shared<ViewBalls>(*scene.volumes[0].balls);
    moving->time = {0.25, 1.25};
    scene.volumes[0].balls = moving;
    const Frame frame = renderScene(scene);
    const Sums sums = sumsOf(scene, frame.image);
    EXPECT_NEAR(sums.alpha / opacityOf(0.02, 0.5), 1, kExact);
    EXPECT_LT(glm::distance(sums.at, Vec2(0.5 + 3 * 0.75, -0.4 + 1.5 * 0.75)), 0.01);
    // Columns that lie on the way see equal parts of it.
    const double from = 0.5 + 3 * 0.25, to = 0.5 + 3 * 1.25;
    for (int x = 0; x < 64; ++x) {
        double sum = 0;
        for (int y = 0; y < 64; ++y) sum += pixelOf(frame, x, y)[3] * 0.0625;
        const double at = 0.25 * (x + 0.5) - 8, part = 0.25 / (to - from) * opacityOf(0.02, 0.5);
        if (at > from + 0.3 && at < to - 0.3) {
            EXPECT_NEAR(sum / part, 1, 0.05) << x;
        }
        if (at < from - 0.3 || at > to + 0.3) {
            EXPECT_EQ(sum, 0) << x;
        }
    }
}

TEST(Balls, ColoursHideByTheirOwnProfiles) {
    ViewScene scene = sceneOf({{{0.3, 0.2, 1}}, {0.7}}, 1);
    scene.volumes[0].medium.extinctionTint = {2, 0.5, 0.1};
    scene.layers = {Layer::transmittance};
    const Frame frame = renderScene(scene);
    std::array<double, 3> hidden{};
    for (std::size_t i = 0; i < frame.layers[0].data.size(); ++i)
        hidden[i % 3] += (1 - double(frame.layers[0].data[i])) * 0.0625;
    EXPECT_NEAR(hidden[0] / opacityOf(0.7, 2), 1, kExact);
    EXPECT_NEAR(hidden[1] / opacityOf(0.7, 0.5), 1, kExact);
    EXPECT_NEAR(hidden[2] / opacityOf(0.7, 0.1), 1, kExact);
}

TEST(Balls, LayersOfLightsAndVolumesAddUpToThePicture) {
    ViewScene scene = withSlab(sceneOf({{{0.3, 0.2, 0}, {1, 1, -3}}, {0.3, 0.02}, {2, 5}}, 0.7));
    scene.volumes[0].medium.albedo = Rgb(0.5);
    scene.volumes[1].medium.albedo = Rgb(0.8);
    scene.lights = {distantLight({0.3, 0.2, -1}, 2), distantLight({-1, 0.4, 0.5})};
    const Frame alone = renderScene(scene);
    scene.layers = {Layer::light, Layer::volume, Layer::emission};
    const Frame frame = renderScene(scene);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            double lights = 0, volumes = 0;
            const std::size_t at = std::size_t(y * 64 + x);
            for (const FrameLayer& layer : frame.layers) {
                const double red = double(layer.data[at * (layer.data.size() / 4096)]);
                if (layer.layer == Layer::volume) volumes += red;
                if (layer.layer != Layer::volume) lights += red;
            }
            const double red = pixelOf(alone, x, y)[0];
            EXPECT_NEAR(lights, red, 2e-5 * (1 + red)) << x << " " << y;
            EXPECT_NEAR(volumes, red, 2e-5 * (1 + red)) << x << " " << y;
        }
}

TEST(Balls, DeepPicturesEndAsFlatOnesDo) {
    ViewScene scene = withSlab(sceneOf({{{0.3, 0.2, 3}, {1, 1, -3}}, {0.6, 0.02}, {2, 5}}, 0.7));
    scene.deep = ViewDeep{1e-4};
    const Frame frame = renderScene(scene);
    ASSERT_TRUE(frame.deep.has_value());
    ViewScene flat = scene;
    flat.deep.reset();
    const Frame same = renderScene(flat);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) EXPECT_EQ(pixelOf(frame, x, y), pixelOf(same, x, y)) << x << " " << y;
}

TEST(Balls, ACropHasTheBitsOfTheWhole) {
    Points points;
    for (int i = 0; i < 200; ++i) {
        const auto part = [&](double step) { return 14 * std::fmod(0.5 + step * (i + 1), 1.0) - 7; };
        points.at.emplace_back(part(0.8191725), part(0.6710436), part(0.5497005));
        points.radius.push_back(0.3 * std::fmod(0.618 * i, 1.0) + 0.01);
    }
    const auto expectBitsOf = [](const ViewScene& scene) {
        const Frame whole = renderScene(scene);
        ViewScene part = scene;
        part.picture = scene.region;
        for (const PixelWindow& region : {PixelWindow{13, 22, 51, 40}, PixelWindow{0, 0, 22, 64}}) {
            part.region = region;
            const Frame crop = renderScene(part);
            for (int y = region.y0; y < region.y1; ++y)
                for (int x = region.x0; x < region.x1; ++x) {
                    EXPECT_EQ(pixelOf(crop, x, y), pixelOf(whole, x, y)) << x << " " << y;
                    const auto own = std::size_t((y - region.y0) * region.width() + x - region.x0);
                    for (std::size_t c = 0; c < 2; ++c)
                        EXPECT_EQ(crop.layers[0].data[2 * own + c],
                                  whole.layers[0].data[2 * std::size_t(y * 64 + x) + c])
                            << x << " " << y;
                }
        }
    };
    for (const Rgb tint : {Rgb(1), Rgb(1, 0.5, 0.25)}) {
        ViewScene scene = withSlab(sceneOf(points, 2));
        scene.volumes[0].medium.albedo = Rgb(0.5);
        scene.volumes[0].medium.extinctionTint = tint;
        scene.lights = {distantLight({0.3, 0.2, -1}, 2)};
        scene.layers = {Layer::depth};
        expectBitsOf(scene);
        // Alone, with voxels around themselves only, so that a tile has sheets without anything.
        scene.volumes.pop_back();
        ViewVolume& volume = scene.volumes[0];
        volume.field = makeField(Int3(-32), Int3(32), 0.25, [&](const Vec3& is) {
            const bool near =
                std::ranges::any_of(points.at, [&](const Vec3& at) { return glm::distance(at, 0.25 * is) < 0.5; });
            return near ? 1e-6 : 0;
        });
        volume.wsFromIs = volume.field->wsFromIs;
        scene.camera.type = CameraType::perspective;
        scene.camera.fov = 25;
        scene.dials.sheetThickness = 0.3;
        expectBitsOf(scene);
    }
}

TEST(Balls, ASolidHidesThoseBehindIt) {
    ViewScene scene = sceneOf({{{0.3, 0.2, 3}, {-4, 1, -3}}, {0.05, 0.05}}, 3);
    scene.camera.near = 20;  // the camera is 40 in front of the box of voxels, whose face is at 8
    const double all = 2 * opacityOf(0.05, 3);
    EXPECT_NEAR(sumsOf(scene).alpha / all, 1, kExact);
    scene.camera.near = scene.camera.wsPosition.z;  // all in front of z = 0 is too near
    EXPECT_NEAR(sumsOf(scene).alpha / all, 0.5, kExact);
}

TEST(Balls, BruteForceRefusesThem) {
    const ViewScene scene = sceneOf({{{0, 0, 0}}, {1}}, 1);
    const Frame frame = renderScene(scene);
    EXPECT_EQ(errorOf(ErrorKind::usage, [&] { samplePixels(scene, frame.image, 10, 1); }),
              "the picture shows the points of volume 'volume' themselves, but brute force marches through their "
              "voxels; 'sharp = false' in [volume.points] shows these, too");
}

}  // namespace
}  // namespace scrim::test
