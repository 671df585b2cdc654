// SPDX-License-Identifier: Apache-2.0
#include "progress.h"

#include "interrupt.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

#include <unistd.h>

namespace scrim::cli {
namespace {

constexpr int kBarCells = 30;
constexpr std::chrono::milliseconds kRedraw(100);
constexpr std::chrono::seconds kLogPause(5);  // if the lines were not requested

ProgressStyle chosen(ProgressStyle style, const Console& console) {
    if (style != ProgressStyle::automatic) return style;
    if (console.quiet()) return ProgressStyle::none;
    return ::isatty(STDERR_FILENO) != 0 ? ProgressStyle::bar : ProgressStyle::plain;
}

/// The number of steps from nothing to all of the work.
int stepsOf(ProgressStyle style) {
    switch (style) {
        case ProgressStyle::openjd:
            return 1000;
        case ProgressStyle::plain:
            return 20;
        default:
            return 100;
    }
}

std::string clockText(double seconds) {
    const long s = std::lround(seconds);
    if (s >= 3600) return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
    return fmt::format("{}:{:02}", s / 60, s % 60);
}

}  // namespace

const std::vector<std::string>& progressStyleNames() {
    static const std::vector<std::string> names{"auto", "bar", "plain", "alf", "openjd", "json", "none"};
    return names;
}

Progress::Progress(ProgressStyle style, Console& console)
    : m_style(chosen(style, console)), m_pause(0), m_console(console) {
    if (m_style == ProgressStyle::bar) m_pause = kRedraw;
    if (m_style == ProgressStyle::plain && style == ProgressStyle::automatic) {
        m_pause = kLogPause;
        m_drawn = m_start;
    }
}

void Progress::beginFrame(int frame, int job) {
    const std::lock_guard lock(m_mutex);
    Job& own = m_jobs[static_cast<std::size_t>(job)];
    own = {frame, 0};
    if (m_style == ProgressStyle::openjd) {
        printOut(fmt::format("openjd_status: frame {} ({} of {})\n", frame, m_index + 1, m_count));
        flushOut();
    }
    show(own);
}

void Progress::endFrame(int job) {
    const std::lock_guard lock(m_mutex);
    Job& own = m_jobs[static_cast<std::size_t>(job)];
    own.part = 1;
    show(own);
    own.part = 0;
    m_index = std::min(m_index + 1, m_count);
}

void Progress::report(double part, int job) {
    if (m_style == ProgressStyle::none) return;
    const std::lock_guard lock(m_mutex);
    Job& own = m_jobs[static_cast<std::size_t>(job)];
    own.part = std::clamp(part, 0.0, 1.0);
    show(own);
}

/// The finished fraction of the whole run.
double Progress::done() const {
    double parts = 0;
    for (const Job& job : m_jobs) parts += job.part;
    return std::min((m_index + parts) / m_count, 1.0);
}

void Progress::show(const Job& job) {
    if (m_style == ProgressStyle::none) return;
    if (m_style == ProgressStyle::bar) return printBar(job);
    const int step = static_cast<int>(std::floor(done() * stepsOf(m_style) + 1e-9));
    if (step <= m_printed || Clock::now() - m_drawn < m_pause) return;
    m_printed = step;
    m_drawn = Clock::now();
    print(job);
}

void Progress::print(const Job& job) {
    const double percent = 100.0 * m_printed / stepsOf(m_style);
    if (m_style == ProgressStyle::plain) return m_console.line(fmt::format("{:.0f}%  {}", percent, whereText(job)));
    if (m_style == ProgressStyle::alf) printOut(fmt::format("ALF_PROGRESS {:.0f}%\n", percent));
    if (m_style == ProgressStyle::openjd) printOut(fmt::format("openjd_progress: {:.1f}\n", percent));
    if (m_style == ProgressStyle::json) {
        const nlohmann::ordered_json line{{"progress", percent},
                                          {"frame", job.frame},
                                          {"frame_progress", std::round(1000 * job.part) / 10},
                                          {"index", m_index + 1},
                                          {"count", m_count}};
        printOut(line.dump() + "\n");
    }
    flushOut();
}

/// "frame 7 (3 of 48) 0:12, 3:01 left".
std::string Progress::whereText(const Job& job) const {
    const double elapsed = std::chrono::duration<double>(Clock::now() - m_start).count(), part = done();
    std::string text = fmt::format("frame {} ({} of {})  {}", job.frame, m_index + 1, m_count, clockText(elapsed));
    // An earlier estimate would fluctuate too much.
    constexpr double kLeastToGuess = 0.02;
    if (part > kLeastToGuess) text += fmt::format(", {} left", clockText(elapsed / part - elapsed));
    return text;
}

void Progress::printBar(const Job& job) {
    const Clock::time_point now = Clock::now();
    if (now - m_drawn < m_pause && job.part < 1) return;
    m_drawn = now;
    const double part = done();
    const int full = static_cast<int>(std::lround(part * kBarCells));
    m_console.status(fmt::format("[{}{}] {:3.0f}%  {}", std::string(std::size_t(full), '#'),
                                 std::string(std::size_t(kBarCells - full), '.'), 100 * part, whereText(job)));
}

ProgressSink Progress::stage(double from, double to, int job) {
    return [this, from, to, job](double part) {
        report(from + (to - from) * part, job);
        return interruptSignal() == 0;
    };
}

}  // namespace scrim::cli
