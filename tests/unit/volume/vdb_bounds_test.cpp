// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_bounds.h>

#include <scrim/volume/vdb_file.h>
#include <scrim/volume/vdb_write.h>

#include "support/data.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <cmath>
#include <span>

#include <glm/gtc/matrix_transform.hpp>

namespace scrim {
namespace {

using test::box;
using test::MadeGrid;
using test::makeVdb;
using test::TempFolder;

/// The box of the voxels above 0, with two voxels more on each side.
Bounds boundsOf(const SparseField& field) {
    Bounds is;
    for (std::size_t i = 0; i < field.blockCount(); ++i)
        for (int x = 0; x < kBlockEdge; ++x)
            for (int y = 0; y < kBlockEdge; ++y)
                for (int z = 0; z < kBlockEdge; ++z)
                    if (field.block(i)[blockOffset(x, y, z)] > 0)
                        is.include(Vec3(field.blockOrigins[i] + Int3(x, y, z)));
    for (const ConstantTile& tile : field.tiles) {
        is.include(Vec3(tile.origin));
        is.include(Vec3(tile.origin + (tile.edge - 1)));
    }
    if (is.empty()) return is;
    is.lower -= 2.0;
    is.upper += 2.0;
    return transformed(field.wsFromIs, is);
}

/// Nothing but rounding lies between the two: the numbers are those of one matrix.
void expectEqual(const Bounds& a, const Bounds& b, const std::string& what) {
    ASSERT_EQ(a.empty(), b.empty()) << what;
    if (a.empty()) return;
    const double tolerance = 1e-12 * (glm::length(b.lower) + glm::length(b.upper));
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(a.lower[i], b.lower[i], tolerance) << what;
        EXPECT_NEAR(a.upper[i], b.upper[i], tolerance) << what;
    }
}

TEST(VdbBounds, AreThoseOfTheFieldForEveryAffineMap) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    for (const std::string map : {"AffineMap", "UniformScaleMap", "UniformScaleTranslateMap", "ScaleMap",
                                  "ScaleTranslateMap", "TranslationMap", "UnitaryMap"}) {
        makeVdb(path, {{.voxels = box({-5, 3, 100}, {20, 4, 107}, 1), .map = map}});
        const auto bounds = vdbBounds(path, {{"density"}});
        ASSERT_TRUE(bounds) << map;
        expectEqual(*bounds, boundsOf(VdbFile::open(path).field("", {})), map);
    }
}

TEST(VdbBounds, AreThoseOfWhatWeWroteWithAnyTransform) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, {{.voxels = box({-5, -5, -5}, {20, 3, 3}, 0.3), .tiles = {{{128, 0, 0}, 128, 2.0}}}});
    SparseField field = VdbFile::open(path).field("", {});
    const Mat4 turned = glm::rotate(Mat4(1.0), 0.7, Vec3(1, 2, 3));
    for (const Mat4& m : {Mat4(1.0), glm::scale(Mat4(1.0), Vec3(0.1, 2, -3)), turned,
                          glm::translate(glm::scale(turned, Vec3(1, 2, 4)), Vec3(1e4, 0.1, -7))}) {
        field.wsFromIs = m;
        writeVdb(path, {field});
        const auto bounds = vdbBounds(path, {{""}});
        ASSERT_TRUE(bounds);
        expectEqual(*bounds, boundsOf(VdbFile::open(path).field("", {})), "written");
        expectEqual(*bounds, boundsOf(field), "as it was");
    }
}

TEST(VdbBounds, AreAroundAllThatIsRequested) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, {{.name = "density", .voxels = {{{0, 0, 0}, 1}}},
                   {.name = "Cd", .type = "vec3s", .voxels = {{{10, 0, 0}, 1}}},
                   {.name = "heat", .type = "double", .voxels = {{{0, -10, 0}, 1}}},
                   {.name = "nothing"}});
    const auto all = vdbBounds(path, {{"density"}, {"Cd", 0}, {"heat"}, {"nothing"}});
    ASSERT_TRUE(all);
    EXPECT_EQ(all->lower, Vec3(-2, -12, -2));
    EXPECT_EQ(all->upper, Vec3(12, 2, 2));
    const auto one = vdbBounds(path, {{"Cd", 2}});
    ASSERT_TRUE(one);
    EXPECT_EQ(one->lower, Vec3(8, -2, -2));
    const auto none = vdbBounds(path, {{"nothing"}});
    ASSERT_TRUE(none);
    EXPECT_TRUE(none->empty());
}

