// SPDX-License-Identifier: Apache-2.0
#include "console.h"

#include <scrim/base/error.h>

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iterator>

namespace scrim::cli {
namespace {

constexpr const char* kEraseLine = "\r\x1b[K";

[[noreturn]] void cannotPrint() {
    throw Error(ErrorKind::output, std::string("cannot write to the standard output: ") + std::strerror(errno));
}

}  // namespace

void Console::print(const std::string& text) {
    const std::lock_guard lock(m_mutex);
    if (!m_status.empty()) std::fputs(kEraseLine, stderr);
    std::fputs((text + "\n" + m_status).c_str(), stderr);
    std::fflush(stderr);
}

void Console::line(const std::string& text) {
    if (!m_quiet) print(text);
}

void Console::detail(const std::string& text) {
    if (m_verbose) print(text);
}

void Console::warning(const std::string& text) {
    print("scrim: warning: " + text);
}

void Console::status(const std::string& text) {
    const std::lock_guard lock(m_mutex);
    if (text == m_status) return;
    std::fputs((kEraseLine + text).c_str(), stderr);
    std::fflush(stderr);
    m_status = text;
}

MessageSink Console::sink() {
    return [this](Severity severity, const std::string& text) {
        if (severity == Severity::warning)
            warning(text);
        else
            line("scrim: " + text);
    };
}

void printOut(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) cannotPrint();
}

void flushOut() {
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) cannotPrint();
}

}  // namespace scrim::cli
