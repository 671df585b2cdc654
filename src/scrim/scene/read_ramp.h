// SPDX-License-Identifier: Apache-2.0
// Internal: ramps, which map a grid's values to numbers or colours.
#pragma once

#include <scrim/scene/toml_reader.h>

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

/// Reads a list of at least `least` points [x, y], x ascending. `read(value)` reads y; `point` describes a point in
/// messages. With `factors`, a point may have a third number, at least 0, which multiplies y.
template <typename T, typename Read>
std::vector<std::pair<double, T>> readRamp(const TomlValue& value, const std::string& point, const Read& read,
                                           std::size_t least = 2, bool factors = false) {
    std::vector<std::pair<double, T>> ramp;
    for (const TomlValue& item : value.items(0, "a list of " + point)) {
        const bool factor = factors && item.items(0, point).size() == 3;
        const auto parts = item.items(factor ? 3 : 2, point);
        const double x = parts[0].number(Range());
        const T y = factor ? read(parts[1]) * parts[2].number(Range::atLeast(0)) : read(parts[1]);
        if (!ramp.empty() && x <= ramp.back().first)
            parts[0].fail(fmt::format("'{}': {} does not come after {}; expected ascending values", value.name(), x,
                                      ramp.back().first));
        ramp.emplace_back(x, y);
    }
    if (ramp.size() < least) value.failExpecting((least == 1 ? "at least one " : "at least two ") + point);
    return ramp;
}

/// True if the ramp, whose y are not negative, maps 0 to 0. It must, because empty space is 0 and is never visited.
template <typename T>
bool keepsZero(const std::vector<std::pair<double, T>>& ramp) {
    const auto next = std::find_if(ramp.begin(), ramp.end(), [](const auto& point) { return point.first >= 0; });
    const auto last = next == ramp.begin() ? next : next - 1;
    const auto& a = *last;
    const auto& b = next == ramp.end() ? *last : *next;
    return b.first == 0 ? b.second == T(0) : a.second == T(0) && b.second == T(0);
}

}  // namespace scrim
