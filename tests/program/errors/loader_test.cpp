// SPDX-License-Identifier: Apache-2.0
// The program that reads volumes: what its children may not do, that it outlives them, that there is one of it; and
// that reading ahead changes nothing but the time.
#include "support/program_test.h"

#include <load/fork.h>
#include <scrim/scrim.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/guard/load_fields.h>
#include <scrim/guard/load_job.h>
#include <scrim/volume/vdb_info_text.h>

#include "support/expect_error.h"
#include "support/loader_processes.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

namespace scrim::test {
namespace {

const LoadOptions kGuarded{VolumeLoading::guarded, ""};

std::string outputOf(const std::string& command) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
    std::string text;
    for (int c = 0; pipe && (c = std::fgetc(pipe.get())) != EOF;) text += static_cast<char>(c);
    return text;
}

// Running programs scrim-load that this process started.
std::vector<int> loaders() {
    std::vector<int> found;
    for (const LoaderProcess& process : loaderProcesses())
        if (process.parent == ::getpid()) found.push_back(process.id);
    return found;
}

class Loader : public ProgramTest {
  protected:
    void SetUp() override { makeVdb(good(), {{.voxels = box({-6, -6, -6}, {6, 6, 6}, 0.4)}}); }
    std::string good() const { return file("good.vdb"); }
    std::size_t activeVoxels() const { return loadFields(good(), {{}}, kGuarded, {}).at(0).activeVoxels; }
};

TEST_F(Loader, IsConfined) {
    const std::string said = outputOf(SCRIM_LOADER " --check");
#ifdef SCRIM_SANITIZED
    EXPECT_EQ(said, "no filter: this is a build with a sanitizer\n");
#else
    const std::string threads =
        "starting a thread: allowed\nfreeing a thread's memory: allowed\n"
        "starting the threads of a loop: allowed\nmoving no other process: allowed\n"
        "opening a file: killed\nopening a file in a thread: killed\n"
        "opening a file in a thread from before: killed\nforking: killed\nforking in a thread: killed\n"
        "running a program: killed\nmaking a socket: killed\nloading code: killed\n";
    EXPECT_EQ(
        said,
        "computing: allowed\nopening a file: killed\nmaking a socket: killed\nforking: killed\n"
        "running a program: killed\nkilling another process: killed\naborting: killed\n"
        "with threads\n" +
            threads + "with threads, and OpenVDB loaded\n" + threads +
            "with volume sources loaded (mesh, noise, primitives, scan)\n"
            "opening the file: allowed\nopening the one beside it: allowed\nfinding no other file: allowed\n"
            "starting a thread: allowed\nstarting no process: allowed\nwriting to the file: killed\n"
            "making a file: killed\nremoving the file: killed\nmaking a socket: killed\n"
            "running a program: killed\nloading code: killed\n"
            "with expressions to compile\nmaking code: allowed\nstarting a thread: allowed\n"
            "freeing a thread's memory: allowed\nfinding no file: allowed\nwriting to a file: killed\nwriting to a "
            "file in a "
            "thread from before: killed\nmaking a socket: killed\n"
            "running a program: killed\nmaking code later: killed\nchanging memory into code later: killed\n"
            "limits\nlowering a limit for good: allowed\n"
            "asking for another process's limits: killed\nhanding over no more than it may: allowed\n");
#endif
}

// Whatever OpenVDB does with a file that is good, the filter allows it.
TEST_F(Loader, ReadsEveryKindOfFileAsThisProcessDoes) {
    const std::vector<MadeVoxel> voxels = box({-9, -4, -4}, {9, 4, 4}, 0.3);
    const std::vector<std::pair<MadeGrid, Container>> kinds{
        {{.voxels = voxels}, Container::stream},
        {{.type = "half", .voxels = voxels}, Container::file},
        {{.type = "double", .voxels = voxels, .tiles = {{{0, 128, 0}, 128, 0.1}}}, Container::file},
        {{.type = "sphere", .gridClass = "level set"}, Container::file},
        {{.voxels = voxels, .frustum = true}, Container::file},
    };
    const std::string path = file("kind.vdb");
    for (const auto& [grid, container] : kinds) {
        makeVdb(path, {grid, {.name = "v", .type = "vec3s", .colours = {{{0, 0, 0}, {1, 2, 3}}}}}, container);
        EXPECT_EQ(toJson(loadInfo(path, kGuarded)), toJson(loadInfo(path, {}))) << grid.type;
        const std::vector<GridRequest> requests{{"density"}, {"v", 0}, {"v", 2}};
        const auto here = loadFields(path, requests, {}, {}), there = loadFields(path, requests, kGuarded, {});
        ASSERT_EQ(there.size(), here.size());
        for (std::size_t i = 0; i < here.size(); ++i) {
            EXPECT_GT(here[i].activeVoxels, 0u);
            EXPECT_EQ(there[i].activeVoxels, here[i].activeVoxels) << grid.type << " " << i;
            EXPECT_EQ(there[i].blockOrigins, here[i].blockOrigins);
            EXPECT_TRUE(std::equal(here[i].block(0), here[i].block(here[i].blockCount()), there[i].block(0)));
        }
    }
}

#ifndef SCRIM_SANITIZED
// Binding OpenVDB's names takes longer than reading a small file.
TEST_F(Loader, LoadsOpenVdbWithTheFirstFileThatNeedsIt) {
    for (const int old : loaders()) ::kill(old, SIGKILL);
    ASSERT_TRUE(comesTrue([] { return loaders().empty(); }));
    const std::size_t voxels = activeVoxels();
    ASSERT_EQ(loaders().size(), 1u);
    const int loader = loaders().front();
    EXPECT_FALSE(hasMapped(loader, "libopenvdb.so"));
    makeVdb(file("sphere.vdb"), {{.type = "sphere", .gridClass = "level set"}});
    EXPECT_GT(loadFields(file("sphere.vdb"), {{}}, kGuarded, {}).at(0).activeVoxels, 0u);
    EXPECT_TRUE(hasMapped(loader, "libopenvdb.so"));
    EXPECT_EQ(activeVoxels(), voxels);
    EXPECT_EQ(loaders(), std::vector<int>{loader});
}
#endif

TEST_F(Loader, StartsOnceAndServesAll) {
    const std::size_t voxels = activeVoxels();
    EXPECT_EQ(voxels, 13u * 13 * 13);
    const std::vector<int> running = loaders();
    ASSERT_EQ(running.size(), 1u);
    for (int i = 0; i < 200; ++i) ASSERT_EQ(activeVoxels(), voxels);
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (int i = 0; i < 20; ++i) EXPECT_EQ(activeVoxels(), voxels);
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(loaders(), running);
}

// It forks while libraries have threads. One that runs may hold a lock.
TEST(ThreadsOfLoader, AreWaitedForUntilTheySleep) {
    std::atomic<bool> slept = false;
    std::promise<void> end;
    std::thread thread([&, ended = end.get_future()] {
        const auto ready = std::chrono::steady_clock::now() + std::chrono::milliseconds(50);
        while (std::chrono::steady_clock::now() < ready) {
        }
        slept = true;
        ended.wait();
    });
    load::waitForThreadsToSleep();
    EXPECT_TRUE(slept);
    end.set_value();
    thread.join();
}

TEST_F(Loader, OutlivesChildrenThatCrash) {
    activeVoxels();
    const std::vector<int> running = loaders();
    for (int i = 0; i < 5; ++i) {
        const Descriptor transfer(createTransfer());  // without a request: nothing that a child could do
        const Descriptor input(::open(good().c_str(), O_RDONLY | O_CLOEXEC));
        LoadJob job("", LoadedFiles::volumes, "some.vdb", {transfer.fd(), input.fd()}, {std::size_t{1} << 30}, false);
        EXPECT_EQ(errorOf(ErrorKind::input, [&] { job.wait({}); }),
                  "some.vdb: damaged: reading it crashed (signal SIGABRT)");
        EXPECT_GT(activeVoxels(), 0u);
    }
    EXPECT_EQ(loaders(), running);
}

TEST_F(Loader, IsStartedAgainAfterItWasKilled) {
    const std::size_t voxels = activeVoxels();
    const std::vector<int> before = loaders();
    ASSERT_EQ(before.size(), 1u);
    ::kill(before.front(), SIGKILL);
    ASSERT_TRUE(comesTrue([] { return loaders().empty(); }));
    EXPECT_EQ(activeVoxels(), voxels);
    ASSERT_EQ(loaders().size(), 1u);
    EXPECT_NE(loaders(), before);
}

// Running programs scrim-load of a process group: they stay in that of whoever started them, also when that has ended.
int loadersOfGroup(int group) {
    int count = 0;
    for (const LoaderProcess& process : loaderProcesses()) count += process.group == group;
    return count;
}

TEST_F(Loader, EndsWithTheProcessThatStartedIt) {
    ProgramOptions options;
    options.ownGroup = true;
    const ProgramResult done = runWell({"info", "good.vdb"}, options);
    EXPECT_TRUE(comesTrue([&] { return loadersOfGroup(done.pid) == 0; }));
    // And with one that is killed, so that it can tell nobody. It would run for half a minute.
    RunningProgram killed(m_folder.path(), {"render", "good.vdb", "--res", "1024x1024", "--verify", "1000000"},
                          options);
    EXPECT_TRUE(comesTrue([&] { return loadersOfGroup(killed.pid()) > 0; }));
    killed.sendSignal(SIGKILL);
    EXPECT_EQ(killed.wait().signal, SIGKILL);
    EXPECT_TRUE(comesTrue([&] { return loadersOfGroup(killed.pid()) == 0; }));
}

// What must start fast may not bring OpenImageIO and its 260 libraries, and the program not OpenVDB either.
TEST_F(Loader, AndProgramStartWithoutWhatStartsSlowly) {
    const std::string program = outputOf("ldd " SCRIM_PROGRAM), loader = outputOf("ldd " SCRIM_LOADER);
    for (const std::string& libraries : {program, loader}) {
        EXPECT_NE(libraries.find("libc.so"), std::string::npos);
        EXPECT_EQ(libraries.find("libOpenImageIO"), std::string::npos) << libraries;
        EXPECT_EQ(libraries.find("libLLVM"), std::string::npos) << libraries;
        EXPECT_LT(std::count(libraries.begin(), libraries.end(), '\n'), 40) << libraries;
    }
    EXPECT_EQ(program.find("libopenvdb"), std::string::npos) << program;
    EXPECT_EQ(loader.find("libscrim"), std::string::npos) << loader;
}

const char* const kSequence = R"(
[camera]
position = [0, 0, 40]
target = [0, 0, 0]
fov = 35
resolution = [24, 16]
[[volume]]
name = "smoke"
file = "smoke.####.vdb"
[[light]]
name = "key"
type = "distant"
direction = [-1, -1, -1]
)";

