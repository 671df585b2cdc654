// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/system_error.h>

#include <scrim/base/process_limits.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

namespace scrim {
ErrorKind kindOfSystemError(int errorNumber, ErrorKind otherwise) {
    switch (errorNumber) {
        case ENOMEM:
            return ErrorKind::memory;
        case EMFILE:
        case ENFILE:
            return ErrorKind::render;
        default:
            return otherwise;
    }
}

constexpr const char* kNoThreads = "out of memory or threads; raise the limit (ulimit -v, ulimit -u)";

void throwAsError() {
    try {
        throw;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorKind::memory, "out of memory");
    } catch (const std::length_error&) {
        throw Error(ErrorKind::memory, "out of memory: a single allocation exceeds the address space");
    } catch (const std::system_error& error) {
        if (error.code() == std::errc::resource_unavailable_try_again) throw Error(ErrorKind::memory, kNoThreads);
        throw Error(kindOfSystemError(error.code().value(), ErrorKind::render), error.what());
    } catch (const std::runtime_error& error) {
        // oneTBB's words where it cannot start a thread
        if (!std::string_view(error.what()).starts_with("pthread_create has failed")) throw;
        throw Error(ErrorKind::memory, kNoThreads);
    }
}

std::string systemErrorText(int errorNumber) {
    const std::string text = std::generic_category().message(errorNumber);
    if (errorNumber == EMFILE) return text + "; raise the limit (ulimit -n)";
    if (errorNumber == EFBIG && limitsFileSizes()) return text + "; raise the limit (ulimit -f)";
    if (errorNumber == ENOMEM && limitOf(RLIMIT_AS) != RLIM_INFINITY) return text + "; raise the limit (ulimit -v)";
    return text;
}

bool limitsFileSizes() {
    return limitOf(RLIMIT_FSIZE) != RLIM_INFINITY;
}

bool limitsTime(std::chrono::microseconds used) {
    // Processor time is counted in clock ticks, and that of threads which end together is counted late.
    constexpr std::chrono::milliseconds kRounding{100};
    constexpr double kNear = 0.75;
    const rlim_t most = limitOf(RLIMIT_CPU);
    return most != RLIM_INFINITY && used + kRounding >= kNear * std::chrono::duration<double>(most);
}

bool limitsMemory(std::size_t bytes) {
    return std::min(limitOf(RLIMIT_AS), limitOf(RLIMIT_DATA)) < bytes;
}

int aboveStandardStreams(int fd) noexcept {
    if (fd < 0 || fd > STDERR_FILENO) return fd;
    const int above = ::fcntl(fd, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    const int error = errno;
    ::close(fd);
    errno = error;
    return above;
}

void openStandardStreams() noexcept {
    // The lowest free descriptor is always assigned, so each of the three gets its own. Stdout is
    // opened for reading, so that writing to it fails as it does when closed.
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd)
        if (::fcntl(fd, F_GETFD) < 0) (void)::open("/dev/null", fd == STDERR_FILENO ? O_WRONLY : O_RDONLY);
}

}  // namespace scrim
