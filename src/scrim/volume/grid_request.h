// SPDX-License-Identifier: Apache-2.0
// Which numbers of a file become a field.
#pragma once

#include <scrim/base/error.h>

#include <string>
#include <tuple>

namespace scrim {

/// A scalar grid as it is, or one component of a colour.
struct GridRequest {
    /// Of a scalar grid, as chooseGrid (grid_choice.h) understands it. A colour is a vec3 grid of this name, or three
    /// scalar grids with .x, .y, .z (or .r, .g, .b) behind it, or a scalar one, which is grey.
    std::string grid;
    int component = kScalar;  ///< or 0, 1, 2: red, green, blue

    static constexpr int kScalar = -1;
    bool operator==(const GridRequest&) const = default;
    bool operator<(const GridRequest& other) const {
        return std::tie(grid, component) < std::tie(other.grid, other.component);
    }
};

/// One word between processes: "scalar:density", "0:Cd". Back again; throws Error(usage) for anything else.
std::string toText(const GridRequest& request);
GridRequest gridRequestFrom(const std::string& text);

/// A file cannot give what was requested of it. Whoever requested it may know where that was written.
class GridError : public Error {
  public:
    GridError(const std::string& message, GridRequest request);
    const GridRequest& request() const noexcept { return m_request; }

  private:
    GridRequest m_request;
};

}  // namespace scrim
