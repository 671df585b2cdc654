// SPDX-License-Identifier: Apache-2.0
// The eye's path through a sheet that is close to a lamp, as the lamp sees it. On it 1/r^2, the angle of scattering and
// the way of the light change so much that their values in the middle say nothing about the path. At the angle t from
// the path's nearest point, which is b away, a place is z = b tan(t) along the path, and dz / (b^2 + z^2) = dt / b: in
// t 1/r^2 is even, and the rest is smooth.
#pragma once

#include <scrim/engine/lamps/lamp.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim {

class PathPastLamp {
  public:
    /// `way`: from the lamp to the path's middle; `path`: from one end to the other, world units. `radius`: within it
    /// there is no light if `hollow`, as in a sphere, and else as much as at it. `lobe`: the angle that the narrowest
    /// lobe of what scatters the light is as wide as, radians.
    PathPastLamp(const Vec3& way, const Vec3& path, double radius, bool hollow, double lobe)
        : m_radius(radius), m_hollow(hollow), m_lobe(lobe), m_length(glm::length(path)) {
        const double middle = glm::dot(way, path) / m_length, b2 = glm::dot(way, way) - middle * middle;
        m_middle = middle;
        m_nearest = std::max(std::sqrt(std::max(b2, 0.0)), 1e-3 * radius);
        m_inside = std::sqrt(std::max(radius * radius - m_nearest * m_nearest, 0.0));
    }

    /// True if the lamp is so close that what lies on the path is to be asked point by point. Farther away what changes
    /// along it is nearly linear: the light turns by less than a quarter of its angle to a lobe. A luminaire's profile
    /// has edges of its own: it is linear to t^2 / (24 r^2) times its curvature.
    static bool isNear(const Vec3& way, const Vec3& path, double radius, bool luminaire) {
        const double near = luminaire ? 10 : 4;
        return glm::dot(way, way) < near * near * (radius * radius + glm::dot(path, path));
    }

    /// Calls visit(place, weight) for some points of the path: the sum of weight * f(place) is the
    /// mean of f / r^2 over it. A place is in [-1/2, 1/2], in lengths of the path from its middle.
    template <class Visit>
    void forPoints(const Visit& visit) const {
        const double begin = m_middle - 0.5 * m_length, end = m_middle + 0.5 * m_length;
        outside(std::max(begin, m_inside), end, 1, visit);
        outside(std::max(-end, m_inside), -begin, -1, visit);
        const double first = std::max(begin, -m_inside), last = std::min(end, m_inside);
        if (m_hollow || last <= first) return;
        for (const auto& [u, weight] : kFourPoints)
            visitAt(first + u * (last - first), weight * (last - first) / (m_radius * m_radius), visit);
    }

  private:
    // Pieces of three lobes resolve every phase function, and a piece of half a lobe needs no more than two points.
    template <class Visit>
    void outside(double nearest, double farthest, double side, const Visit& visit) const {
        constexpr double kLobes = 3, kWide = 0.8, kOfLobe = 0.5, kNarrow = 0.5;
        if (farthest <= nearest) return;
        const double begin = std::atan(nearest / m_nearest), width = std::atan(farthest / m_nearest) - begin;
        const auto visitAngle = [&](double at, double weight) {
            const double z = std::clamp(m_nearest * std::tan(begin + at * width), nearest, farthest);
            visitAt(side * z, weight * width / m_nearest, visit);
        };
        if (!m_hollow && width < std::min(kOfLobe * m_lobe, kNarrow)) {
            constexpr double kGauss = 0.28867513459481287;  // Gauss' and Legendre's two points
            for (const double at : {0.5 - kGauss, 0.5 + kGauss}) visitAngle(at, 0.5);
            return;
        }
        const int pieces = static_cast<int>(std::ceil(width / std::min(kLobes * m_lobe, kWide)));
        for (int i = 0; i < pieces; ++i)
            for (const auto& [u, weight] : kFourPoints) {
                // At a sphere's surface its light changes as a root does.
                const double part = (i + u) / pieces;
                if (m_hollow)
                    visitAngle(part * part, 2 * part * weight / pieces);
                else
                    visitAngle(part, weight / pieces);
            }
    }
    template <class Visit>
    void visitAt(double z, double weight, const Visit& visit) const {
        visit((z - m_middle) / m_length, weight / m_length);
    }

    double m_radius;
    bool m_hollow;
    double m_lobe, m_length;
    double m_middle;   // of the path, from its nearest point
    double m_nearest;  // distance of its line from the lamp
    double m_inside;   // half the way through the radius
};

}  // namespace scrim
