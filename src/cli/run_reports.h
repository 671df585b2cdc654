// SPDX-License-Identifier: Apache-2.0
// What a render tells of its frames, of which several may be rendered at once.
#pragma once

#include "console.h"
#include "options.h"
#include "stats_file.h"

#include <scrim/shot/shot_frame.h>

#include <cstddef>
#include <mutex>
#include <optional>
#include <string>

namespace scrim::cli {

/// All members may be called from several threads.
class RunReports {
  public:
    /// Throws Error(output) where the file of statistics cannot be written. Refers to `console`.
    RunReports(const SceneOptions& options, Console& console);

    /// Tells of a frame that was written. `place`: its number in the order of the run, from 0 on.
    void tell(std::size_t place, const ShotReport& report);
    /// There is nothing to tell of a frame.
    void skip(std::size_t place);
    /// Keeps what the frame missed of what was asked for.
    void keepMissed(const ShotReport& report);

    /// Ends the file of statistics. Throws Error(accuracy) where frames missed what was asked for.
    void finish();

  private:
    void keep(const std::string& text);

    Console& m_console;
    std::mutex m_mutex;
    std::optional<StatsFile> m_stats;
    std::size_t m_missed = 0;  // what was missed
    std::string m_firstMissed;
};

}  // namespace scrim::cli