class ReadingAhead : public ProgramTest {
  protected:
    void SetUp() override {
        for (int frame = 1; frame <= 4; ++frame)
            makeVdb(file("smoke.000" + std::to_string(frame) + ".vdb"),
                    {{.voxels = box({-frame, -4, -4}, {frame, 4, 4}, frame == 3 ? -1 : 0.1 * frame)}});
        write("s.toml", kSequence);
    }
    Shot open() const {
        OpenOptions options;
        options.load = kGuarded;
        return Shot::open(file("s.toml"), {}, options);
    }
    // Pictures and messages of all frames.
    std::vector<std::string> rendered(bool ahead, std::size_t memory,
                                      MissingPolicy missing = MissingPolicy::error) const {
        Shot shot = open();
        std::vector<std::string> out;
        for (int frame = 1; frame <= 5; ++frame) {
            RenderOptions options;
            options.memory = memory;
            options.missing = missing;
            if (ahead) options.next = frame + 1;
            options.messages = [&](Severity, const std::string& text) { out.push_back(std::to_string(frame) + text); };
            try {
                const ShotFrame rendered = shot.render(frame, options);
                if (rendered.skipped()) continue;
                const std::vector<float> pixels = rendered.image().rgba;
                out.emplace_back(reinterpret_cast<const char*>(pixels.data()), pixels.size() * sizeof(float));
            } catch (const Error& error) {
                out.push_back(std::to_string(frame) + error.what());
            }
        }
        return out;
    }
};

