// SPDX-License-Identifier: Apache-2.0
#include "interrupt.h"

#include <scrim/base/error.h>
#include <scrim/base/atomic_file.h>

#include <atomic>
#include <csignal>
#include <string>
#include <string_view>

#include <sys/time.h>
#include <unistd.h>

namespace scrim::cli {
namespace {

// A signal handler can only access globals.
std::atomic<int> g_signal{0};
static_assert(std::atomic<int>::is_always_lock_free, "the handler writes it");

// Ends the program immediately, on a second signal or when the time after the first one is over.
[[noreturn]] void leave(int signal) {
    removeUncommittedFiles();
    ::_exit(128 + signal);
}

// The time that the program has to reach a point where it can stop in order; it nearly always takes less than a
// twentieth of a second. Users wait for the program, and a farm kills programs that do not end, which would leave a
// half-written picture. A timer is used instead of checks in loops, since no loop can forget it.
constexpr itimerval kPatience{{0, 0}, {0, 800'000}};

extern "C" void onInterrupt(int signal) {
    int none = 0;
    if (!g_signal.compare_exchange_strong(none, signal)) leave(signal);
    ::setitimer(ITIMER_REAL, &kPatience, nullptr);  // a plain system call on Linux, so it is safe here
}

extern "C" void onLate(int) {
    const int signal = g_signal.load();
    const std::string_view why =
        signal == SIGINT ? "scrim: interrupted by SIGINT\n" : "scrim: interrupted by SIGTERM\n";
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, why.data(), why.size());
    leave(signal);
}

}  // namespace

void handleInterrupts() {
    struct sigaction action {};
    action.sa_handler = onInterrupt;
    sigemptyset(&action.sa_mask);
    for (const int signal : {SIGINT, SIGTERM}) {
        // A program that was started with a signal ignored (nohup, background jobs of a script) keeps ignoring it.
        struct sigaction before {};
        ::sigaction(signal, nullptr, &before);
        if (before.sa_handler != SIG_IGN) ::sigaction(signal, &action, nullptr);
    }
    struct sigaction late {};
    late.sa_handler = onLate;
    sigemptyset(&late.sa_mask);
    ::sigaction(SIGALRM, &late, nullptr);
    // A reader of our output that has gone away is a write error, not a reason to die with half-written files.
    std::signal(SIGPIPE, SIG_IGN);
    // The same holds for a file that may not grow any further.
    std::signal(SIGXFSZ, SIG_IGN);
}

int interruptSignal() noexcept {
    return g_signal.load();
}

void throwIfInterrupted() {
    if (const int signal = interruptSignal())
        throw Error(ErrorKind::interrupted, std::string("interrupted by ") + (signal == SIGINT ? "SIGINT" : "SIGTERM"));
}

}  // namespace scrim::cli
