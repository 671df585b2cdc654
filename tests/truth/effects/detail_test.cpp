// SPDX-License-Identifier: Apache-2.0
// Shading between voxels (density_detail.h): a density is the sum of voxels and of finer voxels where that shows. The
// measure is what all voxels are divided to, which takes many times as many of them.
#include "soft_lights.h"
#include "support/fields.h"
#include "support/verified.h"

#include <scrim/shot/density_detail.h>
#include <scrim/shot/shaded_field.h>
#include <scrim/shot/ways_out.h>
#include <scrim/volume/field_sampler.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr double kVoxel = 0.5;

/// A ball of constant density with a rim of three voxels.
std::shared_ptr<SparseField> ball(int radius = 14) {
    return makeField(Int3(-radius), Int3(radius), kVoxel,
                     [=](const Vec3& is) { return std::clamp((radius - 1 - glm::length(is)) / 3, 0.0, 1.0); });
}

/// Noise of three octaves, the last of which has features of 1.2 voxels.
DensityShading eroded() {
    DensityShading shading;
    shading.noise = Noise{.amount = 0.8, .frequency = 0.4, .octaves = 3};
    shading.noiseMode = NoiseMode::erode;
    return shading;
}

/// An edge within the rim, much sharper than voxels.
DensityShading carved() {
    DensityShading shading;
    shading.edge = {{0.25, 0.35}};
    return shading;
}

DetailSource sourceOf(const FieldPointer& grid, const DensityShading& shading, double depth, int times = 2) {
    DetailSource out;
    out.grid = out.displaced = grid;
    out.shading = shading;
    out.shaded = shading.mask ? grid : shadedDensity(grid, shading, nullptr, Mat4(1.0));
    out.times = times;
    out.longDepth = out.shortDepth = static_cast<float>(depth);
    return out;
}

DetailedDensity wholeOf(DetailSource source) {
    source.whole = true;
    return detailedDensity(source);
}

/// The sum of both fields at a place on the lattice of the grid.
double sumAt(const FieldSampler& coarse, const FieldSampler& finer, int times, const Vec3& is) {
    return coarse.value(is) + finer.value(double(times) * is);
}

Vec3 somewhere(int i, double radius) {
    const Vec3 unit(std::fmod(0.5 + 0.8191725 * i, 1.0), std::fmod(0.5 + 0.6710436 * i, 1.0),
                    std::fmod(0.5 + 0.5497005 * i, 1.0));
    return radius * (2.0 * unit - 1.0);
}

/// What two densities differ by at many places: the root mean square, as an optical depth along a voxel.
template <typename One, typename Other>
double differenceOf(const One& one, const Other& other, double depth, double radius) {
    constexpr int kPlaces = 3000;
    double squares = 0;
    for (int i = 0; i < kPlaces; ++i) {
        const Vec3 is = somewhere(i, radius);
        squares += std::pow(depth * (one(is) - other(is)), 2);
    }
    return std::sqrt(squares / kPlaces);
}

/// A density as a function of places on the lattice of its grid.
class Field {
  public:
    Field(const DetailSource& source, DetailedDensity parts)
        : m_times(source.times), m_parts(std::move(parts)), m_coarse(*m_parts.coarse), m_finer(*m_parts.finer) {}
    double operator()(const Vec3& is) const { return sumAt(m_coarse, m_finer, m_times, is); }
    const DetailedDensity& parts() const { return m_parts; }

  private:
    int m_times;
    DetailedDensity m_parts;
    FieldSampler m_coarse, m_finer;
};

TEST(Detail, IsTheShadingOfAllFinerVoxels) {
    constexpr double kDepth = 2;
    for (const int times : {2, 4, 8}) {
        DetailSource source = sourceOf(ball(), eroded(), kDepth, times);
        source.hides = false;
        const Field parts(source, detailedDensity(source)), whole(source, wholeOf(source));
        EXPECT_TRUE(whole.parts().coarse->empty());
        const FieldSampler voxels(*source.shaded);
        // What is not divided may differ by kShown, 0.006, times the root of the depth.
        const double with = differenceOf(parts, whole, kDepth, 14);
        const double without = differenceOf([&](const Vec3& is) { return voxels.value(is); }, whole, kDepth, 14);
        EXPECT_LT(with, 0.006 * std::sqrt(kDepth)) << times;
        EXPECT_GT(without, 10 * with) << times << " without: " << without;
    }
}

