// SPDX-License-Identifier: Apache-2.0
// Turns triangles into fog. OpenVDB's mesh tools compute the distance to the surface in a narrow band, with a sign
// where surfaces are closed; a linear ramp turns distance into density, as in the source `primitives`.
#include "mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>

namespace mesh {
namespace {

constexpr double kMostVoxels = 16384;    // along an axis
constexpr double kFarthest = 1 << 28;    // from the origin, in voxels
constexpr double kRounding = 1e-4;       // rounding of distances in single precision, as a fraction of the ramp
constexpr double kCrowded = 4;           // ratio of the triangles' area to the surface of their box
constexpr double kMostBand = 536870912;  // voxels near surfaces: 2 GB of distances

using Vec3 = openvdb::Vec3d;

/// Assigns one number to all points at the same position.
std::vector<std::uint32_t> placesOf(const std::vector<Point>& points) {
    std::vector<std::uint32_t> order(points.size()), places(points.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return points[a] < points[b]; });
    for (std::size_t i = 0; i < order.size(); ++i)
        places[order[i]] = i > 0 && points[order[i]] == points[order[i - 1]] ? places[order[i - 1]] : order[i];
    return places;
}

/// The mesh without triangles that have the same corners as another one. Duplicates change no distance, and each costs
/// as much as the first.
Mesh withoutDoubles(const Mesh& mesh) {
    using Triangle = std::array<std::uint32_t, 3>;
    const std::vector<std::uint32_t> places = placesOf(mesh.points);
    std::vector<std::pair<Triangle, std::uint32_t>> keys;
    keys.reserve(mesh.triangles.size());
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        Triangle corners = mesh.triangles[i];
        for (std::uint32_t& corner : corners) corner = places[corner];
        std::sort(corners.begin(), corners.end());
        keys.emplace_back(corners, i);
    }
    std::sort(keys.begin(), keys.end());
    const auto end =
        std::unique(keys.begin(), keys.end(), [](const auto& a, const auto& b) { return a.first == b.first; });
    std::vector<std::uint32_t> kept;
    for (auto key = keys.begin(); key != end; ++key) kept.push_back(key->second);
    std::sort(kept.begin(), kept.end());
    Mesh out{mesh.points, {}};
    for (const std::uint32_t i : kept) out.triangles.push_back(mesh.triangles[i]);
    return out;
}

/// The interface that OpenVDB's tool needs of a mesh.
class Adapter {
  public:
    Adapter(const Mesh& mesh, double voxel) : m_mesh(mesh), m_voxel(voxel) {}

    std::size_t polygonCount() const { return m_mesh.triangles.size(); }
    std::size_t pointCount() const { return m_mesh.points.size(); }
    std::size_t vertexCount(std::size_t) const { return 3; }
    void getIndexSpacePoint(std::size_t triangle, std::size_t corner, Vec3& is) const { is = point(triangle, corner); }

    Vec3 point(std::size_t triangle, std::size_t corner) const {
        const Point& p = m_mesh.points[m_mesh.triangles[triangle][corner]];
        return {p[0] / m_voxel - 0.5, p[1] / m_voxel - 0.5, p[2] / m_voxel - 0.5};
    }

  private:
    const Mesh& m_mesh;
    double m_voxel;
};

/// Refuses meshes that would be too large, judged by the triangles' extent and area. Returns the ratio of the
/// triangles' area to that of the faces of the box around them.
double checkSize(const Adapter& mesh, double halfBand) {
    Vec3 lower(std::numeric_limits<double>::infinity()), upper(-lower);
    double area = 0;
    for (std::size_t i = 0; i < mesh.polygonCount(); ++i) {
        const Vec3 a = mesh.point(i, 0), b = mesh.point(i, 1), c = mesh.point(i, 2);
        for (const Vec3& p : {a, b, c}) {
            lower = openvdb::math::minComponent(lower, p);
            upper = openvdb::math::maxComponent(upper, p);
        }
        area += 0.5 * (b - a).cross(c - a).length();
    }
    const Vec3 extent = upper - lower + Vec3(2 * halfBand);
    const double longest = std::max({extent.x(), extent.y(), extent.z()});
    if (!(longest <= kMostVoxels))
        throw std::runtime_error(fmt::format(
            "the mesh extends over {:.6g} voxels, expected at most {}: choose a larger 'voxel'", longest, kMostVoxels));
    const double farthest = std::max(lower.length(), upper.length());
    if (!(farthest <= kFarthest))
        throw std::runtime_error(
            fmt::format("the mesh lies {:.6g} voxels from the origin, expected at most {}", farthest, kFarthest));
    const double band = std::min(2 * halfBand * area, extent.x() * extent.y() * extent.z());
    if (!(band <= kMostBand))
        throw std::runtime_error(
            fmt::format("about {:.3g} voxels lie near the surface, expected at most {:.3g}: choose a larger 'voxel' or "
                        "a smaller 'soft'",
                        band, kMostBand));
    return area / (2 * (extent.x() * extent.y() + extent.y() * extent.z() + extent.z() * extent.x()));
}

