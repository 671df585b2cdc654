// SPDX-License-Identifier: Apache-2.0
#include "interrupt.h"

#include <scrim/base/error.h>
#include <scrim/base/atomic_file.h>

#include <atomic>
#include <csignal>
#include <string>

#include <unistd.h>

namespace scrim::cli {
namespace {

// A signal handler has nothing but globals.
std::atomic<int> g_signal{0};
static_assert(std::atomic<int>::is_always_lock_free, "the handler writes it");

extern "C" void onInterrupt(int signal) {
    int none = 0;
    if (g_signal.compare_exchange_strong(none, signal)) return;
    removeUncommittedFiles();
    ::_exit(128 + signal);
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
