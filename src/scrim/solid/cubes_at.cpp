// SPDX-License-Identifier: Apache-2.0
#include <scrim/solid/cubes_at.h>

#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {

void forCubesAt(const Solids& solids, double edge, const Vec3& wsCorner, double reach,
                const std::function<std::pair<Int3, Int3>(const Solid&)>& range,
                const std::function<void(const Int3&)>& visit) {
    for (const Solid& solid : solids.all()) {
        if (!solid.has(SolidRole::shadow)) continue;
        const auto [least, most] = range(solid);
        for (const auto& triangle : solid.mesh->triangles) {
            std::array<Vec3, 3> corner;
            Bounds box;
            for (std::size_t i = 0; i < 3; ++i) {
                corner[i] = (transformPoint(solid.wsFromMesh, solid.mesh->points[triangle[i]]) - wsCorner) / edge;
                box.include(corner[i]);
            }
            const Vec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
            const double slack = (0.5 + reach / edge) * (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z));
            const Int3 first = glm::max(Int3(glm::floor(glm::clamp(box.lower - reach / edge, -1e9, 1e9))), least);
            const Int3 last = glm::min(Int3(glm::floor(glm::clamp(box.upper + reach / edge, -1e9, 1e9))), most);
            for (int z = first.z; z <= last.z; ++z)
                for (int y = first.y; y <= last.y; ++y)
                    for (int x = first.x; x <= last.x; ++x)
                        if (std::abs(glm::dot(normal, Vec3(x, y, z) + 0.5 - corner[0])) <= slack) visit(Int3(x, y, z));
        }
    }
}

}  // namespace scrim