TEST_F(ReadingAhead, ChangesNothing) {
    const std::vector<std::string> one = rendered(false, 0);
    ASSERT_GE(one.size(), 6u);
    EXPECT_NE(one[0], one[1]);
    for (const std::size_t memory : {std::size_t{0}, std::size_t{4} << 20, std::size_t{1} << 30})
        EXPECT_EQ(rendered(true, memory), rendered(false, memory)) << memory;
}

TEST_F(ReadingAhead, TellsErrorsWithTheFrameTheyBelongTo) {
    const std::string whole = readBytes(file("smoke.0002.vdb"));
    write("smoke.0002.vdb", whole.substr(0, whole.size() / 2));
    const std::vector<std::string> lines = rendered(true, 0);
    EXPECT_EQ(lines, rendered(false, 0));
    EXPECT_EQ(lines.at(1).rfind("2" + file("smoke.0002.vdb") + ": truncated or damaged: ", 0), 0u) << lines.at(1);
}

TEST_F(ReadingAhead, MissesFilesInTheFrameTheyBelongTo) {
    std::filesystem::remove(file("smoke.0002.vdb"));
    for (const MissingPolicy policy : {MissingPolicy::error, MissingPolicy::black, MissingPolicy::skip}) {
        const std::vector<std::string> lines = rendered(true, 0, policy);
        EXPECT_EQ(lines, rendered(false, 0, policy)) << static_cast<int>(policy);
        const std::string start = policy == MissingPolicy::error   ? "2"
                                  : policy == MissingPolicy::black ? "2frame 2: black instead: "
                                                                   : "2frame 2 is skipped: ";
        EXPECT_TRUE(lines.at(1).starts_with(start)) << lines.at(1);
        EXPECT_NE(lines.at(1).find("smoke.0002.vdb"), std::string::npos) << lines.at(1);
    }
}

