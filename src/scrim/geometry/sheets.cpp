// SPDX-License-Identifier: Apache-2.0
#include <scrim/geometry/sheets.h>

#include <scrim/base/error.h>

#include <cstdint>
#include <limits>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {

std::size_t rasterArea(int width, int height, std::string_view what) {
    constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
    const std::size_t area = std::size_t(width) * std::size_t(height);
    if (area <= kMost) return area;
    throw Error(ErrorKind::render, fmt::format("a raster of {} x {} {} is too large; expected at most {} in all", width,
                                               height, what, kMost));
}

Vec3 Sheets::wsPoint(const Vec3& ts) const {
    return glm::transpose(ssFromWs) * (ts / tsStep() + ssOrigin) + wsAnchor;
}

Mat4 Sheets::tsFrom(const Mat4& wsFrom) const {
    Mat4 m(1.0);
    for (int column = 0; column < 3; ++column) m[column] = glm::dvec4(tsVector(Vec3(wsFrom[column])), 0.0);
    m[3] = glm::dvec4(tsPoint(Vec3(wsFrom[3])), 1.0);
    return m;
}

Mat3 sweepRotation(const Vec3& axis, const Vec3& up) {
    Vec3 u = glm::cross(up, axis);
    // An axis along `up` leaves u open. A fixed direction is chosen, so that u does not depend on rounding.
    if (glm::dot(u, u) < 1e-20 * glm::dot(up, up)) {
        u = glm::cross(Vec3(0, 0, 1), axis);
        if (glm::dot(u, u) < 1e-20) u = Vec3(1, 0, 0);
    }
    u = glm::normalize(u);
    const Vec3 v = glm::cross(axis, u);
    return glm::transpose(Mat3(u, v, axis));
}

}  // namespace scrim
