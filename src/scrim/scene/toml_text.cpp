// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/toml_text.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace scrim {
namespace {

/// The number of bytes of the character that starts at `i`; 0 where none does (RFC 3629: no
/// overlong forms, no surrogates, nothing beyond U+10FFFF).
std::size_t characterAt(const std::string& text, std::size_t i) {
    const auto byte = [&](std::size_t k) -> unsigned {
        return k < text.size() ? static_cast<unsigned char>(text[k]) : 0;
    };
    const unsigned first = byte(i), second = byte(i + 1);
    const std::size_t length = first < 0x80                    ? 1
                               : first >= 0xc2 && first < 0xe0 ? 2
                               : first >= 0xe0 && first < 0xf0 ? 3
                               : first >= 0xf0 && first < 0xf5 ? 4
                                                               : 0;
    for (std::size_t k = 1; k < length; ++k)
        if ((byte(i + k) & 0xc0) != 0x80) return 0;
    const bool wrong = (first == 0xe0 && second < 0xa0) || (first == 0xed && second >= 0xa0) ||
                       (first == 0xf0 && second < 0x90) || (first == 0xf4 && second >= 0x90);
    return wrong ? 0 : length;
}

}  // namespace

std::size_t utf8Length(const std::string& text) {
    std::size_t i = 0;
    while (i < text.size()) {
        const std::size_t length = characterAt(text, i);
        if (length == 0) break;
        i += length;
    }
    return i;
}

bool isUtf8(const std::string& text) {
    return utf8Length(text) == text.size();
}

std::string asUtf8(std::string text) {
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = characterAt(text, i);
        if (length == 0) text[i] = '?';
        i += length == 0 ? 1 : length;
    }
    return text;
}

std::string tomlString(const std::string& text) {
    std::string out = "\"";
    for (const char c : asUtf8(text)) {
        if (c == '"' || c == '\\') out += '\\';
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            out += fmt::format("\\u{:04x}", c);
        else
            out += c;
    }
    return out + '"';
}

std::string tomlRounded(double v, int exponent) {
    if (v == 0) return "0";
    const int digits = static_cast<int>(std::floor(std::log10(std::abs(v)))) - exponent + 1;
    if (digits < 0 || (digits == 0 && std::abs(v) < 0.5 * std::pow(10.0, exponent))) return "0";
    const bool plain = exponent >= -9 && std::abs(v) < 1e12;
    if (!plain) return fmt::format("{:.{}e}", v, std::clamp(digits - 1, 0, 16));
    if (exponent >= 0)
        return fmt::format("{:.0f}", std::round(v / std::pow(10.0, exponent)) * std::pow(10.0, exponent));
    std::string text = fmt::format("{:.{}f}", v, -exponent);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text == "-0" ? "0" : text;
}

std::string tomlRounded(const Vec3& v, int exponent) {
    return fmt::format("[{}, {}, {}]", tomlRounded(v.x, exponent), tomlRounded(v.y, exponent),
                       tomlRounded(v.z, exponent));
}

std::string tomlSignificant(double v, int digits) {
    return v == 0 ? "0" : tomlRounded(v, static_cast<int>(std::floor(std::log10(std::abs(v)))) - digits + 1);
}

}  // namespace scrim
