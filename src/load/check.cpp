// SPDX-License-Identifier: Apache-2.0
#include "check.h"

#include "answered_calls.h"
#include "confine.h"
#include "fork.h"

#include <scrim/guard/load_protocol.h>
#include <scrim/volume/loaded_source.h>

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
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
int statusOf(Files files, const Task& task) {
    ChildProcess child = forked([&] {
        const int file = ::open("/dev/null", O_RDONLY);
        if (files == Files::answered) {
            AnsweredCalls::install("scan.nhdr", file);
            AnsweredCalls::add("scan.raw", file);
        }
        if (confine(kLimits, files) != 0) return kNotConfined;
        task();
        return 0;
    });
    return child.wait().status;
}

class Check {
  public:
    template <typename Task>
    void operator()(Files files, const char* what, int signal, const Task& task) {
        const int status = statusOf(files, task);
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

/// Tests for children whose libraries ask for files by name.
void checkNames(Check& expect) {
    constexpr Files kFiles = Files::answered;
    expect(kFiles, "opening the file", 0, [] { answerMustBe(::open("scan.nhdr", O_RDONLY) >= 0); });
    expect(kFiles, "opening the one beside it", 0, [] { answerMustBe(::open("./scan.raw", O_RDONLY) >= 0); });
    expect(kFiles, "finding no other file", 0, [] {
        for (const char* other : {"/dev/null", "/etc/passwd", "other.raw", "/scan.nhdr", "../scan.raw"})
            answerMustBe(::open(other, O_RDONLY) == -1 && errno == ENOENT);
        answerMustBe(::access("/", R_OK) == -1 && errno == ENOENT);
    });
    expect(kFiles, "starting a thread", 0, [] { std::thread([] {}).join(); });
    expect(kFiles, "starting no process", 0, [] { answerMustBe(::fork() == -1 && errno == EAGAIN); });
    expect(kFiles, "writing to the file", SIGSYS, [] { (void)::open("scan.nhdr", O_RDWR); });
    expect(kFiles, "making a file", SIGSYS, [] { (void)::open("new.raw", O_CREAT | O_WRONLY, 0600); });
    expect(kFiles, "removing the file", SIGSYS, [] { (void)::unlink("scan.nhdr"); });
    expect(kFiles, "making a socket", SIGSYS, [] { (void)::socket(AF_INET, SOCK_STREAM, 0); });
    expect(kFiles, "running a program", SIGSYS, [] { (void)::execl("/bin/true", "true", nullptr); });
    expect(kFiles, "loading code", SIGSYS,
           [] { (void)::mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0); });
}

void checkLimits(Check& expect) {
    constexpr Files kFiles = Files::answered;
    expect(kFiles, "lowering a limit for good", 0, [] {
        const rlimit less{kLimits.seconds - 1, kLimits.seconds - 1}, more{kLimits.seconds, kLimits.seconds};
        answerMustBe(::setrlimit(RLIMIT_CPU, &less) == 0);
        answerMustBe(::setrlimit(RLIMIT_CPU, &more) == -1 && errno == EPERM);
    });
    expect(kFiles, "asking for another process's limits", SIGSYS, [] {
        rlimit limits{};
        (void)::prlimit(1, RLIMIT_CPU, nullptr, &limits);
    });
    const int transfer = ::memfd_create("check", MFD_CLOEXEC);
    expect(kFiles, "handing over no more than it may", 0, [transfer] {
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
    constexpr Files kFiles = Files::descriptors;
    expect(kFiles, "computing", 0, [] { std::vector<char> memory(std::size_t{1} << 20, 'x'); });
    expect(kFiles, "opening a file", SIGSYS, [] { (void)::open("/dev/null", O_RDONLY); });
    expect(kFiles, "making a socket", SIGSYS, [] { (void)::socket(AF_INET, SOCK_STREAM, 0); });
    expect(kFiles, "forking", SIGSYS, [] { (void)::fork(); });
    expect(kFiles, "running a program", SIGSYS, [] { (void)::execl("/bin/true", "true", nullptr); });
    expect(kFiles, "killing another process", SIGSYS, [] { (void)::kill(1, 0); });
    expect(kFiles, "aborting", SIGABRT, [] { std::abort(); });
    std::printf("with volume sources loaded (%s)\n", loadSources().c_str());
    checkNames(expect);
    checkLimits(expect);
    return expect.good();
}

}  // namespace scrim::load
