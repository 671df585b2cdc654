// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/toml_text.h>

#include <fmt/format.h>

namespace scrim {

std::string tomlString(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            out += fmt::format("\\u{:04x}", c);
        else
            out += c;
    }
    return out + '"';
}

}  // namespace scrim
