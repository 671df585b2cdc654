// SPDX-License-Identifier: Apache-2.0
#include "run_reports.h"

#include "frame_lines.h"

#include <scrim/base/error.h>

#include <fmt/format.h>

namespace scrim::cli {

RunReports::RunReports(const SceneOptions& options, Console& console) : m_console(console) {
    if (!options.stats.empty()) m_stats.emplace(options.stats);
}

void RunReports::tell(std::size_t place, const ShotReport& report) {
    const std::lock_guard lock(m_mutex);
    m_console.line(summaryLine(report));
    m_console.detail(detailLines(report));
    if (m_stats) m_stats->add(place, report);
}

void RunReports::skip(std::size_t place) {
    const std::lock_guard lock(m_mutex);
    if (m_stats) m_stats->skip(place);
}

void RunReports::keep(const std::string& text) {
    const std::lock_guard lock(m_mutex);
    if (m_missed++ == 0) m_firstMissed = text;
}

void RunReports::keepMissed(const ShotReport& report) {
    if (report.scattering && !report.scattering->converged)
        keep(
            fmt::format("frame {}: written, but multiple scattering has not converged: further sweeps would change "
                        "it by about {:.2g}, more than render.scatter_error = {:.2g}",
                        report.frame, report.scattering->error, report.scattering->wanted));
    if (!report.tolerance || report.tolerance->met) return;
    keep(fmt::format("frame {}: written, but its error may be {:.3g}, more than the tolerance of {:.3g}{}",
                     report.frame, report.tolerance->bound, report.tolerance->wanted,
                     report.verification->outOfTime ? " (--verify-limit allowed too few pixels to tell)" : ""));
}

void RunReports::finish() {
    if (m_stats) m_stats->finish();
    if (m_missed == 0) return;
    const std::string others = m_missed > 1 ? fmt::format(" (and {} more frames)", m_missed - 1) : "";
    throw Error(ErrorKind::accuracy, m_firstMissed + others);
}

}  // namespace scrim::cli
