// SPDX-License-Identifier: Apache-2.0
// Reads a transform, which maps the asset's own world to the scene's. `scale` is applied first, then `rotate` (about x,
// then y, then z of the world, right-handed), then `translate`. A `matrix` is written row by row and acts on column
// vectors: the last column is the translation, and the last row is 0, 0, 0, 1.
#include <scrim/scene/read_sections.h>

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

/// Cosine and sine of an angle in degrees, exact at right angles.
Vec2 cosineAndSine(double degrees) {
    const double turns = std::remainder(degrees, 360.0);
    if (turns == 0) return {1, 0};
    if (turns == 90 || turns == -90) return {0, turns > 0 ? 1 : -1};
    if (turns == 180 || turns == -180) return {-1, 0};
    const double radians = glm::radians(turns);
    return {std::cos(radians), std::sin(radians)};
}

/// A right-handed rotation about one axis.
Mat3 rotation(int axis, double degrees) {
    const Vec2 cs = cosineAndSine(degrees);
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    Mat3 m(1.0);
    m[a][a] = m[b][b] = cs.x;
    m[a][b] = cs.y;
    m[b][a] = -cs.y;
    return m;
}

}  // namespace

bool isInvertible(const Mat4& m) {
    double volume = 1;
    Mat3 shape(1.0);
    for (int i = 0; i < 3; ++i) {
        const Vec3 column(m[i]);
        const double length = glm::length(column);
        if (!(length > 0)) return false;
        shape[i] = column / length;
        volume *= length;
    }
    const double determinant = glm::dot(shape[0], glm::cross(shape[1], shape[2]));
    return std::isfinite(volume) && volume > 0 && std::abs(determinant) > 1e-9;
}

Mat4 readMatrix(const TomlValue& value) {
    Mat4 m(1.0);
    const auto rows = value.items(4);
    for (int row = 0; row < 4; ++row) {
        const auto numbers = rows[row].items(4);
        for (int column = 0; column < 4; ++column) m[column][row] = numbers[column].number();
    }
    if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1)
        rows[3].fail(
            fmt::format("the last row of '{}' is not 0, 0, 0, 1; expected an affine matrix that acts on column "
                        "vectors, with the translation in its last column",
                        value.name()));
    if (!isInvertible(m)) value.fail(fmt::format("'{}' is singular; expected an invertible matrix", value.name()));
    return m;
}

Mat4 readTransform(TomlTable table, const ReadContext& context) {
    const TransformKeys& k = keysOf<TransformKeys>();
    if (const auto matrix = table.find(k.matrix)) {
        table.describe(table.description() + " with a matrix");
        table.finish();
        return readMatrix(*matrix);
    }
    const auto translate = table.find(k.translate), rotate = table.find(k.rotate), scale = table.find(k.scale);
    Mat3 linear(1.0);
    if (scale) {
        const Vec3 factors = scale->scaleAt(context.frame);
        for (int i = 0; i < 3; ++i) linear[i][i] = factors[i];
    }
    if (rotate) {
        const Vec3 angles = rotate->vec3At(context.frame);
        for (int axis = 0; axis < 3; ++axis) linear = rotation(axis, angles[axis]) * linear;
    }
    Mat4 m(linear);
    if (translate) m[3] = glm::dvec4(translate->vec3At(context.frame), 1.0);
    table.finish();
    return m;
}

}  // namespace scrim
