// SPDX-License-Identifier: Apache-2.0
// NanoVDB files, as NanoVDB's own functions write them, hold the same grids as OpenVDB's files.
#include <scrim/volume/vdb_bounds.h>
#include <scrim/volume/vdb_file.h>

#include "support/expect_error.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace scrim {
namespace {

using test::errorOf;
using test::makeNvdb;
using test::makeVdb;
using test::NanoCodec;

/// Smoke with a wave of values, a tile, and voxels far from it and below 0, placed somewhere.
test::MadeGrid smoke(const std::string& type) {
    test::MadeGrid made;
    made.type = type;
    for (int x = -9; x < 9; ++x)
        for (int y = 0; y < 9; ++y)
            for (int z = 0; z < 9; ++z) made.voxels.push_back({{x, y, z}, 1.5 + std::sin(x + 0.3 * y + 0.7 * z)});
    made.voxels.push_back({{5000, -5000, 70}, 2});
    made.tiles = {{{64, 0, 0}, 8, 2}, {{-256, 0, 128}, 128, 1}};
    made.voxelSize = 0.25;
    made.translate = {1, 2, 3};
    return made;
}

void expectSame(const SparseField& a, const SparseField& b, double tolerance, const std::string& what) {
    EXPECT_EQ(a.name, b.name) << what;
    EXPECT_EQ(a.wsFromIs, b.wsFromIs) << what;
    EXPECT_EQ(a.activeVoxels, b.activeVoxels) << what;
    ASSERT_EQ(a.blockOrigins, b.blockOrigins) << what;
    for (std::size_t i = 0; i < a.blockCount(); ++i)
        for (int n = 0; n < kBlockVoxels; ++n) ASSERT_NEAR(a.block(i)[n], b.block(i)[n], tolerance) << what;
    ASSERT_EQ(a.tiles.size(), b.tiles.size()) << what;
    for (std::size_t t = 0; t < a.tiles.size(); ++t) {
        EXPECT_EQ(a.tiles[t].origin, b.tiles[t].origin) << what;
        EXPECT_EQ(a.tiles[t].edge, b.tiles[t].edge) << what;
        EXPECT_NEAR(a.tiles[t].value, b.tiles[t].value, tolerance) << what;
    }
}

class Nano : public ::testing::Test {
  protected:
    std::string file(const std::string& name) const { return m_folder.file(name); }
    /// The grid as OpenVDB's file has it.
    SparseField inVdb(test::MadeGrid made) const {
        makeVdb(file("a.vdb"), {made});
        return VdbFile::open(file("a.vdb")).field("density", {});
    }
    test::TempFolder m_folder;
};

TEST_F(Nano, ScalarsOfEveryTypeAndCodecAreThoseOfOpenVdb) {
    const SparseField real = inVdb(smoke("float")), whole = inVdb(smoke("int32")), on = inVdb(smoke("mask"));
    // Values from 0.5 to 2.5 in 4, 8 or 16 bits of each leaf's range; FpN keeps them to its own tolerance.
    const std::vector<std::tuple<std::string, const SparseField*, double>> types{{"float", &real, 0},
                                                                                 {"double", &real, 0},
                                                                                 {"Fp4", &real, 2.0 / 15},
                                                                                 {"Fp8", &real, 2.0 / 255},
                                                                                 {"Fp16", &real, 2.0 / 65535},
                                                                                 {"FpN", &real, 0.05},
                                                                                 {"int32", &whole, 0},
                                                                                 {"mask", &on, 0},
                                                                                 {"bool", &on, 0}};
    for (const auto& [type, expected, tolerance] : types)
        for (const NanoCodec codec : {NanoCodec::none, NanoCodec::zip, NanoCodec::blosc}) {
            const std::string what = type + ", codec " + std::to_string(static_cast<int>(codec));
            makeNvdb(file("a.nvdb"), {smoke(type)}, codec);
            const VdbFile made = VdbFile::open(file("a.nvdb"));
            expectSame(made.field("density", {}), *expected, tolerance, what);
            const GridInfo info = made.info().grids.at(0);
            const bool isMask = type == "mask";  // which has a class of its own
            EXPECT_EQ(info.gridClass, isMask ? "unknown" : "fog volume") << what;
            EXPECT_TRUE(info.codec.ends_with(isMask ? "(NanoVDB Mask)" : "(NanoVDB " + type + ")")) << info.codec;
        }
}

TEST_F(Nano, SeveralGridsInOneOrMoreSegmentsAreChosenByName) {
    const std::vector<test::MadeGrid> grids{
        {.name = "heat", .gridClass = "", .voxels = {{{0, 0, 0}, 3}}},
        {.name = "Cd", .type = "vec3s", .colours = {{{0, 0, 0}, {1, 2, 3}}}},
        {.name = "density", .type = "Fp16", .voxels = test::box({0, 0, 0}, {7, 7, 7}, 0.5)},
    };
    for (const auto segments : {test::NanoSegments::one, test::NanoSegments::each}) {
        makeNvdb(file("a.nvdb"), grids, NanoCodec::zip, segments);
        const VdbFile part = VdbFile::open(file("a.nvdb"), {{""}, {"Cd", 2}});
        EXPECT_EQ(part.field("", {}).name, "density");
        EXPECT_EQ(part.field(GridRequest{"Cd", 2}, {}).maxValue, 3);
        EXPECT_EQ(errorOf(ErrorKind::input, [&] { part.field("heat", {}); }),
                  file("a.nvdb") + ": grid 'heat' was not requested when the file was opened");
        const VdbFileInfo info = VdbFile::open(file("a.nvdb")).info();
        EXPECT_TRUE(info.isNano);
        EXPECT_EQ(info.libraryMajor, 32u);
        ASSERT_EQ(info.grids.size(), 3u);
        EXPECT_EQ(info.grids[1].valueType, "vec3s");
        EXPECT_FALSE(vdbBounds(file("a.nvdb"), {{""}})) << "only reading tells";
    }
}

TEST_F(Nano, LevelSetsBecomeFog) {
    const test::MadeGrid sphere{.type = "sphere", .voxelSize = 0.5};
    makeNvdb(file("a.nvdb"), {sphere});
    makeVdb(file("a.vdb"), {sphere});
    expectSame(VdbFile::open(file("a.nvdb")).field("density", {}), VdbFile::open(file("a.vdb")).field("density", {}), 0,
               "a level set");
}

TEST_F(Nano, WhatIsNotReadIsSaid) {
    makeNvdb(file("a.nvdb"), {smoke("float")});
    const std::string good = test::readBytes(file("a.nvdb"));
    const auto refused = [&](std::string bytes) {
        test::writeBytes(file("a.nvdb"), bytes);
        const std::string text = errorOf(ErrorKind::input, [&] { VdbFile::open(file("a.nvdb")).field("density", {}); });
        EXPECT_TRUE(text.starts_with(file("a.nvdb") + ": ")) << text;
        return text.substr(std::min(text.size(), file("a.nvdb").size() + 2));
    };
    std::string bytes = good;
    bytes[7] = '1';
    EXPECT_EQ(refused(bytes), "is a NanoVDB grid as it lies in memory, expected a file of grids (writeGrid)");
    bytes = good;
    const std::uint32_t version = 33u << 21;
    std::memcpy(bytes.data() + 8, &version, sizeof version);
    EXPECT_EQ(
        refused(bytes),
        "is of NanoVDB 33.0, expected version 32 (that of OpenVDB 9 to 12): write it anew, or convert it to .vdb");
    bytes = good;
    bytes[16 + 4 * 8] = 9;  // the type in the grid's description
    EXPECT_EQ(refused(bytes),
              "grid 'density' holds NanoVDB Half values, where a scalar grid is expected; of those there is none");
    EXPECT_TRUE(refused(good.substr(0, good.size() - 1)).starts_with("truncated or damaged: a grid at byte "));
    // As later versions mark the same file.
    bytes = good;
    bytes[7] = '2';
    test::writeBytes(file("b.nvdb"), bytes);
    EXPECT_EQ(VdbFile::open(file("b.nvdb")).field("density", {}).maxValue,
              VdbFile::open(VdbBytes("a", {good.data(), good.size()})).field("density", {}).maxValue);
}

// Every offset of the tree leads somewhere: what leads out of the file is refused, whatever else is read.
TEST_F(Nano, OffsetsThatLeadAnywhereAreRefusedOrRead) {
    makeNvdb(file("a.nvdb"), {{.voxels = test::box({0, 0, 0}, {9, 9, 9}, 0.5)}});
    const std::string good = test::readBytes(file("a.nvdb"));
    int refused = 0, read = 0;
    for (std::size_t at = 16; at + 8 < good.size(); at += at < 2000 ? 4 : 1003) {
        for (const std::uint64_t value : {~std::uint64_t{0}, std::uint64_t{1} << 40, std::uint64_t{32}}) {
            std::string bytes = good;
            std::memcpy(bytes.data() + at, &value, sizeof value);
            try {
                VdbFile::open(VdbBytes("a", {bytes.data(), bytes.size()})).field("density", {});
                ++read;
            } catch (const Error&) {
                ++refused;
            }
        }
    }
    EXPECT_GT(refused, 20);
    EXPECT_GT(read, 20);
}

}  // namespace
}  // namespace scrim
