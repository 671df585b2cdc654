// SPDX-License-Identifier: Apache-2.0
// A request for the numbers of a file that become a field.
#pragma once

#include <scrim/base/error.h>

#include <string>
#include <tuple>

namespace scrim {

/// The part of a grid's numbers that counts. A field holds no number below 0, so a grid with both
/// signs becomes two fields, whose difference it is.
enum class GridPart {
    whole,     ///< all numbers; those below 0 are errors and count as 0
    positive,  ///< for velocities: numbers above 0, others as 0
    negative,  ///< for velocities: numbers below 0 without their sign, others as 0
    /// Lists of points in place of voxels (PointRaster::list): of the points of a density, or of an attribute, the
    /// value of each; and of a density's points the places (components 0, 1, 2) or the radius (kScalar) of each. Empty
    /// where voxels show the points well enough, and where the name means no points.
    ofPoints,
    places,
    positiveOfPoints,  ///< as ofPoints; numbers as `positive` and `negative` have them
    negativeOfPoints,
};

/// A scalar grid as it is, or one component of a colour or a velocity.
struct GridRequest {
    /// For a scalar, the name as chooseGrid (grid_choice.h) understands it. A colour or velocity is
    /// a vec3 grid of this name, or three scalar grids with .x, .y, .z (or .r, .g, .b) after it; a
    /// colour may also be one scalar grid, which is grey.
    std::string grid;
    int component = kScalar;  ///< kScalar, or 0, 1, 2 for red, green, blue or x, y, z
    /// Components of a velocity keep their positions: the faces of voxels where the grid's class is "staggered".
    GridPart part = GridPart::whole;

    static constexpr int kScalar = -1;
    bool operator==(const GridRequest&) const = default;
    bool operator<(const GridRequest& other) const {
        return std::tie(grid, component, part) < std::tie(other.grid, other.component, other.part);
    }
};

/// True for a part that is a list of points.
constexpr bool isList(GridPart part) {
    return part >= GridPart::ofPoints;
}

/// The request for the grid that a list is of, or else the same.
GridRequest withoutList(GridRequest request);

/// Convert a request to one word for other processes, "scalar:density", "0:Cd", "+0:velocity",
/// "-scalar:vx", "*0:Cd" (of points), "@0:spray" (places), "*+0:v", "*-0:v", and back.
/// The latter throws Error(usage) for any other text.
std::string toText(const GridRequest& request);
GridRequest gridRequestFrom(const std::string& text);

/// A file lacks the grid that was requested. The caller may know where the request was written.
class GridError : public Error {
  public:
    GridError(const std::string& message, GridRequest request);
    const GridRequest& request() const noexcept { return m_request; }

  private:
    GridRequest m_request;
};

}  // namespace scrim
