// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/kernel.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kGaussianRadius = 2.0;

// 1 over the integral of exp(-2 r^2) over the ball of radius 2: pi^(3/2)/2^(3/2) erf(2 sqrt 2) - 2 pi e^-8.
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

FieldProbe::FieldProbe(const SparseField& field, Kernel kernel) : m_field(field), m_kernel(kernel) {
    m_blocks.reserve(field.blockCount());
    for (std::size_t i = 0; i < field.blockCount(); ++i)
        m_blocks.emplace(key(field.blockOrigins[i] >> 3), field.block(i));
}

// 21 bits an axis: block coordinates of any 32-bit index differ where blocks within 2^20 of each other do.
std::uint64_t FieldProbe::key(const Int3& b) {
    const auto part = [](int x) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x) & 0x1fffffU); };
    return part(b.x) << 42 | part(b.y) << 21 | part(b.z);
}

const float* FieldProbe::block(const Int3& coordinate) const {
    const auto it = m_blocks.find(key(coordinate));
    return it == m_blocks.end() ? nullptr : it->second;
}

double FieldProbe::voxel(const Int3& is) const {
    if (const float* values = block(is >> 3))
        if (const float value = values[blockOffset(is.x & 7, is.y & 7, is.z & 7)]; value != 0) return value;
    for (const ConstantTile& t : m_field.tiles) {
        const Int3 d = is - t.origin;
        if (d.x >= 0 && d.y >= 0 && d.z >= 0 && d.x < t.edge && d.y < t.edge && d.z < t.edge) return t.value;
    }
    return 0;
}

double FieldProbe::value(const Vec3& is) const {
    const int reach = static_cast<int>(kernelRadius(m_kernel));
    const Int3 base(glm::floor(is));
    double sum = 0;
    for (int x = 1 - reach; x <= reach; ++x)
        for (int y = 1 - reach; y <= reach; ++y)
            for (int z = 1 - reach; z <= reach; ++z) {
                const Int3 at = base + Int3(x, y, z);
                const double weight = kernelValue(m_kernel, is - Vec3(at));
                if (weight != 0) sum += weight * voxel(at);
            }
    return sum;
}

bool FieldProbe::emptyAround(const Vec3& is, double radius) const {
    const double reach = radius + kernelRadius(m_kernel);
    const Int3 lower = Int3(glm::floor(is - reach)) >> 3, upper = Int3(glm::ceil(is + reach)) >> 3;
    for (int x = lower.x; x <= upper.x; ++x)
        for (int y = lower.y; y <= upper.y; ++y)
            for (int z = lower.z; z <= upper.z; ++z)
                if (block({x, y, z})) return false;
    for (const ConstantTile& t : m_field.tiles) {
        const Vec3 nearest = glm::clamp(is, Vec3(t.origin), Vec3(t.origin + Int3(t.edge - 1)));
        if (glm::all(glm::lessThanEqual(glm::abs(nearest - is), Vec3(reach)))) return false;
    }
    return true;
}

}  // namespace scrim