class Emitter {
  public:
    Emitter(const scrim_host* host, int grid, const Fog& fog) : m_host(host), m_grid(grid), m_fog(fog) {}

    /// True if any voxel was on the inner side of the surface.
    bool anyInside() const { return m_anyInside; }

    int leaves(const openvdb::FloatTree& tree) {
        for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
            float values[512];
            bool any = false;
            for (openvdb::Index i = 0; i < 512; ++i) {
                values[i] = value(leaf->getValue(i));
                any = any || values[i] > 0;
            }
            if (!any) continue;
            const bool constant = std::all_of(values, values + 512, [&](float v) { return v == values[0]; });
            const openvdb::Coord& o = leaf->origin();
            const std::int32_t origin[3] = {o.x(), o.y(), o.z()};
            if (const int error = constant ? m_host->add_tile(m_host, m_grid, origin, 8, values[0])
                                           : m_host->add_block(m_host, m_grid, origin, values);
                error != 0)
                return error;
        }
        return 0;
    }

    /// Emits cubes of constant distance beyond the band; only those inside of the surface matter.
    int tiles(const openvdb::FloatTree& tree) {
        auto tile = tree.cbeginValueAll();
        tile.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
        for (; tile; ++tile) {
            const float v = value(*tile);
            if (v <= 0) continue;
            const openvdb::CoordBBox box = tile.getBoundingBox();
            const std::int32_t origin[3] = {box.min().x(), box.min().y(), box.min().z()};
            if (const int error = m_host->add_tile(m_host, m_grid, origin, box.dim().x(), v); error != 0) return error;
        }
        return 0;
    }

  private:
    float value(float distance) {
        const double d = distance;
        m_anyInside = m_anyInside || d < 0;
        const double part = m_fog.fill ? 0.5 - d / m_fog.soft : 1 - std::abs(d) / m_fog.soft;
        if (part < kRounding) return 0;
        return static_cast<float>(m_fog.density * std::min(part, 1.0));
    }

    const scrim_host* m_host;
    int m_grid;
    Fog m_fog;
    bool m_anyInside = false;
};

}  // namespace

int emitFog(const scrim_host* host, const Mesh& mesh, const Fog& fog) {
    // Distances are cut off beyond the band, so the band must be at least as wide as the ramp.
    const double halfBand = (fog.fill ? 0.5 : 1.0) * fog.soft / fog.voxel + 1;
    // That much surface in so little space usually contains duplicates; they are searched only then.
    const bool crowded = checkSize(Adapter(mesh, fog.voxel), halfBand) > kCrowded;
    const Mesh distinct = crowded ? withoutDoubles(mesh) : Mesh();
    const Adapter adapter(crowded ? distinct : mesh, fog.voxel);

    const double shift = 0.5 * fog.voxel, v = fog.voxel;
    const double worldFromIndex[16] = {v, 0, 0, shift, 0, v, 0, shift, 0, 0, v, shift, 0, 0, 0, 1};
    const int grid = host->add_grid(host, "density", worldFromIndex);
    if (grid < 0) return grid;

    const auto transform = openvdb::math::Transform::createLinearTransform(v);
    const int flags = fog.fill ? 0 : openvdb::tools::UNSIGNED_DISTANCE_FIELD;
    const auto distances = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
        adapter, *transform, static_cast<float>(halfBand), static_cast<float>(halfBand), flags);
    if (const int stop = host->progress(host, 0.7); stop != 0) return stop;

    Emitter emitter(host, grid, fog);
    if (const int error = emitter.leaves(distances->tree()); error != 0) return error;
    if (const int error = emitter.tiles(distances->tree()); error != 0) return error;
    if (fog.fill && !emitter.anyInside())
        throw std::runtime_error(
            "no voxel lies inside the surface: choose a smaller 'voxel', or 'fill=false' where it is open");
    return host->progress(host, 1);
}

}  // namespace mesh
