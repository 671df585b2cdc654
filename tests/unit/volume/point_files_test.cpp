// SPDX-License-Identifier: Apache-2.0
// Points of OpenVDB, PLY and NumPy files are the same points, found by the same names.
#include <scrim/guard/load_fields.h>
#include <scrim/volume/vdb_file.h>

#include "support/data.h"
#include "support/expect_error.h"
#include "support/loaded_fields.h"
#include "support/point_make.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

using test::errorOf;
using test::makePointsVdb;
using test::plyOf;

const std::vector<test::MadePoint> kSpray{{{0.5, 0.25, -0.5}, 0.25, {1, 2, -3}, {1, 0, 0.2}},
                                          {{2.5, -1.25, 0.75}, 0.125, {-1, 0, 4}, {0, 1, 0.4}},
                                          {{-1, 3, 1.5}, 0.25, {0, 0, 0}, {0, 0, 1}}};
const std::vector<GridRequest> kAll{{"spray"},
                                    {"Cd", 0},
                                    {"Cd", 1},
                                    {"Cd.b"},
                                    {"spray.Cd", 2},
                                    {"v", 0, GridPart::positive},
                                    {"v", 2, GridPart::negative}};

double sumOf(const SparseField& field) {
    const double edge = field.wsFromIs[0][0];
    double sum = 0;
    for (std::size_t b = 0; b < field.blockCount(); ++b)
        for (int i = 0; i < kBlockVoxels; ++i) sum += double(field.block(b)[i]);
    return sum * edge * edge * edge;
}

void expectSame(const SparseField& a, const SparseField& b, const std::string& what) {
    EXPECT_EQ(a.wsFromIs, b.wsFromIs) << what;
    ASSERT_EQ(a.blockOrigins, b.blockOrigins) << what;
    for (std::size_t i = 0; i < a.blockCount(); ++i)
        for (int n = 0; n < kBlockVoxels; ++n) ASSERT_NEAR(a.block(i)[n], b.block(i)[n], 2e-6) << what;
}

std::string numpyOf(const std::string& shape, const std::vector<float>& values, bool byColumns = false,
                    const std::string& descr = "<f4") {
    std::string dictionary =
        "{'descr': '" + descr + "', 'fortran_order': " + (byColumns ? "True" : "False") + ", 'shape': " + shape + ", }";
    dictionary.resize(118, ' ');
    dictionary.back() = '\n';
    std::string out("\x93NUMPY\x01\0", 8);
    out += std::string{static_cast<char>(dictionary.size()), '\0'} + dictionary;
    out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
    return out;
}

std::string numpyOfSpray(bool byColumns) {
    std::vector<std::vector<double>> rows;
    for (const auto& p : kSpray)
        rows.push_back({p.at.x, p.at.y, p.at.z, p.radius, p.velocity.x, p.velocity.y, p.velocity.z, p.colour.x,
                        p.colour.y, p.colour.z});
    std::vector<float> values;
    for (std::size_t i = 0; i < rows.size() * 10; ++i)
        values.push_back(static_cast<float>(byColumns ? rows[i % 3][i / 3] : rows[i / 10][i % 10]));
    return numpyOf("(3, 10)", values, byColumns);
}

class Points : public ::testing::Test {
  protected:
    std::string file(const std::string& name) const { return m_folder.file(name); }
    std::string refused(const std::string& name, const std::string& bytes) const {
        test::writeBytes(file(name), bytes);
        const std::string text = errorOf(ErrorKind::input, [&] { loadFields(file(name), {{}}, {}, {}); });
        EXPECT_TRUE(text.starts_with(file(name) + ": ")) << text;
        return text.substr(file(name).size() + 2);
    }
    test::TempFolder m_folder;
};

TEST_F(Points, AreTheSameOfAllFilesReadHereOrInAChild) {
    makePointsVdb(file("a.vdb"), kSpray);
    test::writeBytes(file("a.ply"), plyOf(kSpray, "ascii"));
    test::writeBytes(file("l.ply"), plyOf(kSpray, "binary_little_endian"));
    test::writeBytes(file("b.ply"), plyOf(kSpray, "binary_big_endian"));
    test::writeBytes(file("a.npy"), numpyOfSpray(false));
    test::writeBytes(file("f.npy"), numpyOfSpray(true));
    std::vector<GridRequest> requests = kAll;
    const std::vector<SparseField> expected = loadFields(file("a.vdb"), requests, test::kWays[0], {});
    const double ball = 4.0 / 3 * std::numbers::pi * std::pow(0.25, 3);
    EXPECT_NEAR(sumOf(expected[0]), ball * (1 + 0.125 + 1), 1e-5 * ball);
    EXPECT_FLOAT_EQ(expected[5].maxValue, 1);
    EXPECT_FLOAT_EQ(expected[6].maxValue, 3);
    for (const char* name : {"a.vdb", "a.ply", "l.ply", "b.ply", "a.npy", "f.npy"})
        for (const LoadOptions& way : test::kWays) {
            const bool isVdb = std::string(name) == "a.vdb";
            requests[0].grid = isVdb ? "spray" : "points";
            requests[4].grid = isVdb ? "spray.Cd" : "points.Cd";
            const std::vector<SparseField> fields = loadFields(file(name), requests, way, {});
            ASSERT_EQ(fields.size(), expected.size());
            for (std::size_t i = 0; i < fields.size(); ++i)
                expectSame(fields[i], expected[i], name + (" " + toText(requests[i])));
        }
}

