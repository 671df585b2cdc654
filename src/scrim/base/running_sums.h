// SPDX-License-Identifier: Apache-2.0
// Choosing in proportion to weights, of which running sums are kept.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

namespace scrim {

/// The entry of the running sums, which are not empty, at which the fraction `part` of the total is
/// reached, and the position within that entry in [0, 1].
inline std::pair<std::size_t, double> findInSums(std::span<const double> sums, double part) {
    const double wanted = part * sums.back();
    const auto above = std::upper_bound(sums.begin(), sums.end(), wanted);
    const auto i = std::min(static_cast<std::size_t>(above - sums.begin()), sums.size() - 1);
    const double before = i > 0 ? sums[i - 1] : 0, own = sums[i] - before;
    return {i, own > 0 ? std::clamp((wanted - before) / own, 0.0, 1.0) : 0.5};
}

}  // namespace scrim
