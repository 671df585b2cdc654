// SPDX-License-Identifier: Apache-2.0
// What a process was given is told from what a file is: standard streams that are closed, limits of files, descriptors
// and memory.
#include "support/program_test.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

constexpr int kRender = 1, kInput = 3, kOutput = 4, kMemory = 33;

/// Runs the program after `before`, with `redirections`.
ProgramOptions shell(const std::string& before, const std::string& redirections = "") {
    ProgramOptions options;
    options.shell = before + (before.empty() ? "" : "; ") + "exec \"$0\" \"$@\" " + redirections;
    return options;
}

class Streams : public ProgramTest {};

TEST_F(Streams, MayBeClosed) {
    runWell({"render", "scene.toml", "-o", "open.exr"});
    for (const std::string closed : {"<&-", ">&-", "2>&-", "<&- >&-", "<&- 2>&-", ">&- 2>&-", "<&- >&- 2>&-"}) {
        runWell({"render", "scene.toml", "-o", "x.exr", "--stats", "s.json"}, shell("", closed));
        EXPECT_TRUE(readBytes(file("x.exr")) == readBytes(file("open.exr"))) << closed;
        std::filesystem::remove(file("x.exr"));
    }
}

TEST_F(Streams, ThatAreClosedOrFullTakeNoResults) {
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"info", "smoke.vdb"}, {"--version"}, {"--help"}, {"render", "--help"}}) {
        expectFailure(arguments, kOutput, "cannot write to the standard output: Bad file descriptor", shell("", ">&-"));
        expectFailure(arguments, kOutput, "cannot write to the standard output: No space left on device",
                      shell("", "> /dev/full"));
    }
}

class Limits : public ProgramTest {
  protected:
    void SetUp() override {
        if (sanitized()) GTEST_SKIP() << "sanitizers take all the memory that there is";
        ProgramTest::SetUp();
    }
    static bool sanitized() {
#ifdef SCRIM_SANITIZED
        return true;
#else
        return false;
#endif
    }
};

TEST_F(Limits, OfFilesAreToldWhereAVolumeIsHandedOver) {
    expectFailure({"render", "scene.toml"}, kOutput,
                  "smoke.vdb: cannot hand over what was read: it exceeds the limit on file sizes (ulimit -f) or on "
                  "memory (--memory)",
                  shell("ulimit -f 4"));
}

TEST_F(Limits, OfFilesAreToldWhereAPictureIsWritten) {
    expectFailure({"render", "scene.toml", "--res", "512x384", "-o", "x.exr"}, kOutput,
                  "cannot write 'x.exr': File too large; raise the limit (ulimit -f)", shell("ulimit -f 128"));
}

TEST_F(Limits, OfFilesAreToldWhereAVolumeIsWritten) {
    expectFailure({"make", "noise", "resolution=40", "-o", "n.vdb"}, kOutput,
                  "n.vdb: cannot be written: File too large; raise the limit (ulimit -f)", shell("ulimit -f 8"));
}

// However few there are: never is it said that the file is damaged.
TEST_F(Limits, OfDescriptorsAreToldWhicheverTheyAre) {
    int done = 0, told = 0;
    for (int most = 5; most <= 24; ++most) {
        const ProgramResult result = run({"render", "scene.toml", "-q"}, shell("ulimit -n " + std::to_string(most)));
        if (result.status == 127)
            continue;  // too few for the program itself, beside those that whoever runs this has open
        if (result.status == 0) {
            ++done;
            continue;
        }
        ++told;
        EXPECT_EQ(result.status, kRender) << most << ": " << result.err;
        EXPECT_NE(result.err.find("Too many open files"), std::string::npos) << most << ": " << result.err;
    }
    EXPECT_GT(done, 0);
    EXPECT_GT(told, 0);
}

TEST_F(Limits, OfMemoryAreToldWhicheverTheyAre) {
    for (const char* kind : {"-v ", "-d "}) {
        int done = 0, told = 0;
        for (int kilobytes = 60000; kilobytes < 2000000; kilobytes = kilobytes * 5 / 4) {
            const ProgramResult result =
                run({"render", "scene.toml", "-q"}, shell(std::string("ulimit ") + kind + std::to_string(kilobytes)));
            if (result.status == 127) continue;  // the program itself does not fit
            ++(result.status == 0 ? done : told);
            if (result.status != 0) {
                EXPECT_EQ(result.status, kMemory) << kind << kilobytes << ": " << result.err;
            }
        }
        EXPECT_GT(done, 0);
    }
}

// Its own limit of time, and not that of the process, is up to the file; neither is want of memory.
TEST_F(Limits, OfTimeAreToldWhoseverTheyAre) {
    ProgramOptions given = shell("");
    given.environment = {{"SCRIM_PLUGIN_PATH", SCRIM_BAD_SOURCES}};
    const auto source = [&](const std::string& act) {
        write("in", "abc");
        write("source.toml", kCamera + kLight +
                                 "[[volume]]\nsource = \"readsfile\"\nparameters = { file = \"in\", act = \"" + act +
                                 "\" }\n");
    };
    source("have had its time");
    expectFailure({"render", "source.toml", "--threads", "1"}, kInput,
                  "source.toml:11:10: source 'readsfile': in: reading it did not finish within 0 seconds of CPU time",
                  given);
    source("loop");
    given.shell = "ulimit -t 1; exec \"$0\" \"$@\"";
    expectFailure(
        {"render", "source.toml", "--threads", "1"}, kRender,
        "source.toml:11:10: source 'readsfile': in: reading it exceeded the limit on CPU time; raise it (ulimit -t)",
        given);
}

TEST_F(Limits, OfMemoryAreNotTheFaultOfAMesh) {
    std::string points = "v 0 0 0\nv 1 0 0\n";
    for (int i = 0; i < 100000; ++i) points += "v 0 1 0\n";
    for (int i = 0; i < 100000; ++i) points += "f 1 2 3\n";
    write("mesh.obj", points);
    write("mesh.toml", kCamera + kVolume + kLight + "[[mesh]]\nname = \"floor\"\nfile = \"mesh.obj\"\n");
    // Too little for the libraries, then for the mesh, then for Embree: where one ends depends on the machine.
    bool told = false;
    for (int kilobytes = 72000; kilobytes <= 260000 && !told; kilobytes += 2000) {
        const ProgramResult result =
            run({"render", "mesh.toml", "-q"}, shell("ulimit -v " + std::to_string(kilobytes)));
        if (result.status == 127) continue;  // the program itself does not fit
        EXPECT_EQ(result.status, kMemory) << kilobytes << ": " << result.err;
        told = result.err.find("mesh 'floor': mesh.obj: not enough memory to read it") != std::string::npos ||
               result.err.find("mesh 'floor': not enough memory to take over what was read") != std::string::npos;
    }
    EXPECT_TRUE(told);
}

TEST_F(Limits, DoNotHideWhatIsDamaged) {
    writeBytes(file("smoke.vdb"), readBytes(file("smoke.vdb")).substr(0, 900));
    const ProgramResult result = run({"render", "scene.toml"}, shell("ulimit -n 64; ulimit -f 100000"));
    EXPECT_EQ(result.status, 3);
    EXPECT_NE(result.err.find("smoke.vdb: truncated or damaged"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace scrim::test
