// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/lamps/lamp.h>

#include <scrim/geometry/spaces.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace scrim {

bool hollowOnCells(const Light& lamp, double edge) {
    return radiusOfSphere(lamp) > edge;
}

double nearestFar(const Light& lamp, double edge) {
    return 12 * edge + 3 * radiusOfSphere(lamp);
}

CellGrid blocksOf(const CellGrid& all, const Vec3& wsCorner, const std::function<bool(const Vec3&)>& wants) {
    std::vector<Bounds> boxes;
    for (const Int3& block : all.storedBlocks()) {
        const Vec3 center = all.wsFromCs(Vec3(block * kCellEdge) + 0.5 * kCellEdge);
        if (wants(center)) boxes.push_back({center - all.edge(), center + all.edge()});
    }
    return CellGrid(all.edge(), boxes, wsCorner);
}

std::shared_ptr<const CellGrid> cellsNear(const Light& lamp, const CellGrid& all, const Vec3& wsCorner) {
    const double reach = nearestFar(lamp, all.edge()) + all.edge(), half = 0.5 * kCellEdge * all.edge();
    return std::make_shared<const CellGrid>(blocksOf(all, wsCorner, [&](const Vec3& wsCenter) {
        const Vec3 beside = glm::max(glm::abs(lamp.wsPosition - wsCenter) - half, Vec3(0));
        return glm::dot(beside, beside) <= reach * reach;
    }));
}

double wayFrom(const Light& lamp, double r) {
    const double radius = radiusOfSphere(lamp);
    if (radius == 0) return r;
    if (r <= radius) return 0;
    if (r > 2 * radius) return r - radius * (2.0 / 3 + 0.25 * radius / r);  // to 1e-3 radii
    const double h = std::sqrt(r * r - radius * radius);
    return 0.5 * (radius * radius - r * radius + h * h * std::log((r + radius) / h)) / (r - h);
}

Rgb depthFromSphere(const MediaTogether& media, double extinction, const Vec3& wsCenter, double radius,
                    const Vec3& ws) {
    constexpr int kAround = 6;
    const double r = glm::distance(ws, wsCenter), least = std::sqrt(std::max(1 - radius * radius / (r * r), 0.0));
    const Mat3 frame = frameAround((wsCenter - ws) / r);
    Rgb sum(0);
    double turn = 0;
    for (const auto& [node, weight] : kFourPoints) {
        const double mu = least + node * (1 - least), across = std::sqrt(1 - mu * mu);
        const double way = r * mu - std::sqrt(std::max(r * r * (mu * mu - least * least), 0.0));
        turn += 0.4;  // so that rays of two rings are not above one another
        for (int i = 0; i < kAround; ++i) {
            const double angle = turn + 2 * std::numbers::pi * i / kAround;
            const Vec3 direction = frame * Vec3(across * std::cos(angle), across * std::sin(angle), mu);
            sum += weight / kAround *
                   glm::exp(-extinction * opticalDepth(media, ws, direction, way, kMostDepth / extinction));
        }
    }
    return -glm::log(glm::max(sum, Rgb(1e-30)));
}

double shellOverDisk(double depth) {
    const double a = std::clamp(depth, 0.0, 20.0);  // denser, the medium shows nothing one radius away
    double shell = 0;
    for (const auto& [c, weight] : kFourPoints) shell += weight * std::exp(a * std::sqrt(0.25 + 0.75 * c * c));
    const double disk = a < 1e-2 ? 1 + a * (2.0 / 3 + a / 4) : 2 * (std::exp(a) * (a - 1) + 1) / (a * a);
    return std::log(shell / disk);
}

}  // namespace scrim