// Seen by themselves: each number of each point, and none of what is no attribute of theirs.
TEST_F(Points, AreListedPointByPoint) {
    makePointsVdb(file("a.vdb"), kSpray);
    test::writeBytes(file("a.ply"), plyOf(kSpray, "ascii"));
    GridEdit edit;
    edit.points.sharp = true;
    for (const char* name : {"a.vdb", "a.ply"})
        for (const LoadOptions& way : test::kWays) {
            const std::string points = std::string(name) == "a.vdb" ? "spray" : "points";
            std::vector<GridRequest> requests{{points}, {points, GridRequest::kScalar, GridPart::places}};
            for (int c = 0; c < 3; ++c) requests.push_back({points, c, GridPart::places});
            for (int c = 0; c < 3; ++c) requests.push_back({"Cd", c, GridPart::ofPoints});
            requests.push_back({"v", 2, GridPart::negativeOfPoints});
            requests.push_back({points, GridRequest::kScalar, GridPart::ofPoints});
            requests.push_back({"heat", GridRequest::kScalar, GridPart::ofPoints});
            const std::vector<SparseField> fields = loadFields(file(name), requests, way, {}, {}, &edit);
            const auto at = [&](std::size_t list, std::size_t i) { return double(fields[list].block(0)[i]); };
            std::size_t found = 0;
            for (std::size_t i = 0; i < 4; ++i)
                for (const test::MadePoint& made : kSpray) {
                    const Vec3 place = transformPoint(fields[2].wsFromIs, Vec3(at(2, i), at(3, i), at(4, i)));
                    if (at(1, i) == 0 || glm::distance(place, made.at) > 1e-5) continue;
                    ++found;
                    EXPECT_NEAR(at(1, i), made.radius, 1e-6) << name;
                    for (std::size_t c = 0; c < 3; ++c)
                        EXPECT_NEAR(at(5 + c, i), made.colour[int(c)], 1e-3) << name << " " << c;
                    EXPECT_NEAR(at(8, i), std::max(-made.velocity.z, 0.0), 1e-6) << name;
                    EXPECT_NEAR(at(9, i), 1, 1e-5) << name;
                }
            EXPECT_EQ(found, kSpray.size()) << name;
            EXPECT_TRUE(fields[10].empty()) << name;
            edit.points.sharp = false;
            EXPECT_TRUE(loadFields(file(name), requests, way, {}, {}, &edit)[1].empty()) << name;
            edit.points.sharp = true;
        }
}

TEST_F(Points, AreTheSameAsGridsThatAreEdited) {
    makePointsVdb(file("a.vdb"), kSpray);
    const std::vector<SparseField> expected = loadFields(file("a.vdb"), kAll, {}, {});
    GridEdit edit;  // which changes nothing, but has grids to do it to
    edit.clip = Bounds{Vec3(-100), Vec3(100)};
    for (const LoadOptions& way : test::kWays) {
        const std::vector<SparseField> fields = loadFields(file("a.vdb"), kAll, way, {}, {}, &edit);
        for (std::size_t i = 0; i < fields.size(); ++i) expectSame(fields[i], expected[i], toText(kAll[i]));
    }
    GridEdit combined;
    combined.files = {file("a.vdb")};
    combined.grids = {{"density", CombinedGrid::How::copied, {{0, "spray", "here"}}},
                      {"paint", CombinedGrid::How::copied, {{0, "Cd", "there"}}}};
    const auto parts = loadFields(file("a.vdb"), {{"density"}, {"paint", 1}}, {}, {}, {}, &combined);
    expectSame(parts[0], expected[0], "density");
    expectSame(parts[1], expected[2], "paint");
}

TEST_F(Points, LookAsTheirEditSays) {
    makePointsVdb(file("a.vdb"), kSpray);
    GridEdit edit;
    edit.points = {.radius = 0.5, .scale = 2, .voxel = 0.75, .discs = true};
    EXPECT_EQ(gridEditFrom(toText(edit)), edit);
    for (const LoadOptions& way : test::kWays) {
        const SparseField field = loadFields(file("a.vdb"), {{}}, way, {}, {}, &edit).front();
        EXPECT_DOUBLE_EQ(field.wsFromIs[0][0], 0.75);
        EXPECT_NEAR(sumOf(field), 3 * std::numbers::pi, 1e-4);  // of floats, and there are a thousand
    }
}

