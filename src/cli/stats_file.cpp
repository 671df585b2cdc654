// SPDX-License-Identifier: Apache-2.0
#include "stats_file.h"

#include <scrim/base/error.h>
#include <scrim/base/system_error.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cerrno>

namespace scrim::cli {
namespace {

/// The report, indented as an item of the array.
std::string textOf(const ShotReport& report) {
    using Json = nlohmann::ordered_json;
    std::string text;
    for (const char c : Json::parse(reportAsJson(report)).dump(2, ' ', false, Json::error_handler_t::replace)) {
        text += c;
        if (c == '\n') text += "  ";  // strings in JSON contain no line breaks
    }
    return text;
}

}  // namespace

StatsFile::StatsFile(const std::string& path) : m_file(path), m_out(m_file.tempPath(), std::ios::binary) {}

StatsFile::~StatsFile() {
    if (!m_any || m_ended) return;
    try {
        finish();
    } catch (const std::exception&) {
        // The reason why the run ended is already being reported.
    }
}

void StatsFile::write(const std::string& text) {
    errno = 0;
    if (m_out.write(text.data(), static_cast<std::streamsize>(text.size())).flush()) return;
    m_ended = true;
    throw Error(kindOfSystemError(errno, ErrorKind::output),
                fmt::format("cannot write '{}': {}", m_file.path(), systemErrorText(errno)));
}

void StatsFile::add(const ShotReport& report) {
    write((m_any ? ",\n  " : "[\n  ") + textOf(report));
    m_any = true;
}

void StatsFile::finish() {
    write(m_any ? "\n]\n" : "[]\n");
    m_ended = true;
    m_file.commit();
}

}  // namespace scrim::cli
