// SPDX-License-Identifier: Apache-2.0
// Points become voxels whose sums, places and ways are those of the points, whatever the voxels' edge.
#include <scrim/shot/moved_field.h>
#include <scrim/volume/point_raster.h>

#include "support/expect_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace scrim {
namespace {

using test::errorOf;
constexpr double kPi = std::numbers::pi;

PointCloud cloudOf(const std::vector<Vec3>& places, const std::vector<float>& radii) {
    PointCloud cloud;
    cloud.name = "spray";
    cloud.positions = places;
    cloud.attributes.push_back({"pscale", 1, radii});
    return cloud;
}

SparseField densityOf(const PointCloud& cloud, const PointLook& look) {
    const PointRaster raster(cloud, look, "a.vdb", {});
    BlockMemory memory;
    return raster.fields(raster.blocks(), nullptr, {{"spray"}}, memory).front();
}

/// Calls visit(world position, value) for all voxels that are not 0.
template <typename Visit>
void visitVoxels(const SparseField& field, const Visit& visit) {
    for (std::size_t b = 0; b < field.blockCount(); ++b)
        for (int i = 0; i < kBlockVoxels; ++i)
            if (const float value = field.block(b)[i]; value != 0)
                visit(transformPoint(field.wsFromIs, Vec3(field.blockOrigins[b] + Int3(i >> 6, i >> 3 & 7, i & 7))),
                      double(value));
}

/// The integral of a field over the world, and its centre.
std::pair<double, Vec3> massOf(const SparseField& field) {
    const double edge = field.wsFromIs[0][0], volume = edge * edge * edge;
    double sum = 0;
    Vec3 centre(0);
    visitVoxels(field, [&](const Vec3& ws, double value) {
        sum += value * volume;
        centre += ws * value * volume;
    });
    return {sum, centre / sum};
}

TEST(PointRaster, KeepsWhatAPointWeighsAndWhereItIsForAnyVoxel) {
    const double r = 0.3;
    const Vec3 at(1.37, -2.11, 0.53);
    for (const double voxel : {3.0, 1.5, 0.7, 0.6, 0.3, 0.21, 0.19, 0.1, 0.05, 0.02}) {
        const auto [ball, centre] = massOf(densityOf(cloudOf({at}, {0.3f}), {.voxel = voxel}));
        // Rounding of floats. A ball of three voxels has a rim of one, which samples at voxels place a little off.
        EXPECT_NEAR(ball, 4.0 / 3 * kPi * r * r * r, 1e-5 * ball) << voxel;
        EXPECT_LT(glm::distance(centre, at), (r < 1.5 * voxel ? 1e-4 : 0.05) * voxel) << voxel;
        const auto [disc, same] = massOf(densityOf(cloudOf({at}, {0.3f}), {.voxel = voxel, .discs = true}));
        EXPECT_NEAR(disc, kPi * r * r, 1e-5 * disc) << voxel;
    }
}

TEST(PointRaster, AnOpaqueBallCoversItsDisc) {
    const double r = 1, voxel = 1.0 / 32;
    const SparseField field = densityOf(cloudOf({{0.01, 0.02, 0.003}}, {1}), {.voxel = voxel});
    std::map<std::pair<double, double>, double> depths;  // along z, by x and y
    visitVoxels(field, [&](const Vec3& ws, double value) { depths[{ws.x, ws.y}] += value * voxel; });
    for (const double sigma : {0.5, 2.0, 20.0}) {
        double covered = 0;
        for (const auto& [at, depth] : depths) covered += (1 - std::exp(-sigma * depth)) * voxel * voxel;
        // The integral of 1 - exp(-sigma chord) over the disc.
        const double t = 2 * sigma * r;
        const double expected = kPi * r * r * (1 - 2 * (1 - (1 + t) * std::exp(-t)) / (t * t));
        // The rim is a voxel wide. An opaque ball shows its outer half, too, which is a ring of half a voxel.
        EXPECT_NEAR(covered, expected, 2 * kPi * r * voxel / 2) << sigma;
    }
    EXPECT_NEAR(double(field.maxValue), 1, 0.01) << "within the ball";
}

TEST(PointRaster, PointsAddUpAndTheirAttributesAreMeansByWeight) {
    PointCloud cloud = cloudOf({{0, 0, 0}, {0.05, 0, 0}, {40, 0, 0}}, {0.2f, 0.2f, 0.1f});
    cloud.attributes.push_back({"density", 1, {1, 3, 2}});
    cloud.attributes.push_back({"heat", 1, {10, 30, 7}});
    const PointRaster raster(cloud, {.voxel = 1}, "a.vdb", {});
    BlockMemory memory;
    const PointBlocks blocks = raster.blocks();
    EXPECT_EQ(blocks.origins.size(), 2u) << "one at the origin, one around the far point";
    const SparseField density = raster.fields(blocks, nullptr, {{"d"}}, memory).front();
    const auto ball = [](double r) { return 4.0 / 3 * kPi * r * r * r; };
    EXPECT_NEAR(massOf(density).first, ball(0.2) * (1 + 3) + ball(0.1) * 2, 1e-6);
    const SparseField heat = raster.fields(blocks, raster.cloud().attribute("heat"), {{"heat"}}, memory).front();
    std::map<bool, std::pair<double, double>> range{{false, {1e9, 0}}, {true, {1e9, 0}}};
    visitVoxels(heat, [&](const Vec3& ws, double value) {
        auto& [least, most] = range[ws.x > 20];
        least = std::min(least, value);
        most = std::max(most, value);
    });
    EXPECT_NEAR(range[true].first, 7, 1e-5);
    EXPECT_NEAR(range[true].second, 7, 1e-5);
    EXPECT_GE(range[false].first, 9.999);
    EXPECT_LE(range[false].second, 30.001);
    double weighted = 0;
    visitVoxels(heat, [&](const Vec3& ws, double value) {
        visitVoxels(density, [&](const Vec3& other, double d) { weighted += other == ws ? d * value : 0; });
    });
    EXPECT_NEAR(weighted, ball(0.2) * (10 + 3 * 30) + ball(0.1) * 2 * 7, 1e-5);
}

TEST(PointRaster, PointsMoveByTheirVelocity) {
    PointCloud cloud = cloudOf({{0.3, 0.1, 0.2}, {6, 0, 0}}, {0.25f, 0.25f});
    cloud.attributes.push_back({"v", 3, {4, -2, 1, 0, 3, 0}});
    const PointRaster raster(cloud, {.voxel = 0.125, .open = -0.5, .close = 0.5}, "a.vdb", {});
    BlockMemory memory;
    const SparseField density = raster.fields(raster.blocks(), nullptr, {{"d"}}, memory).front();
    const PointAttribute& v = *raster.cloud().attribute("v");
    std::vector<PointRaster::Wanted> wanted;
    for (int axis = 0; axis < 3; ++axis)
        for (const GridPart part : {GridPart::positive, GridPart::negative}) wanted.push_back({"v", axis, part});
    std::vector<FieldPointer> velocity;
    for (SparseField& field : raster.fields(raster.blocksOnWay(&v), &v, wanted, memory))
        velocity.push_back(std::make_shared<SparseField>(std::move(field)));
    const FieldMover mover(velocity, density);
    for (const double time : {-0.5, -0.2, 0.1, 0.5}) {
        const FieldPointer moved = mover.moved(std::make_shared<SparseField>(density), time);
        const auto [mass, centre] = massOf(*moved);
        EXPECT_NEAR(mass, massOf(density).first, 0.01 * mass) << time;
        const Vec3 expected = 0.5 * (Vec3(6.3, 0.1, 0.2) + time * Vec3(4, 1, 1));
        EXPECT_LT(glm::distance(centre, expected), 0.01) << time;
    }
}

TEST(PointRaster, LeavesUnsoundPointsOutWithAWord) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    std::string said;
    const PointRaster raster(cloudOf({{0, 0, 0}, {kNan, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {0.1f, 0.1f, 0, -1}),
                             {.voxel = 0.1}, "a.vdb", [&](Severity severity, const std::string& text) {
                                 if (severity == Severity::warning) said += text;
                             });
    EXPECT_EQ(raster.cloud().positions.size(), 1u);
    EXPECT_EQ(said,
              "a.vdb: 3 of 4 points 'spray' are left out: their places are not finite, or their radii or densities not "
              "above 0");
}

TEST(PointRaster, PointsAreSeenByThemselvesWhereTheyAreFarApart) {
    std::vector<Vec3> places;
    for (int i = 0; i < 1000; ++i)
        places.push_back(
            10.0 * Vec3(std::fmod(0.8191725 * i, 1.0), std::fmod(0.6710436 * i, 1.0), std::fmod(0.5497005 * i, 1.0)));
    const auto rasterOf = [&](float radius, const PointLook& look, bool listed = true) {
        return PointRaster(cloudOf(places, std::vector<float>(places.size(), radius)), look, "a.vdb", {}, listed);
    };
    // At 0.5 they fill half of their box, at 0.01 a 250,000th.
    EXPECT_FALSE(rasterOf(0.5f, {}).sharp());
    EXPECT_TRUE(rasterOf(0.01f, {}).sharp());
    EXPECT_FALSE(rasterOf(0.01f, {}, false).sharp()) << "nobody asks for lists";
    EXPECT_FALSE(rasterOf(0.01f, {.sharp = false}).sharp());
    EXPECT_TRUE(rasterOf(0.5f, {.sharp = true}).sharp());
    // Of stated voxels the diameter decides.
    EXPECT_FALSE(rasterOf(0.01f, {.voxel = 0.015}).sharp());
    EXPECT_TRUE(rasterOf(0.01f, {.voxel = 0.025}).sharp());
    // Voxels for light alone: at most 512 along the box.
    const double voxel = rasterOf(0.01f, {}).wsFromIs()[0][0];
    EXPECT_GE(voxel * 512, 9.9);
    EXPECT_LE(voxel, 0.02 * 1.001);
    EXPECT_DOUBLE_EQ(rasterOf(0.01f, {.sharp = false}).wsFromIs()[0][0], double(0.01f) / 2);
}

TEST(PointRaster, ChoosesVoxelsByRadiiAndRefusesTooSmallOnes) {
    EXPECT_DOUBLE_EQ(PointRaster(cloudOf({{0, 0, 0}}, {0.5f}), {}, "a.vdb", {}).wsFromIs()[0][0], 0.25);
    EXPECT_DOUBLE_EQ(PointRaster(cloudOf({{0, 0, 0}}, {0.5f}), {.radius = 2, .scale = 3}, "a.vdb", {}).wsFromIs()[0][0],
                     3);
    EXPECT_EQ(
        errorOf(ErrorKind::input,
                [] {
                    PointRaster(cloudOf({{0, 0, 0}, {1e6, 0, 0}}, {0.5f, 0.5f}), {.voxel = 0.001}, "a.vdb", {});
                }),
        "a.vdb: its points lie 1e+06 apart, which voxels of 0.001 cannot span; expected a 'voxel' of points of at "
        "least 0.119");
    PointCloud bare = cloudOf({{0, 0, 0}}, {});
    bare.attributes.clear();
    bare.spacing = 0.5;
    std::string said;
    const PointRaster chosen(bare, {}, "a.vdb", [&](Severity, const std::string& text) { said += text + "\n"; });
    EXPECT_EQ(said,
              "a.vdb: points 'spray' have no radius (pscale, radius or width): 0.25 is taken, half of their spacing\n"
              "a.vdb: 1 points 'spray' of a usual radius of 0.25 become voxels of 0.125 in 8 blocks (0 MB a grid); "
              "'voxel' of points changes this\n");
}

TEST(PointRaster, PointsFarApartAreBlurredRatherThanFillTheMemory) {
    // 300,000 points, each of which would take blocks of its own.
    std::vector<Vec3> places;
    for (int i = 0; i < 300'000; ++i) places.emplace_back(i % 67, i / 67 % 67, i / 4489);
    std::string warned;
    const PointRaster raster(cloudOf(places, std::vector<float>(places.size(), 0.002f)), {}, "a.vdb",
                             [&](Severity severity, const std::string& text) {
                                 if (severity == Severity::warning) warned = text;
                             });
    const std::size_t blocks = raster.blocks().origins.size();
    EXPECT_LE(blocks, std::size_t{1} << 18);
    EXPECT_GT(raster.wsFromIs()[0][0], 0.008);
    EXPECT_TRUE(warned.starts_with("a.vdb: its points are far apart, and blurred to voxels of ")) << warned;
    EXPECT_NE(warned.find("a 'voxel' of points of 0.004 shows each of them, and takes "), std::string::npos) << warned;
}

}  // namespace
}  // namespace scrim
