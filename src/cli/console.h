// SPDX-License-Identifier: Apache-2.0
// The program's output on stderr: lines that stay, and one status line below them that is redrawn.
// Both go through this class, so that they do not overwrite each other, from whichever thread.
#pragma once

#include <scrim/base/messages.h>

#include <cstddef>
#include <mutex>
#include <string>

namespace scrim::cli {

class Console {
  public:
    Console(bool verbose, bool quiet) : m_verbose(verbose), m_quiet(quiet) {}
    ~Console() { status(""); }
    Console(const Console&) = delete;
    Console& operator=(const Console&) = delete;

    bool verbose() const { return m_verbose; }
    bool quiet() const { return m_quiet; }

    void line(const std::string& text);     ///< not with -q
    void detail(const std::string& text);   ///< only with -v; may have several lines
    void warning(const std::string& text);  ///< always
    /// Redraws the status line; "" erases it. Only on terminals.
    void status(const std::string& text);

    /// A sink for the library's messages, which refers to this object.
    MessageSink sink();

  private:
    void print(const std::string& text);

    bool m_verbose, m_quiet;
    std::mutex m_mutex;
    std::string m_status;
};

/// Writes to stdout. Throws Error(output).
void printOut(const std::string& text);
/// Checks that all output was written. Throws Error(output).
void flushOut();

}  // namespace scrim::cli
