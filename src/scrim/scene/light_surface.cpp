// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/light_surface.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace scrim {
namespace {

constexpr int kRound = 96;  // edges of a circle
// Half of its error lies within the circle, and half outside.
const double kOutwards = 2 / (1 + std::cos(std::numbers::pi / kRound));

// A sheet of columns x rows squares. `at` maps (i, j) to a corner; columns run to the right and
// rows upwards for those whom the sheet shines at.
TriangleMesh sheetOf(int columns, int rows, const std::function<Vec3(int, int)>& at) {
    TriangleMesh mesh;
    const auto width = static_cast<std::uint32_t>(columns + 1);
    for (int j = 0; j <= rows; ++j)
        for (int i = 0; i <= columns; ++i) mesh.points.push_back(at(i, j));
    for (std::uint32_t j = 0; j < std::uint32_t(rows); ++j)
        for (std::uint32_t i = 0; i < std::uint32_t(columns); ++i) {
            const std::uint32_t corner = j * width + i;
            mesh.triangles.push_back({corner, corner + 1, corner + width + 1});
            mesh.triangles.push_back({corner, corner + width + 1, corner + width});
        }
    return mesh;
}

Vec2 onCircle(double i) {
    const double angle = 2 * std::numbers::pi * i / kRound;
    return {std::cos(angle), std::sin(angle)};
}

}  // namespace

TriangleMesh surfaceOf(const Light& light) {
    const Light::Area& area = *light.area();
    const Mat3 frame = lightFrame(light);  // right for whom it shines at, up, and the normal
    const auto ws = [&](const Vec3& at) { return light.wsPosition + frame * at; };
    const double radius = area.radius * kOutwards;
    switch (area.shape) {
        case AreaShape::rectangle:
            return sheetOf(1, 1, [&](int i, int j) {
                return ws({(i - 0.5) * area.width, (j - 0.5) * area.height, 0});
            });
        case AreaShape::disk:
            return sheetOf(kRound, 1, [&](int i, int j) { return ws(Vec3((1 - j) * radius * onCircle(i), 0)); });
        case AreaShape::cylinder:
            return sheetOf(kRound, 1, [&](int i, int j) {
                return ws({(j - 0.5) * area.width, radius * onCircle(i).x, radius * onCircle(i).y});
            });
        case AreaShape::sphere:
            return sheetOf(kRound, kRound / 2, [&](int i, int j) {
                const Vec2 upright = onCircle(j - kRound / 4.0);
                return light.wsPosition +
                       radius * Vec3(upright.x * onCircle(i).x, upright.y, -upright.x * onCircle(i).y);
            });
        case AreaShape::mesh:
            break;
    }
    return *area.surface;
}

}  // namespace scrim
