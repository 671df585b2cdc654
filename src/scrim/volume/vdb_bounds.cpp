// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_bounds.h>

#include <scrim/volume/grid_choice.h>
#include <scrim/volume/vdb_layout.h>
#include <scrim/volume/vdb_map.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {

namespace {

constexpr double kPadding = 2;  ///< voxels: the reach of the widest kernel
bool isAffine(const Mat4& m) {
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            if (!std::isfinite(m[i][j])) return false;
    return m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][3] == 1 && glm::determinant(m) != 0;
}

bool isFinite(const Bounds& b) {
    return std::isfinite(glm::length(b.lower)) && std::isfinite(glm::length(b.upper));
}

std::optional<Bounds> boundsOf(const VdbBytes& file, const VdbLayout::Grid& grid) {
    if (!grid.isLower || !grid.isUpper) return {};
    VdbWalker walk(file, grid.mapAt);
    const std::optional<Mat4> wsFromIs = readVdbMap(walk, grid.map);
    if (!wsFromIs || walk.at() > grid.end || !isAffine(*wsFromIs)) return {};
    Bounds is{Vec3(*grid.isLower), Vec3(*grid.isUpper)};
    if (is.empty()) return Bounds{};  // the form in which OpenVDB stores an empty grid
    is.lower -= kPadding;
    is.upper += kPadding;
    const Bounds ws = transformed(*wsFromIs, is);
    if (!isFinite(ws)) return {};
    return ws;
}

}  // namespace

std::optional<Bounds> vdbBounds(const std::string& path, const std::vector<GridRequest>& requests) {
    try {
        return vdbBounds(VdbBytes(path), requests);
    } catch (const Error&) {
        return {};
    }
}

std::optional<Bounds> vdbBounds(const VdbBytes& file, const std::vector<GridRequest>& requests) {
    try {
        const VdbLayout layout = checkVdbLayout(file);
        const std::vector<GridOffer> offers = offersOf(layout);
        Bounds all;
        for (const GridRequest& request : requests) {
            const auto choice = chooseGrid(offers, request);
            if (!choice || offers[choice->grid].isPoints()) return {};  // points are larger than their voxels say
            const auto bounds = boundsOf(file, layout.grids[choice->grid]);
            if (!bounds) return {};
            all.include(*bounds);
        }
        return all;
    } catch (const std::exception&) {  // this includes lack of memory
        return {};
    }
}

bool holdsPoints(const std::string& path) {
    try {
        return holdsPoints(VdbBytes(path));
    } catch (const std::exception&) {
        return false;
    }
}

bool holdsPoints(const VdbBytes& file) {
    try {
        const VdbLayout layout = checkVdbLayout(file);
        const std::vector<GridOffer> offers = offersOf(layout);
        return !layout.points.empty() ||
               std::any_of(offers.begin(), offers.end(), [](const GridOffer& offer) { return offer.isPoints(); });
    } catch (const std::exception&) {
        return false;
    }
}

}  // namespace scrim
