// SPDX-License-Identifier: Apache-2.0
#include "check.h"

#include "answered_calls.h"
#include "confine.h"
#include "fork.h"
#include "read_volume.h"
#include "vdb_library.h"

#include <scrim/base/parallel.h>
#include <scrim/guard/load_protocol.h>
#include <scrim/volume/loaded_source.h>

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#ifndef SCRIM_LIB_FROM_LIBEXEC
#error "define SCRIM_LIB_FROM_LIBEXEC as the folder of the library, relative to that of programs, as a string"
#endif

namespace scrim::load {
namespace {

constexpr int kWrongAnswer = 4;

constexpr Limits kLimits{std::size_t{1} << 30, 10};

/// The status of a child that runs `task` while confined.
template <typename Task>
int statusOf(Rights rights, const Task& task) {
    ChildProcess child = forked([&] {
        const int file = ::open("/dev/null", O_RDONLY);
        if (rights == Rights::names) {
            AnsweredCalls::install("scan.nhdr", file);
            AnsweredCalls::add("scan.raw", file);
        }
        if (confine(kLimits, rights) != 0) return kNotConfined;
        task();
        return 0;
    });
    return child.wait().status;
}

/// The same for a task on a thread that was started before the child was confined.
template <typename Task>
int statusOfThread(Rights rights, const Task& task) {
    ChildProcess child = forked([&] {
        std::atomic<bool> confined = false;
        std::thread thread([&] {
            while (!confined) std::this_thread::yield();
            task();
        });
        if (confine(kLimits, rights) != 0) return kNotConfined;
        confined = true;
        thread.join();
        return 0;
    });
    return child.wait().status;
}

class Check {
  public:
    template <typename Task>
    void operator()(Rights rights, const char* what, int signal, const Task& task) {
        judge(what, signal, statusOf(rights, task));
    }
    /// `status`: how the child ended.
    void judge(const char* what, int signal, int status) {
        const bool asExpected = signal == 0 ? WIFEXITED(status) && WEXITSTATUS(status) == 0
                                            : WIFSIGNALED(status) && WTERMSIG(status) == signal;
        m_good = m_good && asExpected;
        std::printf("%s: %s\n", what, !asExpected ? "WRONG" : signal == 0 ? "allowed" : "killed");
    }
    bool good() const { return m_good; }

  private:
    bool m_good = true;
};

void answerMustBe(bool right) {
    if (!right) ::_exit(kWrongAnswer);
}

void fillAndFreeInThread() {
    std::thread([] {
        std::vector<std::unique_ptr<char[]>> pieces;
        for (int i = 0; i < 1000; ++i) pieces.push_back(std::make_unique<char[]>(std::size_t{1} << 14));
        while (!pieces.empty()) pieces.pop_back();
    }).join();
}

/// Tests for children that read a volume on several threads, which may do no more together than one of them.
void checkThreads(Check& expect) {
    constexpr Rights kRights = Rights::threads;
    expect(kRights, "starting a thread", 0, [] { std::thread([] {}).join(); });
    expect(kRights, "freeing a thread's memory", 0, fillAndFreeInThread);
    expect(kRights, "starting the threads of a loop", 0, [] {
        allowThreads();
        parallelFor(100, [](std::size_t) { std::this_thread::sleep_for(std::chrono::milliseconds(1)); });
    });
    expect(kRights, "moving no other process", 0, [] {
        cpu_set_t processors;
        CPU_ZERO(&processors);
        CPU_SET(0, &processors);
        answerMustBe(::sched_setaffinity(1, sizeof processors, &processors) == -1 && errno == ENOSYS);
    });
    const auto openFile = [] { (void)::open("/dev/null", O_RDONLY); };
    expect(kRights, "opening a file", SIGSYS, openFile);
    expect(kRights, "opening a file in a thread", SIGSYS, [&] { std::thread(openFile).join(); });
    expect.judge("opening a file in a thread from before", SIGSYS, statusOfThread(kRights, openFile));
    expect(kRights, "forking", SIGSYS, [] { (void)::fork(); });
    expect(kRights, "forking in a thread", SIGSYS, [] { std::thread([] { (void)::fork(); }).join(); });
    expect(kRights, "running a program", SIGSYS, [] { (void)::execl("/bin/true", "true", nullptr); });
    expect(kRights, "making a socket", SIGSYS, [] { (void)::socket(AF_INET, SOCK_STREAM, 0); });
    expect(kRights, "loading code", SIGSYS,
           [] { (void)::mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0); });
}

/// Tests for children whose libraries ask for files by name.
void checkNames(Check& expect) {
    constexpr Rights kRights = Rights::names;
    expect(kRights, "opening the file", 0, [] { answerMustBe(::open("scan.nhdr", O_RDONLY) >= 0); });
    expect(kRights, "opening the one beside it", 0, [] { answerMustBe(::open("./scan.raw", O_RDONLY) >= 0); });
    expect(kRights, "finding no other file", 0, [] {
        for (const char* other : {"/dev/null", "/etc/passwd", "other.raw", "/scan.nhdr", "../scan.raw"})
            answerMustBe(::open(other, O_RDONLY) == -1 && errno == ENOENT);
        answerMustBe(::access("/", R_OK) == -1 && errno == ENOENT);
    });
    expect(kRights, "starting a thread", 0, [] { std::thread([] {}).join(); });
    expect(kRights, "starting no process", 0, [] { answerMustBe(::fork() == -1 && errno == EAGAIN); });
    expect(kRights, "writing to the file", SIGSYS, [] { (void)::open("scan.nhdr", O_RDWR); });
    expect(kRights, "making a file", SIGSYS, [] { (void)::open("new.raw", O_CREAT | O_WRONLY, 0600); });
    expect(kRights, "removing the file", SIGSYS, [] { (void)::unlink("scan.nhdr"); });
    expect(kRights, "making a socket", SIGSYS, [] { (void)::socket(AF_INET, SOCK_STREAM, 0); });
    expect(kRights, "running a program", SIGSYS, [] { (void)::execl("/bin/true", "true", nullptr); });
    expect(kRights, "loading code", SIGSYS,
           [] { (void)::mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0); });
}

