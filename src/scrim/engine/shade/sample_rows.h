// SPDX-License-Identifier: Apache-2.0
// The part of a tile's samples that shows anything.
#pragma once

#include <scrim/base/real.h>
#include <scrim/geometry/sheets.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <type_traits>

namespace scrim {

/// Rows [first, end) of a tile's 16 x 16 samples.
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
