// SPDX-License-Identifier: Apache-2.0
// The one way to start, signal and wait for another process. Whoever holds a ChildProcess answers for it: the object
// ends the process and waits for it, so that none is left behind. The library starts programs and never forks: its host
// has threads (src/load/fork.h). Boost.Process is not used because it handles SIGCHLD
// for the whole process, which belongs to the application that links the library.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <sys/types.h>

namespace scrim {

/// A program to start. It gets the descriptors below and, of the others, those that are not closed on exec.
struct ProgramStart {
    static constexpr int kNothing = -1;  ///< stands for /dev/null

    std::vector<std::string> arguments;  ///< the first is the name that the program sees
    std::string path;                    ///< empty: the first argument is looked up in PATH
    /// (the number that the program sees, descriptor of this process or kNothing), set up in this order.
    std::vector<std::pair<int, int>> descriptors;
    std::vector<std::string> variables = {};  ///< "NAME=value", beside this process's environment
};

class ChildProcess {
  public:
    struct End {
        int status = 0;                     ///< as waitpid reports it
        std::chrono::microseconds used{0};  ///< processor time
    };

    /// Starts a program. The destructor sends it `endSignal` (0: none, since something else makes it end) unless its
    /// end is known, and waits. Throws std::system_error where the program cannot be started.
    explicit ChildProcess(const ProgramStart& start, int endSignal);
    /// Takes over a child of this process that fork made.
    ChildProcess(pid_t child, int endSignal) : m_pid(child), m_endSignal(endSignal) {}
    ~ChildProcess();
    ChildProcess(ChildProcess&& other) noexcept;
    ChildProcess& operator=(ChildProcess&& other) noexcept;

    /// Sends a signal. Does nothing once the end is known.
    void signal(int number) const;
    /// Waits for the end.
    End wait();
    /// How it ended; none while it runs.
    std::optional<End> ended();

  private:
    void reap(int options);

    pid_t m_pid = -1;
    int m_endSignal = 0;
    std::optional<End> m_end;
};

}  // namespace scrim
