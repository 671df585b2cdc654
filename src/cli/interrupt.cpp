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

// A signal handler has nothing but globals.
std::atomic<int> g_signal{0};
static_assert(std::atomic<int>::is_always_lock_free, "the handler writes it");

// A second signal, or the time that the first one left, ends the program where it stands.
[[noreturn]] void leave(int signal) {
    removeUncommittedFiles();
    ::_exit(128 + signal);
}

// How long the program may take to come to a place where it can stop in order, which is nearly always less than a
// twentieth of a second. Whoever stops a program waits for it, and a farm kills what does not go: then a picture that
// is half written would stay. A timer and not a loop's own look at the clock, since no loop can forget it.
constexpr itimerval kPatience{{0, 0}, {0, 800'000}};

extern "C" void onInterrupt(int signal) {
    int none = 0;
    if (!g_signal.compare_exchange_strong(none, signal)) leave(signal);
    ::setitimer(ITIMER_REAL, &kPatience, nullptr);  // a plain system call on Linux, so safe here
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
        // A program started with a signal ignored (nohup, background jobs of a script) leaves it at that.
        struct sigaction before {};
        ::sigaction(signal, nullptr, &before);
        if (before.sa_handler != SIG_IGN) ::sigaction(signal, &action, nullptr);
    }
    struct sigaction late {};
    late.sa_handler = onLate;
    sigemptyset(&late.sa_mask);
    ::sigaction(SIGALRM, &late, nullptr);
    // A reader of our output that went away is an error of writing, not a reason to die with files half
    // written.
    std::signal(SIGPIPE, SIG_IGN);
    // So is a file that may not grow any further.
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
