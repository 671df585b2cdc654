// SPDX-License-Identifier: Apache-2.0
// Parts as percentages in messages.
#pragma once

#include <string>

#include <fmt/format.h>

namespace scrim {

/// `part` of one in percent, without the sign: two digits below 100 ("0.31", "17"), and whole
/// numbers from there on ("110", where two digits would be "1.1e+02").
inline std::string percentText(double part) {
    const double percent = 100 * part;
    return percent < 99.5 ? fmt::format("{:.2g}", percent) : fmt::format("{:.0f}", percent);
}

}  // namespace scrim
