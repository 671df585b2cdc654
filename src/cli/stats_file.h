// SPDX-License-Identifier: Apache-2.0
// The file of --stats: one JSON array with an object for each frame. It is written as it grows, so
// that the thousandth frame costs no more than the first, and appears completely or not at all.
#pragma once

#include <scrim/base/atomic_file.h>
#include <scrim/shot/shot_frame.h>

#include <cstddef>
#include <fstream>
#include <map>
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

    /// Adds a frame, or says that there is none at `place` in the order of the run, from 0 on. Frames may come in any
    /// order; the file has them in that of the run.
    void add(std::size_t place, const ShotReport& report);
    void skip(std::size_t place);
    /// Ends the array and moves the file to its place. Must be the last call.
    void finish();

  private:
    void put(std::size_t place, std::string text);
    void writeNext();
    void write(const std::string& text);

    AtomicFile m_file;
    std::ofstream m_out;
    std::size_t m_next = 0;                        // the place that comes next in the file
    std::map<std::size_t, std::string> m_waiting;  // by place: frames that others precede; "": none
    bool m_any = false, m_ended = false;
};

}  // namespace scrim::cli
