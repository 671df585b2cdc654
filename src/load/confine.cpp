// SPDX-License-Identifier: Apache-2.0
#include "confine.h"

#include "answered_calls.h"
#include "sanitized.h"

#include <scrim/base/process_limits.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <fstream>

#include <fcntl.h>
#include <linux/capability.h>
#include <seccomp.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

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

/// Drops the capabilities of root, which could raise its limits again. Returns 0 or the errno.
int dropCapabilities() {
    __user_cap_header_struct self{_LINUX_CAPABILITY_VERSION_3, 0};
    const __user_cap_data_struct none[_LINUX_CAPABILITY_U32S_3] = {};
    return ::syscall(SYS_capset, &self, none) == 0 ? 0 : errno;
}

/// Builds a filter of system calls. A call that is not named ends the process, unless `otherwise` says something else.
class Filter {
  public:
    explicit Filter(std::uint32_t otherwise = SCMP_ACT_KILL_PROCESS) : m_context(::seccomp_init(otherwise)) {
        m_problem = m_context == nullptr ? ENOMEM : 0;
        // By default the library would end the thread only, and leave out threads that are running already.
        set(SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS);
        set(SCMP_FLTATR_CTL_TSYNC, 1);
    }
    ~Filter() { ::seccomp_release(m_context); }
    Filter(const Filter&) = delete;
    Filter& operator=(const Filter&) = delete;

    void allow(long call) { add(SCMP_ACT_ALLOW, call); }
    /// The call fails with `error` without being made.
    void refuse(long call, int error) { add(SCMP_ACT_ERRNO(std::uint32_t(error)), call); }
    /// The call is passed to the handler of SIGSYS.
    void trap(long call) { add(SCMP_ACT_TRAP, call); }
    /// The call ends the process where argument number `argument` has the bit `bit`.
    void endWith(long call, unsigned argument, std::uint32_t bit) {
        add(SCMP_ACT_KILL_PROCESS, call, hasBits(argument, bit, bit));
    }
    /// Allowed where argument number `argument` has none of the bits `forbidden`.
    void allowWithout(long call, unsigned argument, std::uint32_t forbidden) {
        add(SCMP_ACT_ALLOW, call, hasBits(argument, forbidden, 0));
    }
    void refuseWithout(long call, unsigned argument, std::uint32_t forbidden, int error) {
        add(SCMP_ACT_ERRNO(std::uint32_t(error)), call, hasBits(argument, forbidden, 0));
    }
    void trapWithout(long call, unsigned argument, std::uint32_t forbidden) {
        add(SCMP_ACT_TRAP, call, hasBits(argument, forbidden, 0));
    }
    /// Allowed where argument number `argument` has the bit `bit`.
    void allowWithBit(long call, unsigned argument, std::uint32_t bit) {
        add(SCMP_ACT_ALLOW, call, hasBits(argument, bit, bit));
    }
    /// Allowed where argument number `argument` is `value`.
    void allowWith(long call, unsigned argument, std::uint32_t value) {
        add(SCMP_ACT_ALLOW, call, hasBits(argument, 0xFFFFFFFF, value));
    }
    /// The same; with any other value it fails without being made.
    void allowOnlyFor(long call, unsigned argument, std::uint32_t value, int error) {
        allowWith(call, argument, value);
        add(SCMP_ACT_ERRNO(std::uint32_t(error)), call, {argument, SCMP_CMP_NE, value, 0});
    }

    /// Returns 0 or the errno of the first call that failed.
    int install() { return m_problem != 0 ? m_problem : -::seccomp_load(m_context); }

  private:
    // The kernel reads these arguments as 32 bits; their upper halves may hold anything.
    static scmp_arg_cmp hasBits(unsigned argument, std::uint32_t mask, std::uint32_t value) {
        return {argument, SCMP_CMP_MASKED_EQ, mask, value};
    }
    void set(scmp_filter_attr attribute, std::uint32_t value) {
        if (m_problem == 0) m_problem = -::seccomp_attr_set(m_context, attribute, value);
    }
    void add(std::uint32_t action, long call) { addRule(action, call, 0, nullptr); }
    void add(std::uint32_t action, long call, const scmp_arg_cmp& where) { addRule(action, call, 1, &where); }
    void addRule(std::uint32_t action, long call, unsigned conditions, const scmp_arg_cmp* where) {
        if (m_problem == 0)
            m_problem = -::seccomp_rule_add_array(m_context, action, static_cast<int>(call), conditions, where);
    }

    scmp_filter_ctx m_context;
    int m_problem = 0;
};

