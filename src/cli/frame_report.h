// SPDX-License-Identifier: Apache-2.0
// What one rendered frame took and how good it is: for the line at its end, for --stats and for the picture's
// metadata.
#pragma once

#include <scrim/engine/frame.h>
#include <scrim/verify/verify.h>

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace scrim::cli {

/// What came of a tolerance.
struct ToleranceReport {
    double wanted = 0;
    double predicted = 0;  ///< of the setting that was rendered last
    double texel = 0, sheetThickness = 0;
    double bound = 0;  ///< the error is below it with a confidence of 97.5 %
    int attempts = 0;  ///< settings that were rendered
    bool met = false;
};

struct FrameReport {
    std::string input;
    std::string file;
    int frame = 1;
    Int2 resolution{0};
    double load = 0, plan = 0, render = 0, verify = 0, write = 0;  ///< seconds; plan: with a tolerance's pilots
    StageTimes stages;                                             ///< of `render`
    RenderWork work;
    std::string planJson;
    int threads = 0;
    std::size_t peakBytes = 0;  ///< of the process so far
    std::optional<Verification> verification;
    bool verifiedInPart = false;  ///< its time was up
    std::optional<ToleranceReport> tolerance;

    double total() const { return load + plan + render + verify + write; }
};

/// Runs `task`, adds the seconds it took to `seconds`, and returns what it returned.
template <typename Task>
auto timed(double& seconds, const Task& task) {
    struct Adder {
        double& to;
        std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
        ~Adder() { to += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }
    } const adder{seconds};
    return task();
}

/// Of this process, now.
std::size_t peakResidentBytes();

/// "frame 1: plume.exr 512x512, 0.21 s (load 0.05, render 0.12, write 0.04)".
std::string summaryLine(const FrameReport& report);
/// The stages and the work, several lines without the last newline.
std::string detailLines(const FrameReport& report);

/// Counts of work as one compact JSON object: the same on every run, so that pictures with it are, too.
std::string workAsJson(const RenderWork& work);
/// All frames, as an array.
std::string reportsAsJson(const std::vector<FrameReport>& reports);

}  // namespace scrim::cli
