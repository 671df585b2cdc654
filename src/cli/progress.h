// SPDX-License-Identifier: Apache-2.0
// Progress in the form that its reader needs: people at a terminal, log files, farm managers, programs.
#pragma once

#include "console.h"

#include <scrim/base/messages.h>

#include <chrono>
#include <string>
#include <vector>

namespace scrim::cli {

enum class ProgressStyle { automatic, bar, plain, alf, openjd, json, none };

/// The names in the order of ProgressStyle.
const std::vector<std::string>& progressStyleNames();

/// Reports the progress of one run of several frames. It prints only on change: bar and plain lines to stderr, the
/// others to stdout.
class Progress {
  public:
    /// `automatic` is a bar on a terminal, and elsewhere a few plain lines; nothing with -q. Refers to `console`.
    Progress(ProgressStyle style, Console& console);
    ~Progress() { m_console.status(""); }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void setFrameCount(int count) { m_count = count; }
    void beginFrame(int frame);
    /// `part`: the finished fraction of the frame, 0 to 1.
    void report(double part);
    void endFrame();

    /// A sink for a stage that takes the frame from `from` to `to`; it stops the work when a signal was received.
    ProgressSink stage(double from, double to);

  private:
    using Clock = std::chrono::steady_clock;

    void print(double part);
    void printBar(double part);
    std::string whereText(double done) const;

    ProgressStyle m_style;
    Clock::duration m_pause;  ///< least time between two lines
    Console& m_console;
    int m_count = 1, m_index = 0, m_frame = 0;
    int m_printed = -1;  ///< position that the last line reported, in the steps of the style
    Clock::time_point m_start = Clock::now();
    Clock::time_point m_drawn{};
};

}  // namespace scrim::cli
