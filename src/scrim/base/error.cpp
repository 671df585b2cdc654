// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/error.h>

namespace scrim {

std::string clipped(std::string_view message, std::size_t limit) {
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

}  // namespace scrim