TEST_F(Points, AreDescribed) {
    makePointsVdb(file("a.vdb"), kSpray);
    test::writeBytes(file("a.ply"), plyOf(kSpray, "ascii"));
    for (const LoadOptions& way : test::kWays)
        for (const char* name : {"a.vdb", "a.ply"}) {
            const VdbFileInfo info = loadInfo(file(name), way);
            ASSERT_EQ(info.grids.size(), 1u);
            const GridInfo& grid = info.grids.front();
            EXPECT_EQ(info.pointFormat, std::string(name) == "a.ply" ? "PLY" : "");
            EXPECT_EQ(grid.points, 3u);
            EXPECT_EQ(grid.attributes, std::string(name) == "a.ply" ? "v (vec3s), Cd (vec3s), radius (float)"
                                                                    : "Cd (vec3s), pscale (float), v (vec3s)");
            EXPECT_FLOAT_EQ(static_cast<float>(grid.minValue), 0.125f);
            EXPECT_FLOAT_EQ(static_cast<float>(grid.maxValue), 0.25f);
            EXPECT_EQ(grid.wsLower, Vec3(-1, -1.25, -0.5));
            EXPECT_EQ(grid.wsUpper, Vec3(2.5, 3, 1.5));
        }
}

TEST_F(Points, OfAnUnknownAttributeListThoseThereAre) {
    makePointsVdb(file("a.vdb"), kSpray);
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { loadFields(file("a.vdb"), {{"heat"}}, {}, {}); }),
              file("a.vdb") +
                  ": no grid 'heat'; it holds 'spray' (ptdataidx32); points 'spray' have Cd (vec3s), pscale (float), v "
                  "(vec3s)");
}

TEST_F(Points, OfDamagedFilesAreRefusedWithTheReason) {
    const std::string ply = plyOf(kSpray, "binary_little_endian"), text = plyOf(kSpray, "ascii");
    const auto with = [](std::string all, const std::string& from, const std::string& to) {
        return all.replace(all.find(from), from.size(), to);
    };
    EXPECT_EQ(refused("a.ply", ply.substr(0, ply.size() - 1)),
              "truncated or damaged: it has 92 bytes after its header, which declares 3 points of 31");
    EXPECT_EQ(refused("a.ply", with(ply, "vertex 3", "vertex 4000000000")),
              "truncated or damaged: it has 93 bytes after its header, which declares 4000000000 points of 31");
    EXPECT_EQ(refused("a.ply", text.substr(0, text.size() - 20)),
              "truncated or damaged: number 4 of point 3 is missing");
    EXPECT_EQ(refused("a.ply", with(ply, "float x", "float a")), "its vertices have no 'x'");
    EXPECT_EQ(refused("a.ply", with(ply, "vertex 3", "vertex 0")), "has no points");
    EXPECT_EQ(refused("a.ply", with(ply, "float vx", "list uchar int vx")),
              "a vertex has a property of type 'list', expected numbers");
    EXPECT_EQ(refused("a.ply", with(ply, "end_header", "element face 7\nproperty list uchar int i\nend_header")),
              "has 7 faces: it is a mesh, of which source = \"mesh\" makes fog");
    EXPECT_EQ(refused("a.ply", "ply\nformat ascii 1.0\n"), "damaged: its PLY header has no end");
    EXPECT_EQ(refused("a.npy", numpyOf("(2, 2, 2)", std::vector<float>(8))),
              "its array has the shape (2, 2, 2); expected points: (n, 3), (n, 4) with radii, (n, 7) with radii and "
              "velocities, or (n, 10) with colours (source = \"scan\" reads volumes)");
    EXPECT_EQ(refused("a.npy", numpyOf("(5, 3)", std::vector<float>(14))),
              "truncated or damaged: it has 56 bytes after its header, which declares 5 points of 12");
    EXPECT_EQ(refused("a.npy", numpyOf("(1, 3)", std::vector<float>(3), false, "<i4")),
              "its array holds '<i4', expected floats or doubles ('<f4' or '<f8')");
}

// Written by Houdini with OpenVDB 4, and by Arnold's makers with OpenVDB 11.
TEST_F(Points, OfOtherProgramsAreRead) {
    const std::string sphere = test::dataFile("edge/sphere_points.vdb"),
                      grid = test::dataFile("edge/arnold_pointgrid.vdb");
    SCRIM_NEEDS_DATA("edge/sphere_points.vdb");
    SCRIM_NEEDS_DATA("edge/arnold_pointgrid.vdb");
    EXPECT_EQ(loadInfo(sphere, {}).grids.at(0).points, 9802u);
    const SparseField field = loadFields(grid, {{}}, {}, {}).front();
    const VdbFileInfo info = loadInfo(grid, {});
    EXPECT_EQ(info.grids.at(0).points, 1024u);
    EXPECT_EQ(info.grids.at(0).attributes, "Cd (vec3s), pscale (float), v (vec3s)");
    // The sum over all points of 4/3 pi pscale^3, by OpenVDB's own iterators.
    EXPECT_NEAR(sumOf(field), 1.2270052, 2e-5);
}

}  // namespace
}  // namespace scrim
