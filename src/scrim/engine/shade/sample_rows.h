// SPDX-License-Identifier: Apache-2.0
// Values at a tile's samples: 256 floats, in rows of 16.
#pragma once

#include <scrim/base/real.h>
#include <scrim/geometry/sheets.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <type_traits>

namespace scrim {

inline void addTimes(Real weight, const Real* values, Real* sum) {
    if (weight == 0) return;
    for (int k = 0; k < kTileSize; ++k) sum[k] += weight * values[k];
}

/// The rows [first, end) of a tile's samples in which there is something.
struct SampleRows {
    int first = kTileEdge, end = 0;

    bool any() const { return first < end; }
    int begin() const { return first * kTileEdge; }  ///< index of the first sample
    int count() const { return (end - first) * kTileEdge; }

    /// Includes the rows in which one of 256 values is not 0.
    void include(const Real* values) {
        using Bits = std::conditional_t<sizeof(Real) == 4, std::uint32_t, std::uint64_t>;
        for (int row = 0; row < kTileEdge; ++row, values += kTileEdge) {
            Bits all = 0;  // a loop over floats with an early exit would not be vectorised
            for (int k = 0; k < kTileEdge; ++k) all |= std::bit_cast<Bits>(values[k]);
            if (all == 0) continue;
            first = std::min(first, row);
            end = std::max(end, row + 1);
        }
    }
};

}  // namespace scrim
