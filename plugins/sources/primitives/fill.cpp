// SPDX-License-Identifier: Apache-2.0
#include "fill.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

namespace primitives {
namespace {

using Int3 = glm::ivec3;
using Candidates = std::vector<const Shape*>;

constexpr std::int32_t kEdge = 8;  // of a block
constexpr std::array<Int3, 8> kOctants{
    {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, {0, 1, 1}, {1, 0, 0}, {1, 0, 1}, {1, 1, 0}, {1, 1, 1}}};

class Filler {
  public:
    Filler(const scrim_host* host, int grid, const std::vector<Shape>& shapes, const Raster& raster)
        : m_host(host), m_grid(grid), m_shapes(shapes), m_raster(raster) {}

    int run(double from, double to) {
        // Finds the voxels that all shapes' boxes touch, and covers them with cubes of one size at multiples of that
        // size.
        Vec3 lower(std::numeric_limits<double>::infinity()), upper(-lower);
        Candidates all;
        for (const Shape& s : m_shapes) {
            const Vec3 reach = wsHalfExtent(s) + 0.5 * s.soft;
            lower = glm::min(lower, s.wsCentre - reach);
            upper = glm::max(upper, s.wsCentre + reach);
            all.push_back(&s);
        }
        const Int3 first = Int3(glm::floor(lower / m_raster.voxel)), last = Int3(glm::ceil(upper / m_raster.voxel));
        const Int3 extent = last - first + 1;
        std::int32_t edge = kEdge;
        while (8 * edge < std::max({extent.x, extent.y, extent.z})) edge *= 2;
        const Int3 begin = Int3(glm::floor(Vec3(first) / double(edge))),
                   end = Int3(glm::floor(Vec3(last) / double(edge)));
        for (int x = begin.x; x <= end.x; ++x) {
            for (int y = begin.y; y <= end.y; ++y)
                for (int z = begin.z; z <= end.z; ++z)
                    if (const int error = fill(Int3(x, y, z) * edge, edge, 0, all); error != 0) return error;
            const double done = double(x + 1 - begin.x) / (end.x + 1 - begin.x);
            if (const int stop = m_host->progress(m_host, from + (to - from) * done); stop != 0) return stop;
        }
        return 0;
    }

  private:
    Vec3 centre(const Int3& voxel) const { return m_raster.voxel * (Vec3(voxel) + 0.5); }

    void add(double& sum, double value) const {
        sum = m_raster.combine == Combine::max ? std::max(sum, value) : sum + value;
    }

    /// Fills one cube of the octree. `constant`: the density by shapes that contain the whole surrounding cube;
    /// `above`: the shapes whose edge may lie in the surrounding cube.
    int fill(const Int3& origin, std::int32_t edge, double constant, const Candidates& above) {
        // This ball contains all voxel centres of the cube.
        const double halfEdge = 0.5 * m_raster.voxel * (edge - 1), radius = std::sqrt(3.0) * halfEdge;
        const Vec3 middle = centre(origin) + halfEdge;
        Candidates near;
        for (const Shape* s : above) {
            const Vec3 gap = glm::abs(middle - s->wsCentre) - wsHalfExtent(*s) - (0.5 * s->soft + halfEdge);
            if (std::max({gap.x, gap.y, gap.z}) >= 0) continue;
            const double d = isExact(*s) ? distance(*s, middle) : 0, reach = radius + 0.5 * s->soft;
            if (d >= reach) continue;
            if (d <= -reach)
                add(constant, s->density);
            else
                near.push_back(s);
        }
        if (m_raster.combine == Combine::max)
            std::erase_if(near, [&](const Shape* s) { return s->density <= constant; });
        if (near.empty()) return constant > 0 ? addTile(origin, edge, constant) : 0;
        if (edge == kEdge) return fillBlock(origin, constant, near);
        for (const Int3& octant : kOctants)
            if (const int error = fill(origin + octant * (edge / 2), edge / 2, constant, near); error != 0)
                return error;
        return 0;
    }

    int fillBlock(const Int3& origin, double constant, const Candidates& near) {
        std::array<float, kEdge * kEdge * kEdge> values{};
        std::size_t i = 0;
        for (int x = 0; x < kEdge; ++x)
            for (int y = 0; y < kEdge; ++y)
                for (int z = 0; z < kEdge; ++z, ++i) {
                    const Vec3 p = centre(origin + Int3(x, y, z));
                    double value = constant;
                    for (const Shape* s : near) add(value, softDensity(*s, distance(*s, p)));
                    values[i] = static_cast<float>(value);
                }
        const auto [least, most] = std::minmax_element(values.begin(), values.end());
        if (*most <= 0) return 0;
        if (*least == *most) return addTile(origin, kEdge, *most);
        const std::int32_t at[3] = {origin.x, origin.y, origin.z};
        return m_host->add_block(m_host, m_grid, at, values.data());
    }

    int addTile(const Int3& origin, std::int32_t edge, double value) {
        const std::int32_t at[3] = {origin.x, origin.y, origin.z};
        return m_host->add_tile(m_host, m_grid, at, edge, static_cast<float>(value));
    }

    const scrim_host* m_host;
    int m_grid;
    const std::vector<Shape>& m_shapes;
    Raster m_raster;
};

}  // namespace

double softDensity(const Shape& shape, double distance) {
    return shape.density * std::clamp(0.5 - distance / shape.soft, 0.0, 1.0);
}

int fillGrid(const scrim_host* host, int grid, const std::vector<Shape>& shapes, const Raster& raster, double from,
             double to) {
    return Filler(host, grid, shapes, raster).run(from, to);
}

}  // namespace primitives
