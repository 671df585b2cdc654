// SPDX-License-Identifier: Apache-2.0
#include "stats_file.h"

#include <scrim/base/error.h>
#include <scrim/base/system_error.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <utility>

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
    const bool any = m_any || std::ranges::any_of(m_waiting, [](const auto& item) { return !item.second.empty(); });
    if (!any || m_ended) return;
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

void StatsFile::add(std::size_t place, const ShotReport& report) {
    put(place, textOf(report));
}

void StatsFile::skip(std::size_t place) {
    put(place, "");
}

void StatsFile::put(std::size_t place, std::string text) {
    m_waiting.emplace(place, std::move(text));
    while (!m_waiting.empty() && m_waiting.begin()->first == m_next) writeNext();
}

void StatsFile::writeNext() {
    const auto first = m_waiting.extract(m_waiting.begin());
    m_next = first.key() + 1;
    if (first.mapped().empty()) return;
    write((m_any ? ",\n  " : "[\n  ") + first.mapped());
    m_any = true;
}

void StatsFile::finish() {
    while (!m_waiting.empty()) writeNext();  // where the run ended early, some are missing before them
    write(m_any ? "\n]\n" : "[]\n");
    m_ended = true;
    m_file.commit();
}

}  // namespace scrim::cli