TEST(Detail, DividesOnlyWhatShows) {
    // A remap is the same between voxels as at them.
    DensityShading twice;
    twice.remap = Remap{{0, 1}, {0, 2}};
    const DetailedDensity linear = detailedDensity(sourceOf(ball(), twice, 1));
    EXPECT_TRUE(linear.finer->empty());
    EXPECT_EQ(linear.coarse->activeVoxels, ball()->activeVoxels);
    // An edge shows in the rim, and not in the middle.
    DensityShading edge;
    edge.edge = {{0.3, 0.4}};
    const DetailSource source = sourceOf(ball(28), edge, 1);
    const Field rim(source, detailedDensity(source)), whole(source, wholeOf(source));
    const FieldSampler coarse(*rim.parts().coarse), finer(*rim.parts().finer);
    EXPECT_EQ(finer.value(Vec3(0)), 0);
    EXPECT_NEAR(coarse.value(Vec3(0)), 1, 1e-6);
    EXPECT_LT(rim.parts().finer->activeVoxels, whole.parts().finer->activeVoxels / 2);
    // No seam: voxels and finer voxels meet where both are nearly constant.
    EXPECT_LT(differenceOf(rim, whole, 1, 28), 0.006);
    // In a density so thin that nobody sees it, nothing shows.
    EXPECT_TRUE(detailedDensity(sourceOf(ball(), eroded(), 1e-4)).finer->empty());
}

TEST(Detail, DisplacesBetweenVoxels) {
    DetailSource source = sourceOf(ball(), {}, 5);
    source.displacement = Noise{.amount = 0.6, .frequency = 0.8, .octaves = 2};
    source.displaced = source.shaded = displacedField(source.grid, *source.displacement, Mat4(1.0));
    source.hides = false;
    const Field parts(source, detailedDensity(source)), whole(source, wholeOf(source));
    const FieldSampler voxels(*source.displaced);
    const double with = differenceOf(parts, whole, 5, 16);
    const double without = differenceOf([&](const Vec3& is) { return voxels.value(is); }, whole, 5, 16);
    EXPECT_LT(with, 0.006 * std::sqrt(5));
    EXPECT_GT(without, 10 * with) << without;
    // At voxels both are the displaced grid itself.
    for (int i = 0; i < 200; ++i) {
        const Int3 at(glm::round(somewhere(i, 12)));
        EXPECT_NEAR(whole(Vec3(at)), voxels.voxel(at), 1e-5);
    }
}

TEST(Detail, AppliesTheRampBetweenVoxelsToo) {
    DetailSource source = sourceOf(ball(), {}, 5);
    source.ramp = {{0, 0}, {0.4, 0}, {0.5, 1}, {1, 1}};
    const DetailedDensity parts = detailedDensity(source);
    EXPECT_FALSE(parts.finer->empty());
    const FieldSampler coarse(*parts.coarse), finer(*parts.finer), grid(*source.grid);
    for (int i = 0; i < 400; ++i) {
        const Int3 fine(glm::round(2.0 * somewhere(i, 13)));
        const double value = grid.value(0.5 * Vec3(fine));
        EXPECT_NEAR(sumAt(coarse, finer, 2, 0.5 * Vec3(fine)), std::clamp(10 * (value - 0.4), 0.0, 1.0), 1e-4);
    }
}

TEST(Detail, LeavesOutWhatNobodySees) {
    DetailSource source = sourceOf(ball(44), eroded(), 2);
    source.shading.noiseMode = NoiseMode::multiply;
    source.shading.noise->amount = 0.3;
    source.shaded = shadedDensity(source.grid, source.shading, nullptr, Mat4(1.0));
    const auto valueInside = [](const DetailSource& of, const Vec3& is) {
        return FieldSampler(*detailedDensity(of).finer).value(2.0 * is);
    };
    EXPECT_EQ(valueInside(source, Vec3(0)), 0);
    source.inside = {Int3(2, 1, 0)};
    EXPECT_GT(valueInside(source, Vec3(0)), 0) << "seen by an eye inside";
    source.inside.clear();
    source.hides = false;
    EXPECT_GT(valueInside(source, Vec3(0)), 0) << "cut open";
}

TEST(WaysOut, AreNoLongerThanTheShortest) {
    // A cube of 48 voxels: the way from its surface is straight.
    const auto cube = boxField(Int3(0), Int3(47));
    const WaysOut ways(*cube, 0.25, {}), seen(*cube, 0.25, {Int3(24)});
    double most = 0;
    for (int i = 0; i < 1000; ++i) {
        const Int3 at(glm::floor(somewhere(i, 24) + 24.0));
        const Int3 in = glm::min(at, 47 - at);
        const double straight = 0.25 * (1 + std::min({in.x, in.y, in.z})), way = ways.to(at, at);
        EXPECT_LE(way, straight) << at.x << " " << at.y << " " << at.z;
        EXPECT_GE(way, straight - 0.25 * 6) << "cells are two voxels wide";
        EXPECT_LE(seen.to(at, at), way);
        most = std::max(most, way);
    }
    EXPECT_GT(most, 4);
    EXPECT_EQ(seen.to(Int3(24), Int3(25)), 0);
    EXPECT_EQ(ways.to(Int3(-1), Int3(24)), 0) << "a part of the box is outside";
    EXPECT_EQ(WaysOut().to(Int3(24), Int3(24)), 0);
}

