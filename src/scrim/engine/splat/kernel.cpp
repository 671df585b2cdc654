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

namespace {

// 21 bits an axis: block coordinates of any 32-bit index differ where blocks within 2^20 of each other do.
std::uint64_t blockKey(const Int3& b) {
    const auto part = [](int x) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x) & 0x1fffffU); };
    return part(b.x) << 42 | part(b.y) << 21 | part(b.z);
}

}  // namespace

FieldProbe::FieldProbe(const SparseField& field, Kernel kernel) : m_field(field), m_kernel(kernel) {
    m_blocks.reserve(field.blockCount());
    for (std::size_t i = 0; i < field.blockCount(); ++i)
        m_blocks.emplace(blockKey(field.blockOrigins[i] >> 3), field.block(i));
}

const float* FieldProbe::block(const Int3& coordinate) const {
    const auto it = m_blocks.find(blockKey(coordinate));
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

LinearProbe::LinearProbe(const SparseField& field) : m_field(&field) {
    auto blocks = std::make_shared<Blocks>();
    blocks->reserve(field.blockCount());
    for (std::size_t b = 0; b < field.blockCount(); ++b)
        blocks->emplace(blockKey(field.blockOrigins[b] >> 3), field.block(b));
    m_blocks = std::move(blocks);
}

double LinearProbe::value(const Vec3& is) const {
    const Vec3 base = glm::floor(is), f = is - base;
    const int x = static_cast<int>(base.x), y = static_cast<int>(base.y), z = static_cast<int>(base.z);
    const bool within = (x & 7) < 7 && (y & 7) < 7 && (z & 7) < 7;
    const float* block = within ? blockAt(x, y, z) : nullptr;
    if (within && !block && m_constant == 0) return 0;
    double corners[8];
    for (int i = 0; i < 8; ++i) {
        const int cx = x + (i >> 2), cy = y + (i >> 1 & 1), cz = z + (i & 1);
        corners[i] = block ? block[blockOffset(cx & 7, cy & 7, cz & 7)] : voxel(cx, cy, cz);
    }
    const auto between = [](double a, double b, double t) { return a + t * (b - a); };
    return between(between(between(corners[0], corners[1], f.z), between(corners[2], corners[3], f.z), f.y),
                   between(between(corners[4], corners[5], f.z), between(corners[6], corners[7], f.z), f.y), f.x);
}

// What there is none of may be part of a tile, which is made of whole blocks.
const float* LinearProbe::blockAt(int x, int y, int z) const {
    const std::uint64_t key = blockKey(Int3(x, y, z) >> 3);
    if (key == m_key) return m_block;
    m_key = key;
    const auto found = m_blocks->find(key);
    m_block = found == m_blocks->end() ? nullptr : found->second;
    m_constant = 0;
    for (const ConstantTile& tile : m_field->tiles) {
        const Int3 d = Int3(x, y, z) - tile.origin;
        if (!m_block && d.x >= 0 && d.y >= 0 && d.z >= 0 && d.x < tile.edge && d.y < tile.edge && d.z < tile.edge)
            m_constant = tile.value;
    }
    return m_block;
}

double LinearProbe::voxel(int x, int y, int z) const {
    if (const float* block = blockAt(x, y, z)) return block[blockOffset(x & 7, y & 7, z & 7)];
    return m_constant;
}

}  // namespace scrim
