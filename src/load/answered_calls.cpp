// SPDX-License-Identifier: Apache-2.0
#include "answered_calls.h"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>

#include <fcntl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

namespace scrim::load {
namespace {

constexpr std::size_t kLongestName = 255;  // the limit of Linux file systems

// A signal handler can only access globals.
std::string *s_path = nullptr, *s_beside = nullptr;
int s_file = -1, s_besideFile = -1;
std::atomic_flag s_anyLacked;
char s_lacked[kLongestName + 1] = {};

/// Iterates over the parts of a path, skipping empty parts and ".". It allocates no memory, since it may have
/// interrupted an allocation.
class Parts {
  public:
    explicit Parts(const char* path) : m_at(path) { skip(); }
    bool done() const { return *m_at == '\0'; }
    std::string_view rest() const { return m_at; }
    std::string_view next() {
        const std::string_view part(m_at, std::strcspn(m_at, "/"));
        m_at += part.size();
        skip();
        return part;
    }

  private:
    void skip() {
        while (*m_at == '/' || (*m_at == '.' && (m_at[1] == '/' || m_at[1] == '\0'))) ++m_at;
    }

    const char* m_at;
};

/// True where no part leads upwards.
bool isBelow(Parts parts) {
    while (!parts.done())
        if (parts.next() == "..") return false;
    return true;
}

/// The name of `path` within the folder of our file, or below it ("slices/ct.raw"); "" where it is elsewhere.
std::string_view nameInFolder(const char* path) {
    const char* ours = s_path->c_str();
    if ((*path == '/') != (*ours == '/')) return {};
    Parts parts(path), ourParts(ours);
    for (;;) {
        const std::string_view ourPart = ourParts.next();
        if (ourParts.done()) return isBelow(parts) ? parts.rest() : std::string_view();
        if (parts.done() || parts.next() != ourPart) return {};
    }
}

bool areSame(const char* name, const char* other) {
    Parts parts(name), others(other);
    while (!parts.done() && !others.done())
        if (parts.next() != others.next()) return false;
    return parts.done() && others.done();
}

/// The descriptor of the file called `path`; -1: there is none.
int fileCalled(const char* path) {
    if (path == nullptr) return -1;
    const std::string_view name = nameInFolder(path);
    if (name.empty()) return -1;
    // Names reach to the end of their paths, so that they end with a zero byte.
    if (areSame(name.data(), nameInFolder(s_path->c_str()).data())) return s_file;
    if (s_beside != nullptr && areSame(name.data(), s_beside->c_str())) return s_besideFile;
    if (name.size() <= kLongestName && !s_anyLacked.test_and_set()) name.copy(s_lacked, kLongestName);
    return -1;
}

/// The registers of the trapped call.
class Call {
  public:
    explicit Call(void* context) : m_registers(static_cast<ucontext_t*>(context)->uc_mcontext) {}

#if defined(__x86_64__)
    long argument(int i) const {
        constexpr int kPlaces[] = {REG_RDI, REG_RSI, REG_RDX, REG_R10};
        return static_cast<long>(m_registers.gregs[kPlaces[i]]);
    }
    void answer(long value) {
        m_registers.gregs[REG_RAX] = value;
    }
#elif defined(__aarch64__)
    long argument(int i) const {
        return static_cast<long>(m_registers.regs[i]);
    }
    void answer(long value) {
        m_registers.regs[0] = static_cast<unsigned long long>(value);
    }
#else
#error "name this processor's registers of arguments and results of system calls"
#endif
    const char* text(int i) const {
        return reinterpret_cast<const char*>(argument(i));
    }

  private:
    mcontext_t& m_registers;
};

/// Converts a result to the kernel's convention, in which errors are negative numbers.
long kernel(long result) {
    return result < 0 ? -errno : result;
}

long openAgain(int file) {
    const int again = ::dup(file);
    if (again >= 0) ::lseek(again, 0, SEEK_SET);
    return kernel(again);
}

long stat(long file, long result) {
    return kernel(::syscall(SYS_fstat, file, result));
}

/// Answers a call whose argument `name` is a file name: with `answer` if the name is that of one of our files.
template <typename Answer>
long ofOurs(const Call& call, int name, const Answer& answer) {
    const int file = fileCalled(call.text(name));
    return file >= 0 ? answer(file) : -ENOENT;
}

long access(long mode) {
    return (mode & (W_OK | X_OK)) != 0 ? -EACCES : 0;
}

long answerTo(int number, const Call& call) {
    switch (number) {
        case SYS_openat:
            return ofOurs(call, 1, openAgain);
        case SYS_newfstatat:
            if (call.text(1) != nullptr && *call.text(1) == '\0' && (call.argument(3) & AT_EMPTY_PATH) != 0)
                return stat(call.argument(0), call.argument(2));
            return ofOurs(call, 1, [&](int file) { return stat(file, call.argument(2)); });
        case SYS_faccessat:
        case SYS_faccessat2:
            return ofOurs(call, 1, [&](int) { return access(call.argument(2)); });
        case SYS_readlinkat:
            return ofOurs(call, 1, [](int) { return long{-EINVAL}; });
#if defined(SYS_open)
        case SYS_open:
            return ofOurs(call, 0, openAgain);
        case SYS_stat:
        case SYS_lstat:
            return ofOurs(call, 0, [&](int file) { return stat(file, call.argument(1)); });
        case SYS_access:
            return ofOurs(call, 0, [&](int) { return access(call.argument(1)); });
        case SYS_readlink:
            return ofOurs(call, 0, [](int) { return long{-EINVAL}; });
#endif
        default:
            return -ENOSYS;
    }
}

void handle(int, siginfo_t* info, void* context) {
    const int before = errno;
    Call call(context);
    call.answer(answerTo(info->si_syscall, call));
    errno = before;
}

}  // namespace

void AnsweredCalls::install(const std::string& path, int file) {
    s_path = new std::string(path);
    s_file = file;
    struct sigaction action {};
    action.sa_sigaction = handle;
    action.sa_flags = SA_SIGINFO;
    ::sigaction(SIGSYS, &action, nullptr);
}

void AnsweredCalls::add(const std::string& name, int file) {
    s_beside = new std::string(name);
    s_besideFile = file;
}

std::string AnsweredCalls::lacked() {
    return s_lacked;
}

std::span<const long> AnsweredCalls::ofNames() {
    static const long calls[] = {
        SYS_newfstatat,
        SYS_faccessat,
        SYS_faccessat2,
        SYS_readlinkat,
#if defined(SYS_open)
        SYS_stat,
        SYS_lstat,
        SYS_access,
        SYS_readlink,
#endif
    };
    return calls;
}

}  // namespace scrim::load