/// Allows threads, which run under the same filter, and questions about the machine.
void allowThreads(Filter& filter) {
    filter.allowWithBit(SYS_clone, 0, CLONE_THREAD);
    filter.refuse(SYS_clone3, ENOSYS);  // a filter cannot see its flags; callers then fall back to the call above
    for (const long call : {SYS_set_robust_list, SYS_rseq, SYS_clock_nanosleep}) filter.allow(call);
    // oneTBB keeps the processors of the thread that starts another. Other processes do not matter to anyone.
    for (const long call : {SYS_sched_getaffinity, SYS_sched_setaffinity}) filter.allowOnlyFor(call, 0, 0, ENOSYS);
    for (const long call : {SYS_sysinfo, SYS_uname, SYS_getrusage}) filter.allow(call);
}

/// Makes starting a process fail, for libraries that can do without.
void refuseProcesses(Filter& filter) {
    filter.refuseWithout(SYS_clone, 0, CLONE_THREAD, EAGAIN);
}

constexpr std::uint32_t kWriting = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND;

/// Traps the calls of libraries that open files by name. Opening a file for writing is not included.
void answerCalls(Filter& filter) {
    filter.trapWithout(SYS_openat, 2, kWriting);
#if defined(SYS_open)
    filter.trapWithout(SYS_open, 1, kWriting);
#endif
    for (const long call : AnsweredCalls::ofNames()) filter.trap(call);
    filter.allow(SYS_dup);
    // Callers can do without these, or report that they cannot.
    for (const long call : {SYS_statx, SYS_fadvise64}) filter.refuse(call, ENOSYS);
    // The process may query and lower its own limits; 0 stands for the process itself.
    filter.allowWith(SYS_prlimit64, 0, 0);
    filter.refuse(SYS_ioctl, ENOTTY);
    filter.refuse(SYS_fcntl, EINVAL);
    filter.refuse(SYS_getcwd, ENOENT);
    allowThreads(filter);  // some readers wait for threads that could not be started
    refuseProcesses(filter);
}

/// Installs a filter under which no call opens, names or connects anything. Returns 0 or the errno.
int filterCalls(Rights rights) {
    Filter filter;
    if (rights == Rights::names) answerCalls(filter);
    if (rights == Rights::threads) allowThreads(filter);
    for (const long call :
         {SYS_read,          SYS_pread64,      SYS_readv,     SYS_write,          SYS_writev,       SYS_pwrite64,
          SYS_lseek,         SYS_fstat,        SYS_ftruncate, SYS_close,          SYS_brk,          SYS_munmap,
          SYS_mremap,        SYS_madvise,      SYS_futex,     SYS_rt_sigprocmask, SYS_rt_sigreturn, SYS_sched_yield,
          SYS_clock_gettime, SYS_gettimeofday, SYS_getpid,    SYS_gettid,         SYS_getrandom,    SYS_exit,
          SYS_exit_group})
        filter.allow(call);
    if (rights == Rights::compiling) {
        allowThreads(filter);
        refuseProcesses(filter);
        for (const long call : {SYS_mmap, SYS_mprotect}) filter.allow(call);
        // Where a thread has freed much memory, free() reads how the system counts memory; it can do without.
        filter.refuseWithout(SYS_openat, 2, kWriting, ENOENT);
        filter.refuse(SYS_newfstatat, EBADF);  // LLVM asks what stderr is
        // forbidCode() adds a filter, which can only take rights away.
        filter.allowWith(SYS_prctl, 0, PR_SET_NO_NEW_PRIVS);
        filter.allow(SYS_seccomp);
    } else {
        // Memory may not hold code.
        filter.allowWithout(SYS_mmap, 2, PROT_EXEC);
        filter.allowWithout(SYS_mprotect, 2, PROT_EXEC);
    }
    // abort() ends a process by sending it a signal.
    filter.allowWith(SYS_tgkill, 0, static_cast<std::uint32_t>(::getpid()));
    return filter.install();
}

}  // namespace

int forbidCode() {
    if (!hasFilter()) return 0;
    Filter filter(SCMP_ACT_ALLOW);
    for (const long call : {SYS_mmap, SYS_mprotect}) filter.endWith(call, 2, PROT_EXEC);
    return filter.install();
}

bool hasFilter() {
#if defined(SCRIM_SANITIZED)
    return false;
#else
    return true;
#endif
}

int confine(const Limits& limits, Rights rights) {
    int problem = ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 ? 0 : errno;
    const auto keep = [&problem](int next) {
        if (problem == 0) problem = next;
    };
    keep(lowerLimit(RLIMIT_CORE, 0));
    keep(lowerLimit(RLIMIT_CPU, limits.seconds, kGrace));
    keep(dropCapabilities());
    // The data it sends lies in memory, too. Exceeding the limit is an error, not a crash.
    std::signal(SIGXFSZ, SIG_IGN);
    keep(lowerLimit(RLIMIT_FSIZE, limits.memory));
    if (!hasFilter()) return problem;  // sanitizers also take huge address spaces
    keep(lowerLimit(RLIMIT_AS, addressSpace() + limits.memory));
    keep(lowerLimit(RLIMIT_NOFILE, rights == Rights::names ? kMostAnsweredFiles : 0));
    return problem != 0 ? problem : filterCalls(rights);
}

}  // namespace scrim::load
