// SPDX-License-Identifier: Apache-2.0
#include "apart.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>
#include <fstream>
#include <new>
#include <stdexcept>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace mesh {
namespace {

constexpr int kPollMilliseconds = 100;
constexpr rlim_t kGrace = 2;  // seconds between SIGXCPU, which says that it was time that was wanting, and SIGKILL
constexpr char kDone = 'd', kFailed = 'f';  // the first byte of what the child says

/// To `value`, or to what this process was given, if that is less. So much `beyond` it no signal is asked any more.
void limit(decltype(RLIMIT_AS) resource, rlim_t value, rlim_t beyond = 0) {
    rlimit given{};
    if (::getrlimit(resource, &given) != 0) return;
    const rlim_t soft = std::min({value, given.rlim_cur, given.rlim_max});
    const rlimit both{soft, std::min(soft + beyond, given.rlim_max)};
    ::setrlimit(resource, &both);
}

[[maybe_unused]] rlim_t addressSpaceInUse() {
    rlim_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
}

void writeAll(int file, const std::string& text) {
    for (std::size_t done = 0; done < text.size();) {
        const ssize_t n = ::write(file, text.data() + done, text.size() - done);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return;
        done += static_cast<std::size_t>(n);
    }
}

constexpr const char* kTooLarge = "it needs more memory than a file of its size should";

/// A limit of this process that ends with this object.
class LimitForNow {
  public:
    LimitForNow(decltype(RLIMIT_AS) resource, rlim_t value) : m_resource(resource) {
        if (::getrlimit(resource, &m_before) != 0) return;
        m_known = true;
        const rlimit now{std::min(value, m_before.rlim_cur), m_before.rlim_max};
        ::setrlimit(resource, &now);
    }
    /// Whether this process may take less than `value` anyway.
    bool isLess(rlim_t value) const { return m_known && m_before.rlim_cur < value; }
    ~LimitForNow() {
        if (m_known) ::setrlimit(m_resource, &m_before);
    }
    LimitForNow(const LimitForNow&) = delete;
    LimitForNow& operator=(const LimitForNow&) = delete;

  private:
    decltype(RLIMIT_AS) m_resource;
    rlimit m_before{};
    bool m_known = false;
};

/// Seconds of processor time that this process has used, and the one that has begun.
rlim_t secondsUsed() {
    timespec used{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
    return static_cast<rlim_t>(used.tv_sec) + 1;
}

/// The child's whole life.
[[noreturn]] void live(int out, const std::function<std::string()>& work, const ApartLimits& limits) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGSEGV, SIGABRT, SIGBUS}) std::signal(number, SIG_DFL);
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);  // libraries print when they fail
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, limits.seconds, kGrace);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they reserve terabytes
    limit(RLIMIT_AS, addressSpaceInUse() + limits.moreMemory);
#endif
    std::string said;
    try {
        said = kDone + work();
    } catch (const std::bad_alloc&) {
        said = std::string(1, kFailed) + kTooLarge;
    } catch (const std::exception& error) {
        said = kFailed + std::string(error.what());
    }
    writeAll(out, said);
    ::_exit(0);
}

/// Whether a child that used so much was ended by this process's own limit of processor time.
bool limitsTime(const rusage& used) {
    rlimit given{};
    if (::getrlimit(RLIMIT_CPU, &given) != 0 || given.rlim_cur == RLIM_INFINITY) return false;
    constexpr long kMicroseconds = 1000000, kRounding = 100000;
    const long microseconds = kMicroseconds * (used.ru_utime.tv_sec + used.ru_stime.tv_sec) + used.ru_utime.tv_usec +
                              used.ru_stime.tv_usec + kRounding;
    return static_cast<rlim_t>(microseconds / kMicroseconds) >= given.rlim_cur;
}

std::string deathOf(int status, const rusage& used) {
    if (!WIFSIGNALED(status)) return fmt::format("its reader ended with status {}", WEXITSTATUS(status));
    const int number = WTERMSIG(status);
    if ((number == SIGXCPU || number == SIGKILL) && limitsTime(used))
        return "reading it takes more processor time than a process may; raise the limit (ulimit -t)";
    if (number == SIGXCPU) return "its reader did not come to an end";
    if (number == SIGKILL) return "its reader was killed (signal SIGKILL), probably for want of memory";
    return fmt::format("its reader crashed ({})", ::strsignal(WTERMSIG(status)));
}

}  // namespace

std::string runAlone(const std::function<std::string()>& work, const ApartLimits& limits) {
    const LimitForNow time(RLIMIT_CPU, secondsUsed() + limits.seconds);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    // How much address space is in use is told by a file, which such a process cannot open. What it has besides when it
    // begins is little.
    constexpr rlim_t kBesides = rlim_t{1} << 28;
    const rlim_t most = kBesides + limits.moreMemory;
    const LimitForNow memory(RLIMIT_DATA, most), space(RLIMIT_AS, RLIM_INFINITY);
    const bool lacks = memory.isLess(most) || space.isLess(most);
#else
    const bool lacks = false;
#endif
    try {
        return work();
    } catch (const std::bad_alloc&) {
        if (lacks) throw;
        throw std::runtime_error(kTooLarge);
    }
}

std::string runApart(const std::function<std::string()>& work, const ApartLimits& limits,
                     const std::function<bool()>& goOn) {
    int ends[2] = {-1, -1};
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(fmt::format("no pipe: {}", std::strerror(errno)));
    const pid_t child = ::fork();
    if (child < 0) {
        const int reason = errno;
        ::close(ends[0]);
        ::close(ends[1]);
        throw std::runtime_error(fmt::format("no child process: {}", std::strerror(reason)));
    }
    if (child == 0) live(ends[1], work, limits);
    ::close(ends[1]);

    std::string said;
    bool stopped = false, outOfMemory = false;
    char chunk[1 << 16];
    for (;;) {
        pollfd ready{ends[0], POLLIN, 0};
        if (::poll(&ready, 1, kPollMilliseconds) <= 0) {
            if (goOn()) continue;
            stopped = true;
            break;
        }
        const ssize_t n = ::read(ends[0], chunk, sizeof chunk);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        try {
            said.append(chunk, static_cast<std::size_t>(n));
        } catch (const std::bad_alloc&) {
            outOfMemory = true;
            break;
        }
    }
    ::close(ends[0]);
    if (stopped || outOfMemory) ::kill(child, SIGKILL);
    int status = 0;
    rusage used{};
    while (::wait4(child, &status, 0, &used) < 0 && errno == EINTR) {
    }
    if (stopped) return "";
    if (outOfMemory) throw std::bad_alloc();
    if (said.empty() || !WIFEXITED(status) || WEXITSTATUS(status) != 0) throw std::runtime_error(deathOf(status, used));
    const char first = said[0];
    said.erase(0, 1);
    if (first == kFailed) throw std::runtime_error(said);
    return said;
}

}  // namespace mesh