// It was missing when the frame before began.
TEST_F(ReadingAhead, FindsAFileThatComesLate) {
    std::filesystem::rename(file("smoke.0002.vdb"), file("late.vdb"));
    Shot shot = open();
    RenderOptions options;
    options.next = 2;
    shot.render(1, options);
    std::filesystem::rename(file("late.vdb"), file("smoke.0002.vdb"));
    EXPECT_EQ(shot.render(2).image().rgba, open().render(2).image().rgba);
}

TEST_F(ReadingAhead, TakesNothingThatChangedSince) {
    Shot shot = open();
    RenderOptions options;
    options.next = 2;
    shot.render(1, options);
    std::filesystem::copy_file(file("smoke.0004.vdb"), file("new.vdb"));
    std::filesystem::rename(file("new.vdb"), file("smoke.0002.vdb"));
    EXPECT_EQ(shot.render(2).image().rgba, open().render(2).image().rgba);
}

TEST_F(ReadingAhead, IsGivenUpWithTheShot) {
    RenderOptions options;
    options.next = 2;
    for (int i = 0; i < 20; ++i) {
        Shot shot = open();
        shot.render(1, options);
    }
    options.progress = [](double) { return false; };
    EXPECT_EQ(errorOf(ErrorKind::interrupted, [&] { open().render(1, options); }), "the render was interrupted");
}

}  // namespace
}  // namespace scrim::test
