// SPDX-License-Identifier: Apache-2.0
// The file of --stats: one JSON array with an object for each frame. It is written as it grows, so that the thousandth
// frame costs no more than the first, and appears completely or not at all.
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
    /// If the run ended early, completes the file with the frames up to there; without any finished frame there is no
    /// file.
    ~StatsFile();
    StatsFile(const StatsFile&) = delete;
    StatsFile& operator=(const StatsFile&) = delete;

    void add(const ShotReport& report);
    /// Ends the array and moves the file to its place. Must be the last call.
    void finish();

  private:
    void write(const std::string& text);

    AtomicFile m_file;
    std::ofstream m_out;
    bool m_any = false, m_ended = false;
};

}  // namespace scrim::cli