TEST(TimesFor, FitsTwoVoxelsToTheFinestOctave) {
    EXPECT_EQ(timesFor({.frequency = 1, .octaves = 1}, 0.5), 1);
    EXPECT_EQ(timesFor({.frequency = 1, .octaves = 2}, 0.5), 2);
    EXPECT_EQ(timesFor({.frequency = 1, .octaves = 3}, 0.5), 4);
    EXPECT_EQ(timesFor({.frequency = 1, .octaves = 9}, 0.5), 4);
    EXPECT_EQ(timesFor({.frequency = 1, .octaves = 2, .lacunarity = 4}, 0.5), 4);
}

/// A view of both fields as two volumes, as shots assemble them.
ViewScene viewOf(const DetailedDensity& parts, double depth) {
    Medium medium;
    medium.densityScale = depth / kVoxel;
    medium.albedo = Rgb(0.9, 0.8, 0.7);
    ViewScene scene = orthographicScene(parts.finer, medium, 22, 40);
    scene.volumes.front().place = 0;
    scene.lights = {distantLight({-1, -0.6, -0.5}, 3)};
    if (parts.coarse->empty()) return scene;
    ViewVolume& coarse = scene.volumes.emplace_back(scene.volumes.front());
    coarse.field = parts.coarse;
    coarse.wsFromIs = parts.coarse->wsFromIs;
    return scene;
}

/// The root mean square difference of colours, relative to the mean.
double difference(const Image& a, const Image& b) {
    double squares = 0, sum = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i) {
        if (i % 4 == 3) continue;
        squares += std::pow(double(a.rgba[i]) - double(b.rgba[i]), 2);
        sum += double(b.rgba[i]);
    }
    const double count = 0.75 * double(a.rgba.size());
    return std::sqrt(squares / count) / (sum / count);
}

TEST(Detail, LooksLikeAllFinerVoxelsInEveryLight) {
    const double depth = 0.5;
    const DetailSource source = sourceOf(ball(20), carved(), depth);
    const DetailedDensity parts = detailedDensity(source), whole = wholeOf(source);
    const auto compare = [&](const char* name, double most, const std::function<void(ViewScene&)>& change) {
        ViewScene two = viewOf(parts, depth), one = viewOf(whole, depth);
        ASSERT_EQ(two.volumes.size(), 2u);
        change(two);
        change(one);
        // Both have an error by texels and sheets, which must not hide what the division leaves.
        const Image a = renderScene(refined(two)).image, b = renderScene(refined(one)).image;
        EXPECT_LT(difference(a, b), most) << name;
    };
    // Each of the two is within about 1 % of the truth, and with cells of unlike size within 2 to 3 %.
    constexpr double kSheets = 0.015, kCells = 0.04;
    const auto scatter = [](ViewScene& s, Scattering scattering) {
        for (ViewVolume& v : s.volumes) {
            v.medium.scattering = scattering;
            v.medium.octaves.count = 6;
        }
    };
    const auto inLamp = [](ViewScene& s) { s.lights.front() = lamp({8, 20, 16}, 2000); };
    const auto inSky = [](ViewScene& s) { s.lights.front() = domeLight(24); };
    const auto octaves = [&](ViewScene& s) { scatter(s, Scattering::octaves); };
    const auto full = [&](ViewScene& s) { scatter(s, Scattering::full); };
    compare("sun", kSheets, [](ViewScene&) {});
    compare("lamp", kSheets, inLamp);
    compare("octaves", kSheets, octaves);
    compare("full", kCells, full);
    compare("sky", kCells, inSky);
    // Without detail, the picture is another one.
    const DetailedDensity none{std::make_shared<SparseField>(), source.shaded};
    EXPECT_GT(difference(renderScene(viewOf(none, depth)).image, renderScene(viewOf(whole, depth)).image), 0.08);
}

TEST(Detail, SharesTheLayersOfItsVolume) {
    const double depth = 0.5;
    ViewScene two = viewOf(detailedDensity(sourceOf(ball(20), carved(), depth)), depth);
    two.volumeCount = 1;
    two.layers = {Layer::volume, Layer::cryptomatte};
    const Frame frame = renderScene(two);
    ASSERT_EQ(frame.layers.size(), 2u) << "one of each for both fields";
    double most = 0, brightest = 0;
    for (std::size_t p = 0; p < frame.image.rgba.size() / 4; ++p)
        for (std::size_t c = 0; c < 3; ++c) {
            const double beauty = double(frame.image.rgba[4 * p + c]);
            most = std::max(most, std::abs(double(frame.layers.front().data[3 * p + c]) - beauty));
            brightest = std::max(brightest, beauty);
        }
    EXPECT_LT(most, 1e-5 * brightest);
}

TEST(Detail, AgreesWithBruteForce) {
    const double depth = 0.5;
    const ViewScene scene = viewOf(detailedDensity(sourceOf(ball(20), carved(), depth)), depth);
    ASSERT_EQ(scene.volumes.size(), 2u);
    // The silhouette is sharp.
    expectConvergence(scene, 60, 0.5, 0.01);
}

}  // namespace
}  // namespace scrim::test
