// SPDX-License-Identifier: Apache-2.0
// Damaged .vdb files, as the program reads them: in a process of its own, under a memory limit. Whatever is wrong, it
// ends in time with exit status 0 or 3, says why in one line, takes no more memory than it may, and leaves a picture
// that is whole or none. Files of every kind that can be written, damaged as disks, networks and attackers do it.
// SCRIM_FUZZ_FILES=N asks for N damaged files of each kind.
#include "support/program_test.h"
#include "tools/fuzz/damage.h"

#include <scrim/image/exr_read.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include <sys/resource.h>

namespace scrim::test {
namespace {

constexpr int kInput = 3;
constexpr const char* kMemory = "1G";     // the least that reading is given
constexpr long kMostResident = 2L << 20;  // KiB: what was read and what is made of it

struct Kind {
    const char* name;
    std::vector<MadeGrid> grids;
    Container container = Container::file;
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
    };
}

/// A picture that could be one: finite, and nothing but the volume's shape is visible.
void expectPicture(const std::string& path) {
    for (const float value : readExr(path).rgba) ASSERT_TRUE(std::isfinite(value) && value >= 0) << value;
}

class DamagedVdb : public ProgramTest {
  protected:
    void expectRefusedOrRead(const std::vector<std::string>& arguments, const std::string& what) const {
        const ProgramResult result = run(arguments, {.timeout = std::chrono::seconds(60), .environment = {}});
        EXPECT_FALSE(result.timedOut) << what;
        EXPECT_TRUE(result.status == 0 || result.status == kInput)
            << what << ": status " << result.status << ", signal " << result.signal << "\n"
            << result.err;
        if (result.status != kInput) return;
        EXPECT_EQ(result.lastErrorLine().rfind("scrim: error: bad.vdb: ", 0), 0u) << what << ": " << result.err;
        EXPECT_LT(result.lastErrorLine().size(), 1500u) << what;
    }
};

TEST_F(DamagedVdb, OfEveryKindIsRefusedOrReadWithinLimits) {
    const int files = damagedFiles(6, 2);
    std::mt19937 random(3);
    for (const Kind& kind : kinds()) {
        makeVdb(file("good.vdb"), kind.grids, kind.container);
        const std::string good = readBytes(file("good.vdb"));
        for (int i = 0; i < files; ++i) {
            const std::string bytes = damaged(good, random), what = std::string(kind.name) + " " + std::to_string(i);
            write("bad.vdb", bytes);
            std::filesystem::remove(file("bad.exr"));
            if (i % 4 == 0) expectRefusedOrRead({"info", "bad.vdb"}, what);
            expectRefusedOrRead({"render", "bad.vdb", "-o", "bad.exr", "--res", "16x16", "--quality", "draft", "-q",
                                 "--memory", kMemory},
                                what);
            if (exists("bad.exr")) expectPicture(file("bad.exr"));
            if (HasFailure()) return writeBytes(::testing::TempDir() + "/scrim_damaged.vdb", bytes);
        }
    }
#ifndef SCRIM_ADDRESS_SANITIZED
    rusage usage{};
    ::getrusage(RUSAGE_CHILDREN, &usage);
    EXPECT_LT(usage.ru_maxrss, kMostResident);
#endif
}

}  // namespace
}  // namespace scrim::test
