// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/first_collisions.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Beyond this optical depth no visible light is left: e^-30 is 1e-13.
constexpr double kMostTau = 30;
// At this distance from the centre of a cube, in edges, 1/r^2 equals its mean over the cube; that mean is 3 / R^2 for a
// ball of the same volume.
constexpr double kNearest = 0.36;

// The ratio of the mean of light over a path of optical depth t to its value at the path's middle: sinh(t / 2) / (t /
// 2).
double meanOverCell(double t) {
    const double half = 0.5 * std::min(t, 2 * kMostTau);
    return half < 1e-4 ? 1 : std::sinh(half) / half;
}

// Optical depth without scattering straight on, and the depth of that scattering.
struct Depths {
    Rgb tau{0}, straight{0};
};

// Optical depths along a ray, from cell to cell, with empty blocks skipped (J. Amanatides and A. Woo, A Fast Voxel
// Traversal Algorithm for Ray Tracing, 1987).
Depths opticalDepths(const CellMedia& media, const Vec3& ws, const Vec3& direction, double distance) {
    const CellGrid& grid = media.grid;
    const Vec3 origin = grid.csFromWs(ws);
    const double length = distance / grid.edge();  // directions are unit in cells, too
    const Int3 size = grid.blocks() * kCellEdge;
    Int3 cell(glm::floor(origin)), step(0);
    Vec3 next(kInfinity), each(kInfinity);
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0) continue;
        step[axis] = direction[axis] > 0 ? 1 : -1;
        each[axis] = 1 / std::abs(direction[axis]);
        next[axis] = (cell[axis] + (step[axis] > 0 ? 1 : 0) - origin[axis]) / direction[axis];
    }
    const bool grey = media.extinction.size() == 1, straight = !media.straight.empty();
    Depths out;
    Rgb& tau = out.tau;
    double t = 0;
    while (t < length) {
        const std::ptrdiff_t index = grid.index(cell);
        const int axis = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
        const double end = std::min(next[axis], length);
        if (index >= 0) {
            const double way = (end - t) * grid.edge();
            tau.x += way * media.extinction[0][std::size_t(index)];
            if (!grey) {
                tau.y += way * media.extinction[1][std::size_t(index)];
                tau.z += way * media.extinction[2][std::size_t(index)];
            }
            for (std::size_t c = 0; straight && c < media.straight.size(); ++c)
                out.straight[int(c)] += way * media.straight[c][std::size_t(index)];
            if (std::min({tau.x, grey ? kInfinity : tau.y, grey ? kInfinity : tau.z}) > kMostTau) break;
        }
        t = next[axis];
        cell[axis] += step[axis];
        next[axis] += each[axis];
        if (cell[axis] < 0 || cell[axis] >= size[axis]) break;
    }
    return grey ? Depths{Rgb(tau.x), Rgb(out.straight.x)} : out;
}

}  // namespace

// The distance to the light is at least the mean distance of a cell's points from its centre.
FirstCollisions::FirstCollisions(const ViewScene& scene, const CellMedia& media, const Light& light)
    : m_scene(scene), m_media(media), m_light(light), m_unattenuated(light, kNearest * media.grid.edge()) {}

ArrivingInCell FirstCollisions::at(std::size_t cell) const {
    const Vec3 ws = m_media.grid.wsCenter(cell);
    ArrivingInCell out{m_unattenuated.at(ws)};
    if (out.irradiance == Rgb(0) || !m_light.shadows) return out;
    const Vec3 toLight = -out.travel;
    if (m_scene.solids && m_scene.solids->firstHit(SolidRole::shadow, ws, toLight, 0, out.distance) < kInfinity) {
        out.irradiance = Rgb(0);
        return out;
    }
    const Depths depths = opticalDepths(m_media, ws, toLight, out.distance);
    // The mean chord of a cube along a direction is its volume divided by its projected area.
    const double chord = m_media.grid.edge() / (std::abs(toLight.x) + std::abs(toLight.y) + std::abs(toLight.z));
    for (int c = 0; c < 3; ++c)
        out.irradiance[c] *=
            std::exp(-depths.tau[c]) * meanOverCell(chord * m_media.extinctionOf(std::size_t(c))[cell]);
    out.straightDepth = depths.straight;
    return out;
}

}  // namespace scrim
