// SPDX-License-Identifier: Apache-2.0
#include "confine.h"

#include "answered_calls.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <vector>

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/capability.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SCRIM_SANITIZED 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SCRIM_SANITIZED 1
#endif

#if defined(__x86_64__)
#define SCRIM_AUDIT_ARCH AUDIT_ARCH_X86_64
#elif defined(__aarch64__)
#define SCRIM_AUDIT_ARCH AUDIT_ARCH_AARCH64
#else
#error "name this processor's AUDIT_ARCH_... of <linux/audit.h>"
#endif

namespace scrim::load {
namespace {

/// The address space of this process, bytes.
[[maybe_unused]] std::size_t addressSpace() {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * std::size_t(::sysconf(_SC_PAGESIZE));
}

constexpr rlim_t kMostAnsweredFiles = 64;
/// Seconds between SIGXCPU, which identifies the time limit as the cause, and SIGKILL, which does not.
constexpr rlim_t kGrace = 2;

/// Lowers a limit to `most`, or to the limit that this process was given if that is lower, since only root can raise
/// it. The hard limit is `beyond` higher; it acts without a signal that can be handled.
bool limit(__rlimit_resource resource, rlim_t most, rlim_t beyond = 0) {
    rlimit given{};
    if (::getrlimit(resource, &given) != 0) return false;
    const rlim_t soft = std::min({most, given.rlim_cur, given.rlim_max});  // "infinity" is the largest number
    const rlimit both{soft, std::min(soft + beyond, given.rlim_max)};
    return ::setrlimit(resource, &both) == 0;
}

/// Drops the capabilities of root, which could raise its limits again.
bool dropCapabilities() {
    __user_cap_header_struct self{_LINUX_CAPABILITY_VERSION_3, 0};
    const __user_cap_data_struct none[_LINUX_CAPABILITY_U32S_3] = {};
    return ::syscall(SYS_capset, &self, none) == 0;
}

/// Builds a filter of system calls, instruction by instruction (linux/filter.h).
class Filter {
  public:
    Filter() {
        load(offsetof(seccomp_data, arch));
        unlessEqual(SCRIM_AUDIT_ARCH, 1);
        end(SECCOMP_RET_KILL_PROCESS);
        loadCall();
    }

    void allow(long call) { answer(call, SECCOMP_RET_ALLOW); }
    /// The call fails with `error` without being made.
    void refuse(long call, int error) { answer(call, SECCOMP_RET_ERRNO | static_cast<std::uint32_t>(error)); }
    /// The call is passed to the handler of SIGSYS.
    void trap(long call) { answer(call, SECCOMP_RET_TRAP); }
    /// Allowed where argument number `argument` (its lower half) has none of the bits `forbidden`.
    void allowWithout(long call, int argument, std::uint32_t forbidden) {
        answerWithout(call, argument, forbidden, SECCOMP_RET_ALLOW);
    }
    /// Allowed where argument number `argument` has one of `bits`; otherwise it fails without being made.
    void allowOnlyWith(long call, int argument, std::uint32_t bits, int error) {
        skipUnless(call, 4);
        loadArgument(argument);
        add(BPF_JMP | BPF_JSET | BPF_K, bits, 0, 1);
        end(SECCOMP_RET_ALLOW, SECCOMP_RET_ERRNO | static_cast<std::uint32_t>(error));
    }
    void trapWithout(long call, int argument, std::uint32_t forbidden) {
        answerWithout(call, argument, forbidden, SECCOMP_RET_TRAP);
    }
    void allowWith(long call, int argument, std::uint32_t value) {
        skipUnless(call, 4);
        loadArgument(argument);
        unlessEqual(value, 1);
        end(SECCOMP_RET_KILL_PROCESS, SECCOMP_RET_ALLOW);
    }

    bool install() {
        end(SECCOMP_RET_KILL_PROCESS);
        const sock_fprog program{static_cast<unsigned short>(m_code.size()), m_code.data()};
        return ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &program) == 0;
    }

