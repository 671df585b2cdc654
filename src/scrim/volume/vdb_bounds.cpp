// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_bounds.h>

#include <scrim/volume/grid_choice.h>
#include <scrim/volume/vdb_layout.h>

#include <cmath>
#include <exception>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {

namespace {

constexpr double kPadding = 2;  ///< voxels: the reach of the widest kernel
constexpr const char* kNumber = "a transform's number";

Vec3 vectorAt(VdbWalker& walk) {
    const auto x = walk.number<double>(kNumber);
    const auto y = walk.number<double>(kNumber);
    const auto z = walk.number<double>(kNumber);
    return {x, y, z};
}

/// Reads the transform of an OpenVDB map (openvdb/math/Maps.h, each map's `write`); no value where it is not affine.
std::optional<Mat4> readMap(VdbWalker& walk, const std::string& map) {
    Mat4 m(1.0);
    if (map == "AffineMap" || map == "UnitaryMap") {
        // Row by row; OpenVDB multiplies rows from the left, so its row i is GLM's column i.
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) m[i][j] = walk.number<double>(kNumber);
        return m;
    }
    const bool scales = map == "ScaleMap" || map == "UniformScaleMap";
    const bool translates = map == "TranslationMap";
    const bool both = map == "ScaleTranslateMap" || map == "UniformScaleTranslateMap";
    if (!scales && !translates && !both) return {};
    if (translates || both) m[3] = glm::dvec4(vectorAt(walk), 1.0);
    if (scales || both) {
        // The numbers that follow can be computed from the scale.
        const Vec3 scale = vectorAt(walk);
        for (int i = 0; i < 3; ++i) m[i][i] = scale[i];
    }
    return m;
}

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
    const std::optional<Mat4> wsFromIs = readMap(walk, grid.map);
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

}  // namespace scrim
