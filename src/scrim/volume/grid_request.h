// SPDX-License-Identifier: Apache-2.0
// Which numbers of a file become a field.
#pragma once

#include <string>
#include <tuple>

namespace scrim {

/// A scalar grid as it is, or one component of a colour.
struct GridRequest {
    /// Of a grid, as VdbFile::field takes it. A colour is a vec3 grid of this name, or three scalar grids with .x, .y, .z
    /// (or .r, .g, .b) behind it, or a scalar one, which is grey.
    std::string grid;
    int component = kScalar;  ///< or 0, 1, 2: red, green, blue

    static constexpr int kScalar = -1;
    bool operator==(const GridRequest&) const = default;
    bool operator<(const GridRequest& other) const {
        return std::tie(grid, component) < std::tie(other.grid, other.component);
    }
};

}  // namespace scrim
