// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/error.h>

#include <iterator>

#include <fmt/format.h>

namespace scrim {

std::string shortened(std::string_view message, std::size_t limit) {
    std::string text(message.substr(0, limit));
    for (char& c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x20 || byte == 0x7f) c = c == '\n' ? ' ' : '?';
    }
    if (message.size() > limit) text += "...";
    return text;
}

std::string choices(const std::vector<std::string>& names) {
    if (names.empty()) return "none";
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
        text += "'" + names[i] + "'";
    }
    return text;
}

std::string bytesText(std::size_t bytes) {
    constexpr double kStep = 1024;
    const char* const units[] = {"bytes", "KB", "MB", "GB", "TB"};
    double value = static_cast<double>(bytes);
    std::size_t unit = 0;
    for (; value >= kStep && unit + 1 < std::size(units); ++unit) value /= kStep;
    return unit == 0 ? fmt::format("{} bytes", bytes) : fmt::format("{:.1f} {}", value, units[unit]);
}

}  // namespace scrim
