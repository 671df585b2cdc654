// SPDX-License-Identifier: Apache-2.0
// Measures how long a piece of work takes.
#pragma once

#include <chrono>

namespace scrim {

/// Runs `task`, adds the seconds that it took to `seconds` (also if it throws), and returns its result.
template <typename Task>
auto timed(double& seconds, const Task& task) {
    struct Adder {
        double& to;
        std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
        ~Adder() { to += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }
    } const adder{seconds};
    return task();
}

}  // namespace scrim
