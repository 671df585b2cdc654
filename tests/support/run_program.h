// SPDX-License-Identifier: Apache-2.0
// Runs the program as a user would, in a folder of its own, and sees that it ends.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace scrim::test {

struct ProgramResult {
    int status = -1;        ///< exit status; -1 where a signal ended it
    int signal = 0;         ///< that ended it, or 0
    int pid = -1;           ///< that it had
    bool timedOut = false;  ///< and was killed for it
    std::string out, err;

    /// Of stderr, without its newline.
    std::string lastErrorLine() const;
};

struct ProgramOptions {
    std::chrono::seconds timeout{120};
    std::vector<std::pair<std::string, std::string>> environment;  ///< set beside the test's own, which loses OCIO
    std::string shell = {};  ///< how a shell runs the program: "ulimit -n 8; exec \"$0\" \"$@\""; "": none does
    bool ownGroup = false;   ///< in a process group of its own, whose number is its pid
};

/// SCRIM_PROGRAM, running in `folder`.
class RunningProgram {
  public:
    RunningProgram(const std::string& folder, const std::vector<std::string>& arguments,
                   const ProgramOptions& options = {});
    ~RunningProgram();
    RunningProgram(const RunningProgram&) = delete;
    RunningProgram& operator=(const RunningProgram&) = delete;

    /// Waits until stdout holds `text`; false where the program ended or ran out of time before.
    bool waitForOutput(const std::string& text);
    void sendSignal(int signal) const;
    /// Also after it ended.
    int pid() const { return m_id; }
    ProgramResult wait();

  private:
    bool ended();  ///< looks, without waiting

    std::chrono::steady_clock::time_point m_deadline;
    int m_pid = -1, m_out = -1, m_err = -1;  // m_pid: -1 once it has ended
    int m_id = -1;
    int m_waitStatus = 0;
};

ProgramResult runProgram(const std::string& folder, const std::vector<std::string>& arguments,
                         const ProgramOptions& options = {});

}  // namespace scrim::test
