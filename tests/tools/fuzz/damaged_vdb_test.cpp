// SPDX-License-Identifier: Apache-2.0
// Damaged .vdb and .nvdb files, as the program reads them: in a process of its own, under a memory limit. Whatever is
// wrong, it ends in time with exit status 0 or 3, says why in one line, takes no more memory than it may, and leaves a
// picture that is whole or none. Files of every kind that can be written, damaged as disks, networks and attackers do
// it. SCRIM_FUZZ_FILES=N asks for N damaged files of each kind.
#include "support/point_make.h"
#include "support/program_test.h"
#include "tools/fuzz/damage.h"

#include <scrim/guard/load_fields.h>
#include <scrim/image/exr_read.h>

#include <cmath>
#include <cstdlib>
#include <optional>
#include <random>

#include <sys/resource.h>

namespace scrim::test {
namespace {

constexpr int kInput = 3;
constexpr const char* kMemory = "1G";     // the least that reading is given
constexpr long kMostResident = 2L << 20;  // KiB: what was read and what is made of it

struct Kind {
    const char* what;
    std::vector<MadeGrid> grids;
    Container container = Container::file;
    std::optional<NanoCodec> nano = {};  ///< a NanoVDB file
    std::string name(const char* stem) const { return stem + std::string(nano ? ".nvdb" : ".vdb"); }
    void make(const std::string& path) const { nano ? makeNvdb(path, grids, *nano) : makeVdb(path, grids, container); }
};

std::vector<Kind> kinds() {
    const std::vector<MadeVoxel> voxels = box({-9, -4, -4}, {9, 4, 4}, 0.3);
    return {
        {"float_in_stream", {{.voxels = voxels}}, Container::stream},  // nothing of it can be checked beforehand
        {"half", {{.type = "half", .voxels = voxels}}},
        {"double_and_tiles", {{.type = "double", .voxels = voxels, .tiles = {{{0, 128, 0}, 128, 0.1}}}}},
        {"level_set", {{.type = "sphere", .gridClass = "level set"}}},
        {"frustum", {{.voxels = voxels, .frustum = true}}},
        {"many_grids",
         {{.name = "a", .voxels = voxels},
          {.name = "v", .type = "vec3s", .voxels = voxels},
          {.name = "p", .type = "points", .voxels = voxels},
          {.name = "a", .voxels = voxels}}},
        {"nano_float", {{.voxels = voxels, .tiles = {{{0, 128, 0}, 128, 0.1}}}}, Container::file, NanoCodec::none},
        {"nano_zip", {{.type = "FpN", .voxels = voxels}}, Container::file, NanoCodec::zip},
        {"nano_blosc",
         {{.type = "Fp4", .voxels = voxels}, {.name = "v", .type = "vec3s", .voxels = voxels}},
         Container::file,
         NanoCodec::blosc},
    };
}

/// A picture that could be one: finite, and nothing but the volume's shape is visible.
void expectPicture(const std::string& path) {
    for (const float value : readExr(path).rgba) ASSERT_TRUE(std::isfinite(value) && value >= 0) << value;
}

class DamagedVdb : public ProgramTest {
  protected:
    /// The program is told of a damaged file, its second argument.
    void expectRefusedOrRead(const std::vector<std::string>& arguments, const std::string& what) const {
        const ProgramResult result = run(arguments, {.timeout = std::chrono::seconds(60), .environment = {}});
        EXPECT_FALSE(result.timedOut) << what;
        EXPECT_TRUE(result.status == 0 || result.status == kInput)
            << what << ": status " << result.status << ", signal " << result.signal << "\n"
            << result.err;
        if (result.status != kInput) return;
        EXPECT_EQ(result.lastErrorLine().rfind("scrim: error: " + arguments[1] + ": ", 0), 0u)
            << what << ": " << result.err;
        EXPECT_LT(result.lastErrorLine().size(), 1500u) << what;
    }
    /// Files are read by the library's own child.
    static LoadOptions guarded() {
        LoadOptions options;
        options.volumes = VolumeLoading::guarded;
        options.memory = std::size_t{1} << 30;
        return options;
    }
    static void expectFinite(const std::vector<SparseField>& fields) {
        for (const SparseField& field : fields)
            for (std::size_t b = 0; b < field.blockCount(); ++b)
                for (int n = 0; n < kBlockVoxels; ++n) ASSERT_TRUE(std::isfinite(field.block(b)[n]));
    }
};

TEST_F(DamagedVdb, OfEveryKindIsRefusedOrReadWithinLimits) {
    const int files = damagedFiles(6, 2);
    std::mt19937 random(3);
    for (const Kind& kind : kinds()) {
        kind.make(file(kind.name("good")));
        const std::string good = readBytes(file(kind.name("good"))), bad = kind.name("bad");
        for (int i = 0; i < files; ++i) {
            const std::string bytes = damaged(good, random), what = std::string(kind.what) + " " + std::to_string(i);
            write(bad, bytes);
            std::filesystem::remove(file("bad.exr"));
            if (i % 4 == 0) expectRefusedOrRead({"info", bad}, what);
            expectRefusedOrRead(
                {"render", bad, "-o", "bad.exr", "--res", "16x16", "--quality", "draft", "-q", "--memory", kMemory},
                what);
            if (exists("bad.exr")) expectPicture(file("bad.exr"));
            if (HasFailure()) return writeBytes(::testing::TempDir() + "/scrim_damaged" + kind.name("."), bytes);
        }
    }
#ifndef SCRIM_ADDRESS_SANITIZED
    rusage usage{};
    ::getrusage(RUSAGE_CHILDREN, &usage);
    EXPECT_LT(usage.ru_maxrss, kMostResident);
#endif
}

// Many more of NanoVDB's files, whose offsets are checked here and not by a library: read by the library's own child.
TEST_F(DamagedVdb, OfNanoVdbIsRefusedOrReadByTheLibrary) {
    const int files = damagedFiles(100, 10);
    std::mt19937 random(17);
    const LoadOptions options = guarded();
    for (const Kind& kind : kinds()) {
        if (!kind.nano) continue;
        kind.make(file("good.nvdb"));
        const std::string good = readBytes(file("good.nvdb"));
        Outcomes outcomes;
        for (int i = 0; i < files; ++i) {
            const std::string bytes = damaged(good, random);
            write("bad.nvdb", bytes);
            try {
                expectFinite(loadFields(file("bad.nvdb"), {{""}}, options, {}));
                ++outcomes.read;
            } catch (const Error& error) {
                ++outcomes.refused;
                outcomes.expectTold(error, file("bad.nvdb"));
            }
            if (HasFailure()) return writeBytes(::testing::TempDir() + "/scrim_damaged.nvdb", bytes);
        }
        outcomes.print(kind.what);
        EXPECT_EQ(outcomes.crashed, 0) << kind.what;
    }
}

TEST_F(DamagedVdb, OfPointsIsRefusedOrReadByTheLibrary) {
    const int files = damagedFiles(100, 10);
    std::mt19937 random(19);
    const LoadOptions options = guarded();
    std::vector<MadePoint> points;
    for (int i = 0; i < 60; ++i) points.push_back({Vec3(i % 5, i % 7, i % 3), 0.1 + 0.01 * i, {1, 2, 3}, {1, 0.5, 0}});
    makePointsVdb(file("good.vdb"), points);
    std::string array = "{'descr': '<f4', 'fortran_order': False, 'shape': (20, 4), }\n";
    array = std::string("\x93NUMPY\1\0", 8) + std::string{static_cast<char>(array.size()), 0} + array;
    for (int i = 0; i < 80; ++i) array += std::string("\0\0\x80\x3f", 4);
    for (const auto& [name, good] : {std::pair<std::string, std::string>("a.vdb", readBytes(file("good.vdb"))),
                                     {"text.ply", plyOf(points, "ascii")},
                                     {"big.ply", plyOf(points, "binary_big_endian")},
                                     {"a.npy", array}}) {
        Outcomes outcomes;
        for (int i = 0; i < files; ++i) {
            const std::string bytes = damaged(good, random);
            write(name, bytes);
            try {
                expectFinite(loadFields(file(name), {{""}}, options, {}));
                loadInfo(file(name), options);
                ++outcomes.read;
            } catch (const Error& error) {
                ++outcomes.refused;
                if (error.kind() != ErrorKind::memory) outcomes.expectTold(error, file(name));
            }
            if (HasFailure()) return writeBytes(::testing::TempDir() + "/scrim_damaged." + name, bytes);
        }
        outcomes.print(name.c_str());
        write(name, good);
        EXPECT_GT(loadFields(file(name), {{""}}, options, {}).at(0).activeVoxels, 0u) << name;
        // What Scrim itself reads never crashes.
        if (name != "a.vdb") {
            EXPECT_EQ(outcomes.crashed, 0) << name;
        }
    }
}

}  // namespace
}  // namespace scrim::test
