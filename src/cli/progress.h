// SPDX-License-Identifier: Apache-2.0
// Progress in the form that its reader needs: people at a terminal, log files, farm managers, programs.
#pragma once

#include "console.h"

#include <scrim/base/messages.h>

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

namespace scrim::cli {

enum class ProgressStyle { automatic, bar, plain, alf, openjd, json, none };

/// The names in the order of ProgressStyle.
const std::vector<std::string>& progressStyleNames();

/// Reports the progress of one run of several frames, of which several jobs may each render one. It
/// prints only on change: bar and plain lines to stderr, the others to stdout. `job`: from 0 on.
class Progress {
  public:
    /// `automatic` is a bar on a terminal, and elsewhere a few plain lines; nothing with -q. Refers to `console`.
    Progress(ProgressStyle style, Console& console);
    ~Progress() { m_console.status(""); }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Before the first frame.
    void setFrameCount(int count) { m_count = count; }
    void setJobCount(int count) { m_jobs.resize(static_cast<std::size_t>(count)); }

    void beginFrame(int frame, int job = 0);
    /// `part`: the finished fraction of the job's frame, 0 to 1.
    void report(double part, int job = 0);
    void endFrame(int job = 0);

    /// A sink for a stage that takes the frame from `from` to `to`; it stops the work when a signal was received.
    ProgressSink stage(double from, double to, int job = 0);

  private:
    using Clock = std::chrono::steady_clock;

    struct Job {
        int frame = 0;
        double part = 0;  // of the frame
    };

    double done() const;
    void show(const Job& job);
    void print(const Job& job);
    void printBar(const Job& job);
    std::string whereText(const Job& job) const;

    ProgressStyle m_style;
    Clock::duration m_pause;  ///< least time between two lines
    Console& m_console;
    std::mutex m_mutex;
    std::vector<Job> m_jobs{1};
    int m_count = 1, m_index = 0;  ///< frames of the run, and those that are done
    int m_printed = -1;            ///< position that the last line reported, in the steps of the style
    Clock::time_point m_start = Clock::now();
    Clock::time_point m_drawn{};
};

}  // namespace scrim::cli
