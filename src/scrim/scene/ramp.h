// SPDX-License-Identifier: Apache-2.0
// Ramps: values that points give.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

namespace scrim {

/// The ramp's value at x: linear between its points (x ascending, at least one), constant outside of them.
template <typename T>
T ramped(const std::vector<std::pair<double, T>>& ramp, double x) {
    const auto next =
        std::upper_bound(ramp.begin(), ramp.end(), x, [](double v, const auto& point) { return v < point.first; });
    if (next == ramp.begin()) return next->second;
    const auto& before = *(next - 1);
    if (next == ramp.end()) return before.second;
    const double t = (x - before.first) / (next->first - before.first);
    return before.second + t * (next->second - before.second);
}

}  // namespace scrim
