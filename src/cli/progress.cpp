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

void Progress::beginFrame(int frame) {
    m_frame = frame;
    if (m_style == ProgressStyle::openjd) {
        printOut(fmt::format("openjd_status: frame {} ({} of {})\n", frame, m_index + 1, m_count));
        flushOut();
    }
    report(0);
}

void Progress::endFrame() {
    report(1);
    m_index = std::min(m_index + 1, m_count);
}

void Progress::report(double part) {
    if (m_style == ProgressStyle::none) return;
    part = std::clamp(part, 0.0, 1.0);
    if (m_style == ProgressStyle::bar) return printBar(part);
    const double done = (m_index + part) / m_count;
    const int step = static_cast<int>(std::floor(done * stepsOf(m_style) + 1e-9));
    if (step <= m_printed || Clock::now() - m_drawn < m_pause) return;
    m_printed = step;
    m_drawn = Clock::now();
    print(part);
}

void Progress::print(double part) {
    const double percent = 100.0 * m_printed / stepsOf(m_style);
    if (m_style == ProgressStyle::plain)
        return m_console.line(fmt::format("{:.0f}%  {}", percent, whereText((m_index + part) / m_count)));
    if (m_style == ProgressStyle::alf) printOut(fmt::format("ALF_PROGRESS {:.0f}%\n", percent));
    if (m_style == ProgressStyle::openjd) printOut(fmt::format("openjd_progress: {:.1f}\n", percent));
    if (m_style == ProgressStyle::json) {
        const nlohmann::ordered_json line{{"progress", percent},
                                          {"frame", m_frame},
                                          {"frame_progress", std::round(1000 * part) / 10},
                                          {"index", m_index + 1},
                                          {"count", m_count}};
        printOut(line.dump() + "\n");
    }
    flushOut();
}

/// "frame 7 (3 of 48) 0:12, 3:01 left"; `done` is the finished fraction of the whole run.
std::string Progress::whereText(double done) const {
    const double elapsed = std::chrono::duration<double>(Clock::now() - m_start).count();
    std::string text = fmt::format("frame {} ({} of {})  {}", m_frame, m_index + 1, m_count, clockText(elapsed));
    // An earlier estimate would fluctuate too much.
    constexpr double kLeastToGuess = 0.02;
    if (done > kLeastToGuess) text += fmt::format(", {} left", clockText(elapsed / done - elapsed));
    return text;
}

void Progress::printBar(double part) {
    const Clock::time_point now = Clock::now();
    if (now - m_drawn < m_pause && part < 1) return;
    m_drawn = now;
    const double done = (m_index + part) / m_count;
    const int full = static_cast<int>(std::lround(done * kBarCells));
    m_console.status(fmt::format("[{}{}] {:3.0f}%  {}", std::string(std::size_t(full), '#'),
                                 std::string(std::size_t(kBarCells - full), '.'), 100 * done, whereText(done)));
}

ProgressSink Progress::stage(double from, double to) {
    return [this, from, to](double part) {
        report(from + (to - from) * part);
        return interruptSignal() == 0;
    };
}

}  // namespace scrim::cli
