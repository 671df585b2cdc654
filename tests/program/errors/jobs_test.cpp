// SPDX-License-Identifier: Apache-2.0
// scrim render --jobs: frames side by side.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>

#include <nlohmann/json.hpp>

#include <filesystem>
#include <vector>

namespace scrim::test {
namespace {

class Jobs : public ProgramTest {
  protected:
    void SetUp() override {
        ProgramTest::SetUp();
        for (const int frame : {1, 2, 3, 4, 5})
            makeVdb(file("smoke." + std::to_string(frame) + ".vdb"),
                    {{.voxels = box({0, 0, 0}, {7, 2 * frame, 7}, 0.2)}});
        write("sequence.toml", kCamera + "[[volume]]\nfile = \"smoke.#.vdb\"\n" + kLight);
    }
    static std::vector<std::string> frames(const std::vector<std::string>& more) {
        std::vector<std::string> all{"render", "sequence.toml", "--frames", "1-5"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    bool exists(const std::string& name) const { return std::filesystem::exists(file(name)); }
};

TEST_F(Jobs, RenderTheFramesThatOneRendersInItsOrder) {
    runWell(frames({"-o", "one.#.exr", "--stats", "one.json"}));
    runWell(frames({"-o", "three.#.exr", "--stats", "three.json", "--jobs", "3", "--memory", "3G"}));
    const auto one = nlohmann::json::parse(readBytes(file("one.json")));
    const auto three = nlohmann::json::parse(readBytes(file("three.json")));
    ASSERT_EQ(one.size(), 5U);
    ASSERT_EQ(three.size(), 5U);
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_EQ(three[i].at("frame"), i + 1);
        EXPECT_EQ(three[i].at("plan"), one[i].at("plan"));
        const std::string frame = std::to_string(i + 1);
        EXPECT_EQ(readExr(file("three." + frame + ".exr")).rgba, readExr(file("one." + frame + ".exr")).rgba);
    }
}

TEST_F(Jobs, ShareTheThreads) {
    runWell(frames({"-o", "out.#.exr", "--jobs", "2", "--threads", "2", "--stats", "stats.json"}));
    for (const auto& frame : nlohmann::json::parse(readBytes(file("stats.json")))) EXPECT_EQ(frame.at("threads"), 1);
}

TEST_F(Jobs, SkipFramesThatAreThereOrHaveNoFile) {
    runWell(frames({"-o", "out.#.exr"}));
    std::filesystem::remove(file("out.2.exr"));
    std::filesystem::remove(file("out.4.exr"));
    std::filesystem::remove(file("smoke.4.vdb"));
    const ProgramResult result = runWell(
        frames({"-o", "out.#.exr", "--skip-existing", "--missing", "skip", "--jobs", "5", "--stats", "stats.json"}));
    for (const char* frame : {"1", "3", "5"})
        EXPECT_TRUE(contains(result.err, std::string("frame ") + frame + ": out." + frame + ".exr exists already"))
            << result.err;
    EXPECT_TRUE(exists("out.2.exr"));
    EXPECT_FALSE(exists("out.4.exr"));
    const auto stats = nlohmann::json::parse(readBytes(file("stats.json")));
    ASSERT_EQ(stats.size(), 1U);
    EXPECT_EQ(stats[0].at("frame"), 2);
}

TEST_F(Jobs, OfWhichOneFailsWriteTheFramesThatTheyHaveBegun) {
    write("smoke.2.vdb", "not a volume");
    const ProgramResult result =
        run(frames({"-o", "out.#.exr", "--jobs", "2", "--stats", "stats.json", "--progress", "none"}));
    EXPECT_EQ(result.status, 3) << result.err;
    EXPECT_TRUE(contains(result.err, "smoke.2.vdb")) << result.err;
    EXPECT_TRUE(exists("out.1.exr"));  // of the job that has not failed
    EXPECT_FALSE(exists("out.2.exr"));
    EXPECT_FALSE(exists("out.4.exr"));  // would come next
    const auto stats = nlohmann::json::parse(readBytes(file("stats.json")));
    ASSERT_FALSE(stats.empty());
    EXPECT_EQ(stats[0].at("frame"), 1);
}

TEST_F(Jobs, OfAPictureThatMissesWhatWasAskedForAreTold) {
    const ProgramResult result = run(frames({"-o", "out.#.exr", "--jobs", "2", "--tolerance", "0.000001"}));
    EXPECT_EQ(result.status, 5) << result.err;
    EXPECT_TRUE(contains(result.err, "(and 4 more frames)")) << result.err;
}

TEST_F(Jobs, AreRefusedBesideWhatNeedsOneFrameAtATime) {
    expectFailure(frames({"-o", "out.#.exr", "--jobs", "0"}), 2, "--jobs 0: expected a whole number from 1 to 4096");
    expectFailure(frames({"-o", "out.#.exr", "--jobs", "2", "--budget", "9"}), 2,
                  "--jobs: --budget measures one frame that has the machine; give one of the two");
    expectFailure(frames({"-o", "out.#.exr", "--jobs", "2", "--display-server", "localhost:1"}), 2,
                  "--jobs: --display-server shows one frame at a time; give one of the two");
}

}  // namespace
}  // namespace scrim::test
