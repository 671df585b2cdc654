// SPDX-License-Identifier: Apache-2.0
// Volume source `primitives`: solids with soft edges, for rooms, furniture, robots and rings.
//
//     scrim make primitives resolution=200 -o rings.vdb shapes='
//         torus center=-1,0,0 axis=0,0,1 radius=1.2 tube=0.2
//         torus center=1,0,0 axis=0,1,1 radius=1.2 tube=0.2 density=2
//         plane center=0,-2,0 size=8,8 thickness=0.2 density=0.5'
//
// Parameters (lengths in world units):
//   shapes      the list, see below
//   voxel       edge of a voxel; 0: the longest extent of all shapes divided by `resolution`
//   resolution  voxels along the longest extent of all shapes, where `voxel` is 0
//   soft        width of the edge, over which density falls from all to nothing; 0: one voxel. Half of it lies outside
//               of the surface. Narrower than a voxel, edges show steps
//   combine     what holds where shapes overlap: the largest of their densities (max, the default), or their sum
//
// A list has one shape a line, or several with ';' between them; from '#' to the end of a line is comment. A shape is
// its kind and its keys, each key=value without blanks; keys without a default in brackets must be there:
//   box        size=x,y,z       center [0,0,0]   round: radius of edges [0]
//   sphere     radius           center [0,0,0]
//   ellipsoid  size=x,y,z       center [0,0,0]
//   cylinder   from=x,y,z to=x,y,z radius        round: radius of edges [0]
//   capsule    from=x,y,z to=x,y,z radius        with round ends beyond `from` and `to`
//   torus      radius tube      center [0,0,0]   axis [0,1,0]; radius of the ring and of its tube
//   plane      size=x,z thickness   center [0,0,0]: the middle of its surface   normal [0,1,0]: of its surface; a thin
//              box below that
// and all of them: rotate=x,y,z [0,0,0] degrees about their middle, about x, then y, then z, as in scenes; density [1];
// soft [that of the list]; grid [density], the name of the grid it goes to, so that one list may give several grids.
// Values differ from shape to shape by `density`: a transfer function may then give each a colour.
//
// Density is the signed distance to the surface put through a linear ramp, so edges are smooth at any angle and solids
// keep their mass. Only blocks at edges are evaluated; the inside is tiles.
#include "fill.h"
#include "shape_list.h"

#include <scrim/volume/scrim_source.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>
#include <glm/common.hpp>

namespace primitives {
namespace {

constexpr double kMostVoxels = 16384;       // along an axis
constexpr double kFarthestVoxel = 1 << 28;  // from the origin: indices have 31 bits, and cubes need some room

enum { kShapes, kVoxel, kResolution, kSoft, kCombine, kCount };
constexpr scrim_parameter kParameters[kCount] = {
    {"shapes", SCRIM_STRING, "sphere radius=1", 0, 0, nullptr,
     "the list: one 'kind key=value ...' a line, or between ';'"},
    {"voxel", SCRIM_NUMBER, "0", 0, 1e9, nullptr, "edge of a voxel, in world units; 0: from resolution"},
    {"resolution", SCRIM_INTEGER, "128", 8, 8192, nullptr, "voxels along the longest extent, where voxel is 0"},
    {"soft", SCRIM_NUMBER, "0", 0, 1e9, nullptr, "width of soft edges, in world units; 0: one voxel"},
    {"combine", SCRIM_STRING, "max", 0, 0, "max|sum", "value where shapes overlap"},
};

struct Box {
    Vec3 lower{std::numeric_limits<double>::infinity()}, upper{-lower};

    void include(const Shape& s) {
        const Vec3 half = wsHalfExtent(s) + 0.5 * s.soft;
        lower = glm::min(lower, s.wsCentre - half);
        upper = glm::max(upper, s.wsCentre + half);
    }
    double longest() const { return std::max({upper.x - lower.x, upper.y - lower.y, upper.z - lower.z}); }
    double farthest() const {
        const Vec3 far = glm::max(glm::abs(lower), glm::abs(upper));
        return std::max({far.x, far.y, far.z});
    }
};

Box boxOf(const std::vector<Shape>& shapes) {
    Box box;
    for (const Shape& s : shapes) box.include(s);
    return box;
}

/// Sets the edges that the list leaves open, and checks the space to be filled.
void prepare(std::vector<Shape>& shapes, const Raster& raster, double soft) {
    for (Shape& s : shapes)
        if (s.soft <= 0) s.soft = soft > 0 ? soft : raster.voxel;
    const Box box = boxOf(shapes);
    if (box.longest() / raster.voxel > kMostVoxels)
        throw std::runtime_error(fmt::format("the shapes extend over {:.6g} voxels of {}, expected at most {}",
                                             box.longest() / raster.voxel, raster.voxel, kMostVoxels));
    if (box.farthest() / raster.voxel > kFarthestVoxel)
        throw std::runtime_error(fmt::format("the shapes lie {:.6g} voxels of {} from the origin, expected at most {}",
                                             box.farthest() / raster.voxel, raster.voxel, kFarthestVoxel));
}

int run(const scrim_host* host, const scrim_value* values) {
    std::vector<Shape> shapes = parseShapes(values[kShapes].text);
    Raster raster;
    raster.voxel = values[kVoxel].number[0];
    if (raster.voxel <= 0) raster.voxel = boxOf(shapes).longest() / static_cast<double>(values[kResolution].integer);
    raster.combine = std::string_view(values[kCombine].text) == "max" ? Combine::max : Combine::sum;
    prepare(shapes, raster, values[kSoft].number[0]);

    std::vector<std::string> grids;  // in the order of the list
    for (const Shape& s : shapes)
        if (std::find(grids.begin(), grids.end(), s.grid) == grids.end()) grids.push_back(s.grid);

    const double v = raster.voxel, shift = 0.5 * v;
    const double worldFromIndex[16] = {v, 0, 0, shift, 0, v, 0, shift, 0, 0, v, shift, 0, 0, 0, 1};
    for (std::size_t i = 0; i < grids.size(); ++i) {
        const int grid = host->add_grid(host, grids[i].c_str(), worldFromIndex);
        if (grid < 0) return grid;
        std::vector<Shape> own;
        std::copy_if(shapes.begin(), shapes.end(), std::back_inserter(own),
                     [&](const Shape& s) { return s.grid == grids[i]; });
        const auto part = [&](std::size_t k) { return static_cast<double>(k) / static_cast<double>(grids.size()); };
        if (const int error = fillGrid(host, grid, own, raster, part(i), part(i + 1)); error != 0) return error;
    }
    return 0;
}

int generate(const scrim_host* host, const scrim_value* values) {
    try {
        return run(host, values);
    } catch (const std::bad_alloc&) {
        host->fail(host, "not enough memory");
    } catch (const std::exception& error) {
        host->fail(host, error.what());
    } catch (...) {
        host->fail(host, "unknown exception");
    }
    return 1;
}

constexpr scrim_source kSource = {SCRIM_SOURCE_ABI,
                                  sizeof(scrim_source),
                                  "primitives",
                                  "boxes, spheres, cylinders, tori and planes with soft edges",
                                  kParameters,
                                  kCount,
                                  sizeof(scrim_parameter),
                                  generate};

}  // namespace
}  // namespace primitives

extern "C" SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v1(void) {
    return &primitives::kSource;
}
