// SPDX-License-Identifier: Apache-2.0
// The maps of openvdb/math/Maps.h, as each map's `write` stores them.
#include <scrim/volume/vdb_map.h>

namespace scrim {
namespace {

constexpr const char* kNumber = "a transform's number";
/// Vectors behind a scale that can be computed from it: the size of a voxel, and inverses.
constexpr int kDerived = 4;

Vec3 vectorAt(VdbWalker& walk) {
    const auto x = walk.number<double>(kNumber);
    const auto y = walk.number<double>(kNumber);
    const auto z = walk.number<double>(kNumber);
    return {x, y, z};
}

}  // namespace

std::optional<Mat4> readVdbMap(VdbWalker& walk, const std::string& map) {
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
        const Vec3 scale = vectorAt(walk);
        for (int i = 0; i < 3; ++i) m[i][i] = scale[i];
        walk.skip(kDerived * sizeof(Vec3), kNumber);
    }
    return m;
}

}  // namespace scrim
