// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/first_collisions.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Past it no light is left that would be seen: e^-30 is 1e-13.
constexpr double kMostTau = 30;
// So many edges from the middle of a cube 1/r^2 has its mean over the cube: that of a ball as large is 3 / R^2.
constexpr double kNearest = 0.36;

// Of light that is even over a way of optical depth t, whose middle it was found at: sinh(t / 2) / (t / 2).
double meanOverCell(double t) {
    const double half = 0.5 * std::min(t, 2 * kMostTau);
    return half < 1e-4 ? 1 : std::sinh(half) / half;
}

}  // namespace

FirstCollisions::FirstCollisions(const ViewScene& scene, const CellMedia& media, const Light& light)
    : m_scene(scene), m_media(media), m_light(light) {
    if (light.slide) m_slide = slideMap(light);
}

// Before anything takes some of it.
Arriving FirstCollisions::unattenuated(const Vec3& ws) const {
    Arriving out{m_light.intensity, Rgb(0), m_light.wsDirection, kInfinity};
    if (!m_light.distant()) {
        const Light::Point& point = m_light.point();
        const Vec3 way = ws - m_light.wsPosition;
        out.distance = glm::length(way);
        if (out.distance > 0) out.travel = way / out.distance;
        if (point.decay) {
            // At least as near as a cell's points are to its middle in the mean.
            const double least = std::max(point.radius, kNearest * m_media.grid.edge());
            out.irradiance /= std::max(glm::dot(way, way), least * least);
        }
        const double along = glm::dot(out.travel, m_light.wsDirection);
        if (const Light::Spot* spot = m_light.spot()) {
            const double half = 0.5 * glm::radians(spot->coneAngle);
            const double outer = std::cos(half), inner = std::cos(half * (1 - spot->blend));
            const double t =
                inner > outer ? std::clamp((along - outer) / (inner - outer), 0.0, 1.0) : (along > outer ? 1.0 : 0.0);
            out.irradiance *= t * t * (3 - 2 * t);
        }
        if (m_light.element()) out.irradiance *= std::max(along, 0.0);
    }
    if (m_slide) out.irradiance *= slideValue(m_light, *m_slide, ws);
    return out;
}

// From cell to cell, and past blocks in which nothing is at a time (J. Amanatides and A. Woo, A Fast Voxel Traversal
// Algorithm for Ray Tracing, 1987).
FirstCollisions::Depths FirstCollisions::opticalDepths(const Vec3& ws, const Vec3& direction, double distance) const {
    const CellGrid& grid = m_media.grid;
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
    const bool grey = m_media.extinction.size() == 1, straight = !m_media.straight.empty();
    Depths out;
    Rgb& tau = out.tau;
    double t = 0;
    while (t < length) {
        const std::ptrdiff_t index = grid.index(cell);
        const int axis = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
        const double end = std::min(next[axis], length);
        if (index >= 0) {
            const double way = (end - t) * grid.edge();
            tau.x += way * m_media.extinction[0][std::size_t(index)];
            if (!grey) {
                tau.y += way * m_media.extinction[1][std::size_t(index)];
                tau.z += way * m_media.extinction[2][std::size_t(index)];
            }
            for (std::size_t c = 0; straight && c < m_media.straight.size(); ++c)
                out.straight[int(c)] += way * m_media.straight[c][std::size_t(index)];
            if (std::min({tau.x, grey ? kInfinity : tau.y, grey ? kInfinity : tau.z}) > kMostTau) break;
        }
        t = next[axis];
        cell[axis] += step[axis];
        next[axis] += each[axis];
        if (cell[axis] < 0 || cell[axis] >= size[axis]) break;
    }
    return grey ? Depths{Rgb(tau.x), Rgb(out.straight.x)} : out;
}

Arriving FirstCollisions::at(std::size_t cell) const {
    const Vec3 ws = m_media.grid.wsCenter(cell);
    Arriving out = unattenuated(ws);
    if (out.irradiance == Rgb(0) || !m_light.shadows) return out;
    const Vec3 toLight = -out.travel;
    if (m_scene.solids && m_scene.solids->firstHit(SolidRole::shadow, ws, toLight, 0, out.distance) < kInfinity) {
        out.irradiance = Rgb(0);
        return out;
    }
    const Depths depths = opticalDepths(ws, toLight, out.distance);
    // A cube's mean chord along a direction is its volume over its shadow.
    const double chord = m_media.grid.edge() / (std::abs(toLight.x) + std::abs(toLight.y) + std::abs(toLight.z));
    for (int c = 0; c < 3; ++c)
        out.irradiance[c] *=
            std::exp(-depths.tau[c]) * meanOverCell(chord * m_media.extinctionOf(std::size_t(c))[cell]);
    out.straightDepth = depths.straight;
    return out;
}

}  // namespace scrim
