// SPDX-License-Identifier: Apache-2.0
// Comparison of names whose case does not matter. Only ASCII letters are converted, whatever the locale.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace scrim {

inline char lowerCase(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c;
}

inline std::string lowerCase(std::string text) {
    for (char& c : text) c = lowerCase(c);
    return text;
}

inline bool equalIgnoringCase(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](char x, char y) { return lowerCase(x) == lowerCase(y); });
}

}  // namespace scrim
