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

// Interpolates between the eight voxels around `is`. Only the cubes that contain some of the eight are looked up, once
// each.
double FieldSampler::linear(const Vec3& is) const {
    const Vec3 floor = glm::floor(is), f = is - floor;
    const Int3 base(floor), cube = base >> 3;
    int across = 0;  // one bit for each axis along which the eight lie in two cubes: x is 4, z is 1
    for (int axis = 0; axis < 3; ++axis)
        if ((base[axis] & 7) == 7) across |= 4 >> axis;
    BlockIndex::Place places[8];
    places[0] = m_index.at(cube);
    if (!places[0].values) {
        const Bounds region = regionOf(places[0], cube);
        if (region.contains(is)) return places[0].constant;
    }
    double corners[8];
    if (across == 0 && places[0].values) {
        const float* const first = places[0].values + blockOffset(base.x & 7, base.y & 7, base.z & 7);
        for (int i = 0; i < 8; ++i) corners[i] = first[blockOffset(i >> 2, i >> 1 & 1, i & 1)];
    } else {
        for (int i = 0; i < 8; ++i) {
            const Int3 step(i >> 2, i >> 1 & 1, i & 1);
            if (i > 0 && (i & across) == i) places[i] = m_index.at(cube + step);
            corners[i] = places[i & across].voxel(base + step);
        }
    }
    const auto between = [](double a, double b, double t) { return a + t * (b - a); };
    return between(between(between(corners[0], corners[1], f.z), between(corners[2], corners[3], f.z), f.y),
                   between(between(corners[4], corners[5], f.z), between(corners[6], corners[7], f.z), f.y), f.x);
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

bool FieldBrick::fill(const FieldSampler& field, const Bounds& is) {
    constexpr double kMostVoxels = 1 << 15;
    if (field.kernel() != Kernel::linear) return false;
    const Vec3 lower = glm::floor(is.lower) - 1.0, size = glm::floor(is.upper) + 3.0 - lower;
    if (!(size.x * size.y * size.z <= kMostVoxels)) return false;
    m_lower = Int3(lower);
    m_size = Int3(size);
    m_values.resize(std::size_t(m_size.x * m_size.y * m_size.z));
    const Int3 last = m_lower + m_size - 1;
    for (int cx = m_lower.x >> 3; cx <= last.x >> 3; ++cx)
        for (int cy = m_lower.y >> 3; cy <= last.y >> 3; ++cy)
            for (int cz = m_lower.z >> 3; cz <= last.z >> 3; ++cz) {
                const BlockIndex::Place place = field.index().at({cx, cy, cz});
                const Int3 first = Int3(cx, cy, cz) * kBlockEdge, from = glm::max(first, m_lower),
                           to = glm::min(first + (kBlockEdge - 1), last);
                const int run = to.z - from.z + 1;
                for (int x = from.x; x <= to.x; ++x)
                    for (int y = from.y; y <= to.y; ++y) {
                        const Int3 at = Int3(x, y, from.z) - m_lower;
                        float* const out = m_values.data() + (at.x * m_size.y + at.y) * m_size.z + at.z;
                        if (place.values)
                            std::copy_n(place.values + blockOffset(x & 7, y & 7, from.z & 7), run, out);
                        else
                            std::fill_n(out, run, place.constant);
                    }
            }
    return true;
}

float FieldBrick::value(const Vec3& is) const {
    const Vec3 at = is - Vec3(m_lower);  // not negative
    const Int3 base(at);
    const float x = static_cast<float>(at.x - base.x), y = static_cast<float>(at.y - base.y),
                z = static_cast<float>(at.z - base.z);
    const float* const here = m_values.data() + (base.x * m_size.y + base.y) * m_size.z + base.z;
    const float* const next = here + m_size.y * m_size.z;
    const auto between = [](float a, float b, float t) { return a + t * (b - a); };
    const auto inPlane = [&](const float* from) {
        return between(between(from[0], from[1], z), between(from[m_size.z], from[m_size.z + 1], z), y);
    };
    return between(inPlane(here), inPlane(next), x);
}

Vec3 FieldBrick::difference(const Vec3& is) const {
    return differenceOf(*this, is);
}

}  // namespace scrim