TEST(VdbBounds, AreUnknownWhereOnlyReadingWouldTell) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    EXPECT_FALSE(vdbBounds(folder.file("none.vdb"), {{""}}));
    EXPECT_FALSE(vdbBounds(folder.path(), {{""}}));
    const std::vector<test::MadeVoxel> voxels{{{0, 0, 0}, 1}};
    makeVdb(path, {{.voxels = voxels}}, test::Container::stream);
    EXPECT_FALSE(vdbBounds(path, {{""}})) << "no offsets";
    makeVdb(path, {{.voxels = voxels, .frustum = true}, {.name = "id", .type = "vec3i", .voxels = voxels}});
    EXPECT_FALSE(vdbBounds(path, {{""}})) << "a frustum";
    EXPECT_FALSE(vdbBounds(path, {{"id"}})) << "no scalar";
    EXPECT_FALSE(vdbBounds(path, {{"heat"}})) << "no such grid";

    makeVdb(path, {{.voxels = voxels}});
    ASSERT_TRUE(vdbBounds(path, {{""}}));
    std::string bytes = test::readBytes(path);
    const std::size_t at = bytes.find("file_bbox_max");
    ASSERT_NE(at, std::string::npos);
    bytes[at] = 'F';
    test::writeBytes(path, bytes);
    EXPECT_FALSE(vdbBounds(path, {{""}})) << "no bounds";
}

TEST(VdbBounds, SurviveEveryTruncationAndEveryDamagedByte) {
    const TempFolder folder;
    const std::string path = folder.file("a.vdb");
    makeVdb(path, {{.voxels = box({0, 0, 0}, {9, 9, 9}, 0.5), .map = "AffineMap"}, {.name = "Cd", .type = "vec3s"}});
    const std::string whole = test::readBytes(path);
    const std::vector<GridRequest> requests{{""}, {"Cd", 1}};
    ASSERT_TRUE(vdbBounds(VdbBytes(path, whole), requests));
    for (std::size_t size = 0; size < whole.size(); ++size)
        EXPECT_FALSE(vdbBounds(VdbBytes(path, std::span(whole.data(), size)), requests)) << size << " bytes";
    for (std::size_t at = 0; at < whole.size(); ++at)
        for (const char flip : {'\x01', '\x80', '\xff'}) {
            std::string bytes = whole;
            bytes[at] = static_cast<char>(bytes[at] ^ flip);
            // A coordinate may have become another one, but no box is ever made of nonsense.
            const auto bounds = vdbBounds(VdbBytes(path, bytes), requests);
            if (!bounds || bounds->empty()) continue;
            for (int i = 0; i < 3; ++i)
                EXPECT_TRUE(std::isfinite(bounds->lower[i]) && bounds->lower[i] <= bounds->upper[i]) << at;
        }
    // On disk the same as in memory.
    for (std::size_t size = 0; size < whole.size(); size += 1 + size / 20) {
        test::writeBytes(path, whole.substr(0, size));
        EXPECT_FALSE(vdbBounds(path, requests)) << size << " bytes";
    }
}

TEST(RealVdbFiles, LieWithinTheirQuickBounds) {
    SCRIM_NEEDS_DATA("vdb");
    int known = 0;
    for (const char* folder : {"vdb", "edge", "sequence/usd_smoke"})
        for (const auto& entry : std::filesystem::directory_iterator(test::dataFile(folder))) {
            const std::string path = entry.path().string();
            const VdbFile file = VdbFile::open(path);
            const std::vector<std::string> names = file.usableGrids();
            std::size_t next = 0;
            for (const GridInfo& grid : file.info().grids) {
                if (!grid.usable) continue;
                const std::string name = names.at(next++);
                const auto quick = vdbBounds(path, {{name}});
                if (!quick) continue;
                ++known;
                Bounds active;  // those of value 0 included
                if (grid.isLower.x <= grid.isUpper.x)
                    active = transformed(grid.wsFromIs, {Vec3(grid.isLower) - 2.0, Vec3(grid.isUpper) + 2.0});
                expectEqual(*quick, active, path + " " + name);
                Bounds both = *quick;
                both.include(boundsOf(file.field(name, {})));
                expectEqual(*quick, both, path + " " + name);
            }
        }
    EXPECT_GE(known, 5);
}

}  // namespace
}  // namespace scrim
