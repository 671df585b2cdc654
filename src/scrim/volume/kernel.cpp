// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/kernel.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kGaussianRadius = 2.0;

// 1 over the integral of exp(-2 r^2) over the ball of radius 2, which is pi^(3/2)/2^(3/2) erf(2 sqrt 2) - 2 pi e^-8.
const double kGaussianScale = [] {
    constexpr double pi = std::numbers::pi;
    const double integral = std::pow(pi / 2, 1.5) * std::erf(2 * std::sqrt(2.0)) -
                            pi * kGaussianRadius * std::exp(-2 * kGaussianRadius * kGaussianRadius);
    return 1 / integral;
}();

double tent(double x) {
    return std::max(0.0, 1 - std::abs(x));
}

double cubicBspline(double x) {
    x = std::abs(x);
    if (x >= 2) return 0;
    if (x >= 1) return (2 - x) * (2 - x) * (2 - x) / 6;
    return 2.0 / 3 - x * x + x * x * x / 2;
}

}  // namespace

double kernelExtent(Kernel kernel, const Vec3& row) {
    if (kernel == Kernel::gaussian) return kGaussianRadius * glm::length(row);
    return kernelRadius(kernel) * (std::abs(row.x) + std::abs(row.y) + std::abs(row.z));
}

double kernelValue(Kernel kernel, const Vec3& o) {
    switch (kernel) {
        case Kernel::linear:
            return tent(o.x) * tent(o.y) * tent(o.z);
        case Kernel::gaussian: {
            const double r2 = glm::dot(o, o);
            return r2 < kGaussianRadius * kGaussianRadius ? kGaussianScale * std::exp(-2 * r2) : 0.0;
        }
        case Kernel::bspline:
            return cubicBspline(o.x) * cubicBspline(o.y) * cubicBspline(o.z);
    }
    return 0;
}

std::span<const double> twoScaleWeights(Kernel kernel) {
    // The weights on both sides are 1/2, 1, 1/2 (linear) and 1, 4, 6, 4, 1 eighths (cubic); the
    // table holds those from the centre outwards.
    static constexpr double kLinear[] = {1, 0.5}, kCubic[] = {6.0 / 8, 4.0 / 8, 1.0 / 8};
    if (kernel == Kernel::linear) return kLinear;
    if (kernel == Kernel::bspline) return kCubic;
    return {};
}

}  // namespace scrim