/// Tests for children that compile expressions.
void checkCode(Check& expect) {
    constexpr Rights kRights = Rights::compiling;
    const auto makeCode = [] {
        return ::mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    };
    expect(kRights, "making code", 0, [&] { answerMustBe(makeCode() != MAP_FAILED); });
    expect(kRights, "starting a thread", 0, [] { std::thread([] {}).join(); });
    expect(kRights, "freeing a thread's memory", 0, fillAndFreeInThread);
    expect(kRights, "finding no file", 0, [] { answerMustBe(::open("/dev/null", O_RDONLY) == -1 && errno == ENOENT); });
    const auto openFile = [] { (void)::open("/dev/null", O_RDWR); };
    expect(kRights, "writing to a file", SIGSYS, openFile);
    expect.judge("writing to a file in a thread from before", SIGSYS, statusOfThread(kRights, openFile));
    expect(kRights, "making a socket", SIGSYS, [] { (void)::socket(AF_INET, SOCK_STREAM, 0); });
    expect(kRights, "running a program", SIGSYS, [] { (void)::execl("/bin/true", "true", nullptr); });
    expect(kRights, "making code later", SIGSYS, [&] {
        answerMustBe(forbidCode() == 0);
        (void)makeCode();
    });
    expect(kRights, "changing memory into code later", SIGSYS, [] {
        void* const page = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        answerMustBe(page != MAP_FAILED && forbidCode() == 0);
        (void)::mprotect(page, 4096, PROT_READ | PROT_EXEC);
    });
}

void checkLimits(Check& expect) {
    constexpr Rights kRights = Rights::names;
    expect(kRights, "lowering a limit for good", 0, [] {
        const rlimit less{kLimits.seconds - 1, kLimits.seconds - 1}, more{kLimits.seconds, kLimits.seconds};
        answerMustBe(::setrlimit(RLIMIT_CPU, &less) == 0);
        answerMustBe(::setrlimit(RLIMIT_CPU, &more) == -1 && errno == EPERM);
    });
    expect(kRights, "asking for another process's limits", SIGSYS, [] {
        rlimit limits{};
        (void)::prlimit(1, RLIMIT_CPU, nullptr, &limits);
    });
    const int transfer = ::memfd_create("check", MFD_CLOEXEC);
    expect(kRights, "handing over no more than it may", 0, [transfer] {
        answerMustBe(::ftruncate(transfer, off_t{kLimits.memory}) == 0);
        answerMustBe(::ftruncate(transfer, off_t{kLimits.memory} + 1) == -1 && errno == EFBIG);
    });
    ::close(transfer);
}

/// Loads the volume sources installed with this program, as a child does before it is confined. Returns their names;
/// "none" where there are none.
std::string loadSources() {
    std::vector<std::string> names;
    std::error_code error;
    const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path().parent_path() /
                        SCRIM_LIB_FROM_LIBEXEC / "scrim/sources";
    for (std::filesystem::directory_iterator file(folder, error), end; !error && file != end; file.increment(error)) {
        if (sourceNameOf(file->path().string()).empty()) continue;
        names.push_back(LoadedSource(file->path().string()).description().name);
    }
    std::sort(names.begin(), names.end());
    return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

bool checkConfinement() {
    if (!hasFilter()) {
        std::puts("no filter: this is a build with a sanitizer");
        return true;
    }
    Check expect;
    constexpr Rights kRights = Rights::reading;
    expect(kRights, "computing", 0, [] { std::vector<char> memory(std::size_t{1} << 20, 'x'); });
    expect(kRights, "opening a file", SIGSYS, [] { (void)::open("/dev/null", O_RDONLY); });
    expect(kRights, "making a socket", SIGSYS, [] { (void)::socket(AF_INET, SOCK_STREAM, 0); });
    expect(kRights, "forking", SIGSYS, [] { (void)::fork(); });
    expect(kRights, "running a program", SIGSYS, [] { (void)::execl("/bin/true", "true", nullptr); });
    expect(kRights, "killing another process", SIGSYS, [] { (void)::kill(1, 0); });
    expect(kRights, "aborting", SIGABRT, [] { std::abort(); });
    std::puts("with threads");
    checkThreads(expect);
    loadOpenVdb();
    std::puts("with threads, and OpenVDB loaded");
    checkThreads(expect);
    std::printf("with volume sources loaded (%s)\n", loadSources().c_str());
    checkNames(expect);
    std::puts("with expressions to compile");
    checkCode(expect);
    std::puts("limits");
    checkLimits(expect);
    return expect.good();
}

}  // namespace scrim::load
