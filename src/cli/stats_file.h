// SPDX-License-Identifier: Apache-2.0
// --stats: one JSON array with an object a frame. It is written as it grows, so that a thousandth frame costs what the
// first did, and appears whole.
#pragma once

#include <scrim/base/atomic_file.h>
#include <scrim/shot/shot_frame.h>

#include <fstream>
#include <string>

namespace scrim::cli {

class StatsFile {
  public:
    /// Throws Error(output) where it cannot be written.
    explicit StatsFile(const std::string& path);
    /// Of a run that ended early: what it did is told up to there. Nothing is where no frame was finished.
    ~StatsFile();
    StatsFile(const StatsFile&) = delete;
    StatsFile& operator=(const StatsFile&) = delete;

    void add(const ShotReport& report);
    /// Ends the array and puts the file into its place. Nothing comes after that.
    void finish();

  private:
    void write(const std::string& text);

    AtomicFile m_file;
    std::ofstream m_out;
    bool m_any = false, m_ended = false;
};

}  // namespace scrim::cli
