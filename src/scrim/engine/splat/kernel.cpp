// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/kernel.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

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

std::span<const double> twoScaleWeights(Kernel kernel) {
    // 1/2, 1, 1/2; and 1, 4, 6, 4, 1 eighths.
    static constexpr double kLinear[] = {1, 0.5}, kCubic[] = {6.0 / 8, 4.0 / 8, 1.0 / 8};
    if (kernel == Kernel::linear) return kLinear;
    if (kernel == Kernel::bspline) return kCubic;
    return {};
}

FieldProbe::FieldProbe(const SparseField& field, Kernel kernel) : m_index(field), m_kernel(kernel) {}

double FieldProbe::voxel(const Int3& is) const {
    return m_index.voxel(is);
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
    return !m_index.anyIn({is - reach, is + reach});
}

LinearProbe::LinearProbe(const SparseField& field) : m_index(std::make_shared<const BlockIndex>(field)) {}

bool LinearProbe::evenHere(const Vec3& is, double radius) const {
    const Vec3 first = double(kBlockEdge) * Vec3(m_cube), last = first + double(m_place.cubes * kBlockEdge - 1);
    return !m_place.values && glm::all(glm::greaterThanEqual(is - radius, first)) &&
           glm::all(glm::lessThanEqual(is + radius, last));
}

double LinearProbe::evenAlong(const Vec3& is, const Vec3& direction, double radius) const {
    if (placeOf(Int3(glm::floor(is))).values) return -1;
    if (!evenHere(is, radius)) {
        constexpr int kMost = 2;  // cubes along an axis, of a box that reaches into few
        const Int3 first = Int3(glm::floor(is - radius)) >> 3, last = Int3(glm::ceil(is + radius)) >> 3;
        if (glm::any(glm::greaterThan(last - first, Int3(kMost)))) return -1;
        for (int x = first.x; x <= last.x; ++x)
            for (int y = first.y; y <= last.y; ++y)
                for (int z = first.z; z <= last.z; ++z)
                    if (const BlockIndex::Place place = m_index->at({x, y, z});
                        place.values || place.constant != m_place.constant)
                        return -1;
        return 0;
    }
    const Vec3 first = double(kBlockEdge) * Vec3(m_cube), last = first + double(m_place.cubes * kBlockEdge - 1);
    double way = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis)
        if (direction[axis] != 0)
            way = std::min(
                way, ((direction[axis] > 0 ? last[axis] - radius : first[axis] + radius) - is[axis]) / direction[axis]);
    return std::max(way, 0.0);
}

double LinearProbe::value(const Vec3& is) const {
    if (evenHere(is, 0)) return m_place.constant;
    const Vec3 floor = glm::floor(is), f = is - floor;
    const Int3 base(floor);
    const bool within = (base.x & 7) < 7 && (base.y & 7) < 7 && (base.z & 7) < 7;
    if (within && placeOf(base).empty()) return 0;
    double corners[8];
    for (int i = 0; i < 8; ++i) {
        const Int3 corner = base + Int3(i >> 2, i >> 1 & 1, i & 1);
        corners[i] = (within ? m_place : placeOf(corner)).voxel(corner);
    }
    const auto between = [](double a, double b, double t) { return a + t * (b - a); };
    return between(between(between(corners[0], corners[1], f.z), between(corners[2], corners[3], f.z), f.y),
                   between(between(corners[4], corners[5], f.z), between(corners[6], corners[7], f.z), f.y), f.x);
}

const BlockIndex::Place& LinearProbe::placeOf(const Int3& is) const {
    const Int3 cube = is >> 3;
    if ((cube & ~(m_place.cubes - 1)) != m_cube) {
        m_place = m_index->at(cube);
        m_cube = cube & ~(m_place.cubes - 1);
    }
    return m_place;
}

}  // namespace scrim
