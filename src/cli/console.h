// SPDX-License-Identifier: Apache-2.0
// What the program says on stderr: lines that stay, and one line of status below them that is drawn over. One
// place, so that the two do not write into each other.
#pragma once

#include <scrim/base/messages.h>

#include <cstddef>
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

    void line(const std::string& text);     ///< not under -q
    void detail(const std::string& text);   ///< only under -v; may have several lines
    void warning(const std::string& text);  ///< always
    /// The line that is drawn over; "" erases it. Only for terminals.
    void status(const std::string& text);

    /// For the library's messages; refers to this.
    MessageSink sink();

  private:
    void print(const std::string& text);

    bool m_verbose, m_quiet;
    std::string m_status;
};

/// Writes to stdout. Throws Error(output).
void printOut(const std::string& text);
/// Sees that all of it arrived. Throws Error(output).
void flushOut();

}  // namespace scrim::cli
