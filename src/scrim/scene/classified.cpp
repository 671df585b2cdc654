// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/classified.h>

#include <scrim/scene/ramp.h>

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

double mostScattered(const Classified& classified) {
    double most = 0;
    for (const TransferPoint& point : classified.transfer)
        for (int c = 0; c < 3; ++c) most = std::max(most, classified.albedo[c] * point.color[c]);
    return most;
}

bool scattersGrey(const Classified& classified) {
    return std::ranges::all_of(classified.transfer, [&](const TransferPoint& point) {
        const Rgb part = classified.albedo * point.color;
        return part.x == part.y && part.y == part.z;
    });
}

double mostExtinction(const Classified& classified, double value) {
    double most = classify(classified, value).extinction;
    for (const TransferPoint& point : classified.transfer)
        if (point.value <= value) most = std::max(most, point.extinction * classified.densityScale);
    return most;
}

double gradientFactor(const Classified& classified, double gradientLength) {
    return classified.gradientRamp.empty() ? 1 : ramped(classified.gradientRamp, gradientLength);
}

std::vector<TransferPoint> transferOf(ScanWindow window, double zero) {
    std::vector<TransferPoint> points;
    switch (window) {
        case ScanWindow::bone:
            points = {{200, {0.85, 0.68, 0.52}, 0},
                      {300, {0.88, 0.74, 0.6}, 0.6},
                      {450, {0.95, 0.88, 0.76}, 1.2},
                      {1500, {1, 0.97, 0.92}, 2}};
            break;
        case ScanWindow::softTissue:  // centre 40, width 400
            points = {{-160, {0.85, 0.62, 0.4}, 0},
                      {-60, {0.88, 0.66, 0.46}, 0.3},
                      {40, {0.75, 0.34, 0.26}, 0.9},
                      {240, {0.95, 0.86, 0.76}, 1.5}};
            break;
        case ScanWindow::lung:  // air in the airways is below it, and the body above it
            points = {{-920, {0.7, 0.82, 0.95}, 0},   {-850, {0.7, 0.82, 0.95}, 0.03}, {-600, {0.85, 0.72, 0.75}, 0.06},
                      {-450, {0.9, 0.5, 0.45}, 0.15}, {-300, {0.9, 0.42, 0.36}, 0.15}, {-200, {0.9, 0.42, 0.36}, 0}};
            break;
        case ScanWindow::vessels:
            points = {{100, {0.6, 0.05, 0.04}, 0},
                      {170, {0.7, 0.08, 0.06}, 0.6},
                      {300, {0.85, 0.16, 0.1}, 1.2},
                      {450, {0.95, 0.88, 0.76}, 1.2},
                      {1500, {1, 0.97, 0.92}, 2}};
            break;
    }
    for (TransferPoint& point : points) point.value += zero;
    return points;
}

std::vector<TransferPoint> transferOf(double centre, double width, double zero) {
    constexpr double kOpaque = 1.2;  // optical depth of a voxel at the window's end
    const double begin = centre - 0.5 * width + zero, end = centre + 0.5 * width + zero;
    if (begin >= 0) return {{begin, Rgb(0), 0}, {end, Rgb(1), kOpaque}};
    const double part = -begin / width;
    return {{0, Rgb(part), 0}, {0, Rgb(part), part * kOpaque}, {end, Rgb(1), kOpaque}};
}

double cutGradient(const Classified& classified, double voxel) {
    return classified.transfer.back().value / voxel;
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
