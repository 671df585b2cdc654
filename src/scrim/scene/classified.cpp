// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/classified.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim {

ClassifiedValue classify(const Classified& classified, double value) {
    const std::vector<TransferPoint>& points = classified.transfer;
    const auto scaled = [&](const Rgb& color, double extinction) {
        return ClassifiedValue{color, extinction * classified.densityScale};
    };
    if (value <= points.front().value) return scaled(points.front().color, points.front().extinction);
    for (std::size_t i = 1; i < points.size(); ++i) {
        const TransferPoint &a = points[i - 1], &b = points[i];
        if (value > b.value) continue;
        const double t = (value - a.value) / (b.value - a.value);
        return scaled(a.color + t * (b.color - a.color), a.extinction + t * (b.extinction - a.extinction));
    }
    return scaled(points.back().color, points.back().extinction);
}

double vagueGradient(const Classified& classified, double voxel) {
    constexpr double kVague = 1e-2;  // change over a voxel, relative to the transfer function's last value
    return kVague * classified.transfer.back().value / voxel;
}

double normalWeight(const Classified& classified, double gradientLength, double voxel) {
    const double vague = vagueGradient(classified, voxel);
    const double g2 = gradientLength * gradientLength;
    return g2 / (g2 + vague * vague);
}

Reflected phong(const Classified& classified, const Vec3& normal, double normalWeight, const Vec3& toLight,
                const Vec3& toEye) {
    const double cosine = glm::dot(normal, toLight);
    const double facing = classified.twoSided ? std::abs(cosine) : std::max(cosine, 0.0);
    const Vec3 mirrored = 2 * cosine * normal - toLight;
    const double shine = facing > 0 ? std::pow(std::max(glm::dot(toEye, mirrored), 0.0), classified.exponent) : 0.0;
    return {classified.diffuse * (normalWeight * facing + 1 - normalWeight),
            classified.specular * normalWeight * shine};
}

}  // namespace scrim