  private:
    void answer(long call, std::uint32_t action) {
        skipUnless(call, 1);
        end(action);
    }
    void answerWithout(long call, int argument, std::uint32_t forbidden, std::uint32_t action) {
        skipUnless(call, 4);
        loadArgument(argument);
        add(BPF_JMP | BPF_JSET | BPF_K, forbidden, 1, 0);
        end(action);
        end(SECCOMP_RET_KILL_PROCESS);
    }
    void add(int code, std::uint32_t k, int ifTrue = 0, int ifFalse = 0) {
        m_code.push_back({static_cast<std::uint16_t>(code), static_cast<std::uint8_t>(ifTrue),
                          static_cast<std::uint8_t>(ifFalse), k});
    }
    void load(std::size_t at) { add(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(at)); }
    void loadCall() { load(offsetof(seccomp_data, nr)); }
    void loadArgument(int i) { load(offsetof(seccomp_data, args) + 8 * static_cast<std::size_t>(i)); }
    void end(std::uint32_t action) { add(BPF_RET | BPF_K, action); }
    void end(std::uint32_t action, std::uint32_t other) {
        end(action);
        end(other);
    }
    /// Skips `count` instructions if the value equals `value`.
    void unlessEqual(std::uint32_t value, int count) { add(BPF_JMP | BPF_JEQ | BPF_K, value, count, 0); }
    void skipUnless(long call, int count) {
        add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, count);
    }

    std::vector<sock_filter> m_code;
};

/// Traps the calls of libraries that open files by name. Opening a file for writing is not included.
void answerCalls(Filter& filter) {
    constexpr std::uint32_t kWriting = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND;
    filter.trapWithout(SYS_openat, 2, kWriting);
#if defined(SYS_open)
    filter.trapWithout(SYS_open, 1, kWriting);
#endif
    for (const long call : AnsweredCalls::ofNames()) filter.trap(call);
    filter.allow(SYS_dup);
    // Callers can do without these, or report that they cannot.
    for (const long call : {SYS_statx, SYS_fadvise64, SYS_sched_getaffinity}) filter.refuse(call, ENOSYS);
    // The process may query and lower its own limits; 0 stands for the process itself.
    filter.allowWith(SYS_prlimit64, 0, 0);
    filter.refuse(SYS_ioctl, ENOTTY);
    filter.refuse(SYS_fcntl, EINVAL);
    filter.refuse(SYS_getcwd, ENOENT);
    // Some readers wait for threads that could not be started. Threads run under the same filter.
    filter.allowOnlyWith(SYS_clone, 0, CLONE_THREAD, EAGAIN);
    filter.refuse(SYS_clone3, ENOSYS);  // a filter cannot see its flags; callers then fall back to the call above
    for (const long call : {SYS_set_robust_list, SYS_rseq}) filter.allow(call);
    for (const long call : {SYS_sysinfo, SYS_uname, SYS_clock_nanosleep, SYS_getrusage}) filter.allow(call);
}

/// Installs a filter under which no call opens, names or connects anything.
bool filterCalls(Files files) {
    Filter filter;
    if (files == Files::answered) answerCalls(filter);
    for (const long call :
         {SYS_read,          SYS_pread64,      SYS_readv,     SYS_write,          SYS_writev,       SYS_pwrite64,
          SYS_lseek,         SYS_fstat,        SYS_ftruncate, SYS_close,          SYS_brk,          SYS_munmap,
          SYS_mremap,        SYS_madvise,      SYS_futex,     SYS_rt_sigprocmask, SYS_rt_sigreturn, SYS_sched_yield,
          SYS_clock_gettime, SYS_gettimeofday, SYS_getpid,    SYS_gettid,         SYS_getrandom,    SYS_exit,
          SYS_exit_group})
        filter.allow(call);
    // Memory may not hold code.
    filter.allowWithout(SYS_mmap, 2, PROT_EXEC);
    filter.allowWithout(SYS_mprotect, 2, PROT_EXEC);
    // abort() ends a process by sending it a signal.
    filter.allowWith(SYS_tgkill, 0, static_cast<std::uint32_t>(::getpid()));
    return filter.install();
}

}  // namespace

bool hasFilter() {
#if defined(SCRIM_SANITIZED)
    return false;
#else
    return true;
#endif
}

bool confine(const Limits& limits, Files files) {
    bool good = ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0;
    good = limit(RLIMIT_CORE, 0) && limit(RLIMIT_CPU, limits.seconds, kGrace) && dropCapabilities() && good;
    // The data it sends lies in memory, too. Exceeding the limit is an error, not a crash.
    std::signal(SIGXFSZ, SIG_IGN);
    good = limit(RLIMIT_FSIZE, limits.memory) && good;
    if (!hasFilter()) return good;  // sanitizers also take huge address spaces
    const rlim_t descriptors = files == Files::answered ? kMostAnsweredFiles : 0;
    good = limit(RLIMIT_AS, addressSpace() + limits.memory) && limit(RLIMIT_NOFILE, descriptors) && good;
    return good && filterCalls(files);
}

}  // namespace scrim::load
