// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/field_sampler.h>

#include <algorithm>
#include <limits>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

namespace scrim {
namespace {

// First and last voxel of the region of equal cubes (Place::cubes) around `cube`, where `place` was found.
Bounds regionOf(const BlockIndex::Place& place, const Int3& cube) {
    const Vec3 first = double(kBlockEdge) * Vec3(cube & ~(place.cubes - 1));
    return {first, first + double(place.cubes * kBlockEdge - 1)};
}

template <class Field>
Vec3 differenceOf(const Field& field, const Vec3& is) {
    const Vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    return {field.value(is + x) - field.value(is - x), field.value(is + y) - field.value(is - y),
            field.value(is + z) - field.value(is - z)};
}

}  // namespace

FieldSampler::FieldSampler(const SparseField& field, Kernel kernel)
    : m_index(field), m_kernel(kernel), m_reached(m_index.isBounds()) {
    m_reached.lower -= kernelRadius(kernel);
    m_reached.upper += kernelRadius(kernel);
}

double FieldSampler::nearest(const Vec3& is) const {
    if (!m_reached.contains(is)) return 0;  // such a point may be so far away that it does not fit an integer
    return m_index.voxel(Int3(glm::floor(is + 0.5)));
}

double FieldSampler::value(const Vec3& is) const {
    if (!m_reached.contains(is)) return 0;
    if (m_kernel == Kernel::linear) return linear(is);
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

Vec3 FieldSampler::difference(const Vec3& is) const {
    return differenceOf(*this, is);
}

// Interpolates between the eight voxels around `is`. Only the cubes that contain some of the eight
// are looked up, once each.
double FieldSampler::linear(const Vec3& is) const {
    const Int3 base = wholeBelow(is), cube = base >> 3, inside = base & 7;
    const BlockIndex::Place first = m_index.at(cube);
    if (!first.values && regionOf(first, cube).contains(is)) return first.constant;
    const bool within = inside.x < 7 && inside.y < 7 && inside.z < 7;
    if (!within || !first.values) return linearAcross(is, first);
    return trilinear(first.values + blockOffset(inside.x, inside.y, inside.z), blockOffset(1, 0, 0),
                     blockOffset(0, 1, 0), is - Vec3(base));
}

// The same where they may lie in several cubes, of which `first` is the first one.
double FieldSampler::linearAcross(const Vec3& is, const BlockIndex::Place& first) const {
    const Int3 base = wholeBelow(is), cube = base >> 3;
    int across = 0;  // one bit for each axis along which the eight lie in two cubes: x is 4, z is 1
    for (int axis = 0; axis < 3; ++axis)
        if ((base[axis] & 7) == 7) across |= 4 >> axis;
    BlockIndex::Place places[8];
    places[0] = first;
    float corners[8];
    for (int i = 0; i < 8; ++i) {
        const Int3 step(i >> 2, i >> 1 & 1, i & 1);
        if (i > 0 && (i & across) == i) places[i] = m_index.at(cube + step);
        corners[i] = static_cast<float>(places[i & across].voxel(base + step));
    }
    return trilinear(corners, 4, 2, is - Vec3(base));
}

bool FieldSampler::emptyAround(const Vec3& is, double radius) const {
    const double reach = radius + kernelRadius(m_kernel);
    return !m_index.anyIn({is - reach, is + reach});
}

double FieldSampler::evenAlong(const Vec3& is, const Vec3& direction, double radius) const {
    const Int3 cube = Int3(glm::floor(is)) >> 3;
    const BlockIndex::Place here = m_index.at(cube);
    if (here.values) return -1;
    const Bounds region = regionOf(here, cube);
    if (!region.contains(is - radius) || !region.contains(is + radius)) {
        constexpr int kMost = 2;  // a box of at most this many cubes along an axis is examined cube by cube
        const Int3 first = Int3(glm::floor(is - radius)) >> 3, last = Int3(glm::ceil(is + radius)) >> 3;
        if (glm::any(glm::greaterThan(last - first, Int3(kMost)))) return -1;
        for (int x = first.x; x <= last.x; ++x)
            for (int y = first.y; y <= last.y; ++y)
                for (int z = first.z; z <= last.z; ++z)
                    if (const BlockIndex::Place place = m_index.at({x, y, z});
                        place.values || place.constant != here.constant)
                        return -1;
        return 0;
    }
    double way = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis)
        if (direction[axis] != 0)
            way = std::min(
                way, ((direction[axis] > 0 ? region.upper[axis] - radius : region.lower[axis] + radius) - is[axis]) /
                         direction[axis]);
    return std::max(way, 0.0);
}

void FieldBrick::fill(const BlockIndex& index, const Int3& lower, const Int3& upper) {
    m_lower = lower;
    m_size = upper - lower + 1;
    m_values.resize(std::size_t(m_size.x) * std::size_t(m_size.y) * std::size_t(m_size.z));
    const Int3 first = lower >> 3, last = upper >> 3;
    for (int x = first.x; x <= last.x; ++x)
        for (int y = first.y; y <= last.y; ++y)
            for (int z = first.z; z <= last.z; ++z) copy(index.at({x, y, z}), {x, y, z});
}

bool FieldBrick::fill(const FieldSampler& field, const Bounds& is) {
    constexpr double kMostVoxels = 1 << 15;
    if (field.kernel() != Kernel::linear) return false;
    const Vec3 lower = glm::floor(is.lower), upper = glm::floor(is.upper) + 1.0, size = upper - lower + 1.0;
    if (!(size.x * size.y * size.z <= kMostVoxels)) return false;
    fill(field.index(), Int3(lower), Int3(upper));
    return true;
}

void FieldBrick::copy(const BlockIndex::Place& place, const Int3& cube) {
    const Int3 origin = cube * kBlockEdge;
    const Int3 from = glm::max(origin, m_lower), to = glm::min(origin + kBlockEdge, m_lower + m_size);
    for (int x = from.x; x < to.x; ++x)
        for (int y = from.y; y < to.y; ++y) {
            float* row = m_values.data() + offset({x, y, from.z});
            if (place.values)
                std::copy_n(place.values + blockOffset(x & 7, y & 7, from.z & 7), to.z - from.z, row);
            else
                std::fill_n(row, to.z - from.z, place.constant);
        }
}

Vec3 FieldBrick::difference(const Vec3& is) const {
    return differenceOf(*this, is);
}

void FieldBrick::values(const std::array<const float*, 3>& from, int count, float* values) const {
    const std::ptrdiff_t y = m_size.z, x = std::ptrdiff_t(m_size.y) * m_size.z;
    const auto between = [](float a, float b, float t) { return a + t * (b - a); };
    for (int i = 0; i < count; ++i) {
        const int base[3] = {static_cast<int>(from[0][i]), static_cast<int>(from[1][i]), static_cast<int>(from[2][i])};
        float f[3];
        for (int axis = 0; axis < 3; ++axis) f[axis] = from[std::size_t(axis)][i] - static_cast<float>(base[axis]);
        const float* at = m_values.data() + base[0] * x + base[1] * y + base[2];
        const auto along = [&](const float* p) { return between(p[0], p[1], f[2]); };
        const auto across = [&](const float* p) { return between(along(p), along(p + y), f[1]); };
        values[i] = between(across(at), across(at + x), f[0]);
    }
}

void FieldBrick::addBlock(const Vec3& f, float sign, float* values) const {
    constexpr int kEdge = kBlockEdge, kWide = kBlockEdge + 1;
    const auto fx = static_cast<float>(f.x), fy = static_cast<float>(f.y), fz = static_cast<float>(f.z);
    float along[kWide * kWide * kEdge], across[kWide * kEdge * kEdge];
    for (int row = 0; row < kWide * kWide; ++row) {
        const float* from = m_values.data() + row * kWide;
        for (int z = 0; z < kEdge; ++z) along[row * kEdge + z] = from[z] + fz * (from[z + 1] - from[z]);
    }
    for (int x = 0; x < kWide; ++x) {
        const float* from = along + x * kWide * kEdge;
        for (int i = 0; i < kEdge * kEdge; ++i)
            across[x * kEdge * kEdge + i] = from[i] + fy * (from[i + kEdge] - from[i]);
    }
    for (int i = 0; i < kBlockVoxels; ++i)
        values[i] += sign * (across[i] + fx * (across[i + kEdge * kEdge] - across[i]));
}

}  // namespace scrim
