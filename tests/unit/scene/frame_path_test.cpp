// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/frame_path.h>

#include <scrim/base/error.h>
#include <scrim/scene/volume_file.h>

#include "support/temp_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace scrim {
namespace {

std::optional<std::string> lookUp(const std::string& name) {
    if (name == "SHOT") return "sq010/sh020";
    if (name == "CACHE_2") return "smoke.####.vdb";
    return std::nullopt;
}

std::string variableError(const std::string& pattern) {
    try {
        expandVariables(pattern, lookUp, "scene.toml:3:8");
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        return error.what();
    }
    return "no error";
}

void touch(const std::string& path) {
    std::ofstream(path) << "x";
}

TEST(FramePath, PutsTheFrameIn) {
    EXPECT_EQ(expandFrame("a.####.vdb", 7), "a.0007.vdb");
    EXPECT_EQ(expandFrame("a.%04d.vdb", 7), "a.0007.vdb");
    EXPECT_EQ(expandFrame("a.$F4.vdb", 7), "a.0007.vdb");
    EXPECT_EQ(expandFrame("a.#.vdb", 17), "a.17.vdb");
    EXPECT_EQ(expandFrame("a.%d.vdb", 17), "a.17.vdb");
    EXPECT_EQ(expandFrame("a.$F.vdb", 17), "a.17.vdb");
    EXPECT_EQ(expandFrame("%03d/a_##.vdb", 5), "005/a_05.vdb");
    EXPECT_EQ(expandFrame("a.####.vdb", 123456), "a.123456.vdb");
    EXPECT_EQ(expandFrame("a.####.vdb", -5), "a.-005.vdb");
}

TEST(FramePath, LeavesOtherTextAlone) {
    EXPECT_EQ(expandFrame("100%.vdb", 1), "100%.vdb");
    EXPECT_EQ(expandFrame("%4d%s%0d", 1), "%4d%s%0d");
    EXPECT_EQ(expandFrame("cost$$F4.vdb", 1), "cost$F4.vdb");
    EXPECT_EQ(expandFrame("", 1), "");
    EXPECT_EQ(expandFrame("a$#$#b$%04d.$####.$$##", 7), "a##b%04d.#007.$07");
    EXPECT_FALSE(hasFrame("a$#$%04d"));
    EXPECT_EQ(withoutFrame("a$#1.####.%4d.$F4b%d"), "a#1..%4d.b");
    EXPECT_FALSE(hasFrame("a.0001.vdb"));
    EXPECT_FALSE(hasFrame("cost$$F4.vdb"));
    EXPECT_TRUE(hasFrame("a.#.vdb"));
    EXPECT_TRUE(hasFrame("$F/a.vdb"));
}

TEST(FramePath, HasAPatternForEveryName) {
    for (const std::string name : {"a##b", "100%04d$F4", "$$#%", "do$lar/${HOME}/$HOME", "plain"}) {
        const std::string pattern = patternOf(name);
        EXPECT_FALSE(hasFrame(pattern)) << pattern;
        EXPECT_EQ(expandFrame(expandVariables(pattern, lookUp, "x"), 7), name) << pattern;
    }
    EXPECT_EQ(patternOf("plain/a.exr"), "plain/a.exr");
}

TEST(FramePath, IsTheSameFromTheRootOn) {
    EXPECT_EQ(expandFrame(absolutePattern("/jobs/a##b/do$lar", "p.$F4.exr"), 7), "/jobs/a##b/do$lar/p.0007.exr");
    EXPECT_EQ(absolutePattern("/jobs", "/other/p.####.exr"), "/other/p.####.exr");
    EXPECT_EQ(expandFrame(absolutePattern("", "p.exr"), 1), (std::filesystem::current_path() / "p.exr").string());
    EXPECT_EQ(expandFrame(absolutePattern("here", "p.exr"), 1),
              (std::filesystem::current_path() / "here/p.exr").string());
}

TEST(FramePath, LimitsTheNumberOfDigits) {
    EXPECT_EQ(expandFrame("%099999999999d", 1).size(), 1u);  // no int: the bare number
    EXPECT_EQ(expandFrame("$F4000", 1).size(), 20u);
    EXPECT_EQ(expandFrame(std::string(5000, '#'), 1).size(), 20u);
}

TEST(FramePath, ExpandsVariablesOnce) {
    EXPECT_EQ(expandVariables("/jobs/${SHOT}/${CACHE_2}", lookUp, "x"), "/jobs/sq010/sh020/smoke.####.vdb");
    EXPECT_EQ(expandVariables("a.$F4.$F.$$.$#.$%.vdb", lookUp, "x"), "a.$F4.$F.$$.$#.$%.vdb");
}

TEST(FramePath, RefusesVariablesItDoesNotKnow) {
    EXPECT_EQ(variableError("${NONE}/a.vdb"),
              "scene.toml:3:8: the path '${NONE}/a.vdb' names the variable 'NONE', which is neither in "
              "[variables] nor "
              "in the environment");
    EXPECT_EQ(variableError("${SHOT/a.vdb"), "scene.toml:3:8: the path '${SHOT/a.vdb' has '${' without '}'");
    EXPECT_EQ(variableError("${a b}.vdb"),
              "scene.toml:3:8: the path '${a b}.vdb' has '${a b}'; a variable's name is "
              "letters, digits and '_'");
    EXPECT_EQ(variableError("$HOME/a.vdb"),
              "scene.toml:3:8: the path '$HOME/a.vdb' has an invalid '$'; expected ${NAME}, $F, $F4, $$ (a dollar "
              "sign), $# or $%");
}

TEST(FramePath, SearchesOnlyThePatternForFrames) {
    const FramePath path{"/jobs/####/$F", "a.##.vdb"};
    EXPECT_EQ(path.at(3), "/jobs/####/$F/a.03.vdb");
    EXPECT_EQ((FramePath{"/jobs", "/abs/a.vdb"}.at(3)), "/abs/a.vdb");
    EXPECT_EQ((FramePath{"", "a.vdb"}.at(3)), "a.vdb");
}

TEST(FramePath, FindsTheFramesOnDisk) {
    const test::TempFolder folder;
    for (const char* name : {"a.0003.vdb", "a.0001.vdb", "a.-002.vdb", "a.12345.vdb", "a.7.vdb", "b.0009.vdb",
                             "a.0004.vdb.tmp", "a..vdb", "a"})
        touch(folder.file(name));
    EXPECT_EQ(existingFrames({folder.path(), "a.####.vdb"}), (std::vector<int>{-2, 1, 3, 12345}));
    EXPECT_EQ(existingFrames({"/", folder.path() + "/a.$F.vdb"}), (std::vector<int>{7, 12345}));
    EXPECT_TRUE(existingFrames({folder.path(), "a.0003.vdb"}).empty());
    EXPECT_TRUE(existingFrames({folder.path(), "missing/a.####.vdb"}).empty());
}

class VolumeFileTest : public ::testing::Test {
  protected:
    VolumeFileTest() {
        for (const int frame : {2, 3, 5}) touch(m_folder.file("a." + std::to_string(frame) + ".vdb"));
    }
    VolumeFile find(int frame, OutsidePolicy outside, double beyond = 0) const {
        SceneVolume volume;
        volume.beyond = beyond;
        if (beyond > 0) volume.frameMap.between = BetweenFiles::blend;
        volume.name = "plume";
        volume.where = "scene.toml:4:8";
        volume.sequence = {m_folder.path(), "a.#.vdb"};
        volume.frame = frame;
        volume.file = volume.sequence.at(frame);
        volume.outside = outside;
        return findVolumeFile(volume);
    }
    test::TempFolder m_folder;
};

TEST_F(VolumeFileTest, IsTheSequencesOwnWhereItExists) {
    for (const auto outside : {OutsidePolicy::error, OutsidePolicy::hold, OutsidePolicy::black}) {
        EXPECT_EQ(find(3, outside).state, FileState::present);
        EXPECT_EQ(find(3, outside).path, m_folder.file("a.3.vdb"));
    }
}

TEST_F(VolumeFileTest, OutsideTheSequenceFollowsThePolicy) {
    EXPECT_EQ(find(1, OutsidePolicy::hold).path, m_folder.file("a.2.vdb"));
    EXPECT_EQ(find(99, OutsidePolicy::hold).path, m_folder.file("a.5.vdb"));
    EXPECT_EQ(find(99, OutsidePolicy::hold).state, FileState::present);
    EXPECT_EQ(find(99, OutsidePolicy::black).state, FileState::black);
    EXPECT_EQ(find(99, OutsidePolicy::error).state, FileState::missing);
    EXPECT_EQ(find(99, OutsidePolicy::error).problem, "scene.toml:4:8: volume 'plume': there is no file '" +
                                                          m_folder.file("a.99.vdb") +
                                                          "' for frame 99; the sequence has frames 2 to 5");
}

TEST_F(VolumeFileTest, SequencesRepeatOrGoToAndFro) {
    touch(m_folder.file("a.4.vdb"));
    // Files 2 to 5, for frames -5 to 12.
    const auto shown = [&](OutsidePolicy outside) {
        std::string files;
        for (int frame = -5; frame <= 12; ++frame) {
            const VolumeFile found = find(frame, outside);
            EXPECT_EQ(found.state, FileState::present) << frame;
            files += found.path[found.path.size() - 5];
        }
        return files;
    };
    EXPECT_EQ(shown(OutsidePolicy::repeat), "345234523452345234");
    EXPECT_EQ(shown(OutsidePolicy::pingPong), "323454323454323454");
    std::filesystem::remove(m_folder.file("a.3.vdb"));
    EXPECT_NE(find(7, OutsidePolicy::repeat).problem.find("there is no file '" + m_folder.file("a.3.vdb")),
              std::string::npos);
    for (const int frame : {2, 4}) std::filesystem::remove(m_folder.file("a." + std::to_string(frame) + ".vdb"));
    for (const auto outside : {OutsidePolicy::repeat, OutsidePolicy::pingPong})
        EXPECT_EQ(find(99, outside).path, m_folder.file("a.5.vdb")) << "a sequence of one file";
}

// Smoke goes from a file to the one after it, also where the sequence is seen backwards.
TEST_F(VolumeFileTest, BothFilesBetweenWhichAVolumeLiesAreInTheirOwnOrder) {
    touch(m_folder.file("a.4.vdb"));
    // Files 2 to 5, for frames 0.25 to 12.25.
    const auto shown = [&](OutsidePolicy outside) {
        std::string files;
        for (int frame = 0; frame <= 12; ++frame) {
            const VolumeFile found = find(frame, outside, 0.25);
            const auto number = [](const VolumeFile& file) { return file.path.substr(file.path.size() - 5, 1); };
            EXPECT_EQ(found.state, FileState::present) << frame;
            files += number(found) + (found.next ? number(*found.next) : "") + (found.beyond == 0.75 ? "* " : " ");
            EXPECT_TRUE(found.beyond == (found.next ? 0.25 : 0.0) || files.ends_with("* ")) << frame;
        }
        return files;
    };
    EXPECT_EQ(shown(OutsidePolicy::pingPong), "34* 23* 23 34 45 45* 34* 23* 23 34 45 45* 34* ");
    EXPECT_EQ(shown(OutsidePolicy::repeat), "45 52 23 34 45 52 23 34 45 52 23 34 45 ");
    EXPECT_EQ(shown(OutsidePolicy::hold), "2 2 23 34 45 5 5 5 5 5 5 5 5 ");
    EXPECT_EQ(find(5, OutsidePolicy::black, 0.25).state, FileState::black);
}

TEST_F(VolumeFileTest, AGapIsALostFileWhateverThePolicy) {
    for (const auto outside : {OutsidePolicy::error, OutsidePolicy::hold, OutsidePolicy::black, OutsidePolicy::repeat,
                               OutsidePolicy::pingPong})
        EXPECT_EQ(find(4, outside).state, FileState::missing);
}

TEST(FramePath, OfAFileByThatVeryNameIsThatFile) {
    const test::TempFolder folder;
    for (const std::string name : {"take#2.vdb", "p%04d.vdb", "q$F4.vdb"}) {
        const FramePath path{folder.path(), name};
        EXPECT_TRUE(path.hasFrame()) << name;
        touch(folder.file(name));
        EXPECT_FALSE(path.hasFrame()) << name;
        EXPECT_EQ(path.at(7), folder.file(name));
        EXPECT_TRUE(existingFrames(path).empty()) << name;
        // Where pictures go does not depend on what is there.
        EXPECT_TRUE(path.outputHasFrame()) << name;
        EXPECT_EQ(path.outputAt(7), folder.file(expandFrame(name, 7)));
    }
}

}  // namespace
}  // namespace scrim
