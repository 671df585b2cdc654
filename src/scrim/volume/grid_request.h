// SPDX-License-Identifier: Apache-2.0
// Which numbers of a file become a field.
#pragma once

#include <scrim/base/error.h>

#include <string>
#include <tuple>

namespace scrim {

/// Which numbers of a grid count. Fields hold none below 0, so numbers of both signs are the difference of two fields.
enum class GridPart {
    whole,     ///< all: those below 0 are faults, and count as 0
    positive,  ///< of a velocity: those above 0, or 0
    negative,  ///< of a velocity: those below 0 without their sign, or 0
};

/// A scalar grid as it is, or one component of a colour or velocity.
struct GridRequest {
    /// Of a scalar grid, as chooseGrid (grid_choice.h) understands it. A colour is a vec3 grid of this name, or three
    /// scalar grids with .x, .y, .z (or .r, .g, .b) behind it, or a scalar one, which is grey (no velocity is).
    std::string grid;
    int component = kScalar;  ///< or 0, 1, 2: red, green, blue; x, y, z
    /// Components of velocities stand where they are: on the faces of voxels where the grid's class is "staggered".
    GridPart part = GridPart::whole;

    static constexpr int kScalar = -1;
    bool operator==(const GridRequest&) const = default;
    bool operator<(const GridRequest& other) const {
        return std::tie(grid, component, part) < std::tie(other.grid, other.component, other.part);
    }
};

/// One word between processes: "scalar:density", "0:Cd", "+0:velocity", "-scalar:vx". Back again; throws Error(usage)
/// for anything else.
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
