// SPDX-License-Identifier: Apache-2.0
#include <scrim/geometry/enclosing_cone.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

// Tolerance of cosines within which a direction counts as inside: the rounding of dot products of unit vectors.
constexpr double kSlack = 1e-13;

bool inside(const Cone& cone, const Vec3& d) {
    return glm::dot(cone.axis, d) >= cone.cosAngle - kSlack;
}

Cone coneOfTwo(const Vec3& a, const Vec3& b) {
    const Vec3 sum = a + b;
    const double length = glm::length(sum);
    if (length < 1e-12) return {a, -1};  // opposite directions: no cone narrower than 90 degrees
    const Vec3 axis = sum / length;
    return {axis, glm::dot(axis, a)};
}

Cone coneOfThree(const Vec3& a, const Vec3& b, const Vec3& c) {
    // The axis makes equal angles with all three directions: it is the normal of the plane through the three points.
    Vec3 axis = glm::cross(b - a, c - a);
    const double length = glm::length(axis);
    if (length < 1e-14) {  // two of them coincide, so the pair that is furthest apart decides
        Cone best = coneOfTwo(a, b);
        for (const Cone& other : {coneOfTwo(a, c), coneOfTwo(b, c)})
            if (other.cosAngle < best.cosAngle) best = other;
        return best;
    }
    axis /= length;
    if (glm::dot(axis, a) < 0) axis = -axis;
    return {axis, glm::dot(axis, a)};
}

// For more directions than this, those that cannot touch the cone are dropped first.
constexpr std::size_t kMany = 32;

}  // namespace

// In a central projection onto a plane, great circles become straight lines, so A. M. Andrew's
// monotone chain finds the hull there.
std::vector<Vec3> cornersOf(const std::vector<Vec3>& directions) {
    Vec3 sum(0);
    for (const Vec3& d : directions) sum += d;
    if (glm::length(sum) < 1e-3 * double(directions.size())) return directions;
    const Vec3 z = glm::normalize(sum);
    const Mat3 frame = frameAround(z);
    const Vec3 &x = frame[0], &y = frame[1];
    struct Place {
        Vec2 at;
        std::size_t direction;
    };
    std::vector<Place> places;
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const double depth = glm::dot(z, directions[i]);
        if (depth < 0.05) return directions;
        places.push_back({Vec2(glm::dot(x, directions[i]), glm::dot(y, directions[i])) / depth, i});
    }
    std::sort(places.begin(), places.end(),
              [](const Place& a, const Place& b) { return std::tie(a.at.x, a.at.y) < std::tie(b.at.x, b.at.y); });
    std::vector<Place> hull;
    const auto turnsLeft = [](const Vec2& a, const Vec2& b, const Vec2& c) {
        return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > 0;
    };
    // The chain runs along the lower side, and back along the upper one.
    for (const bool back : {false, true}) {
        const std::size_t first = hull.size();
        for (const Place& place : places) {
            while (hull.size() >= first + 2 && !turnsLeft(hull[hull.size() - 2].at, hull.back().at, place.at))
                hull.pop_back();
            hull.push_back(place);
        }
        hull.pop_back();  // this point starts the other side
        if (!back) std::reverse(places.begin(), places.end());
    }
    std::vector<Vec3> corners;
    for (const Place& place : hull) corners.push_back(directions[place.direction]);
    return corners.empty() ? directions : corners;
}

// The smallest enclosing ball of points on a sphere cuts out the cap around them, so Welzl's algorithm applies: at most
// three of the directions determine the cone. It is written as three nested loops instead of a recursion. The
// directions are sorted first, so that the order of the input does not matter.
Cone enclosingCone(const std::vector<Vec3>& directions) {
    std::vector<Vec3> d = directions.size() > kMany ? cornersOf(directions) : directions;
    std::sort(d.begin(), d.end(),
              [](const Vec3& a, const Vec3& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); });
    d.erase(std::unique(d.begin(), d.end()), d.end());

    Cone cone{d[0], 1};
    for (std::size_t i = 1; i < d.size(); ++i) {
        if (inside(cone, d[i])) continue;
        cone = {d[i], 1};
        for (std::size_t j = 0; j < i; ++j) {
            if (inside(cone, d[j])) continue;
            cone = coneOfTwo(d[i], d[j]);
            for (std::size_t k = 0; k < j; ++k)
                if (!inside(cone, d[k])) cone = coneOfThree(d[i], d[j], d[k]);
        }
    }
    // The construction above is meaningless for directions wider than a hemisphere, so its result is checked.
    for (const Vec3& v : d)
        if (glm::dot(cone.axis, v) < cone.cosAngle - 1e-9) return {cone.axis, -1};
    return cone;
}

GrowingCone::GrowingCone(std::vector<Vec3> directions)
    : m_directions(std::move(directions)), m_most(kMany), m_cone(enclosingCone(m_directions)) {
    findRim();
}

void GrowingCone::findRim() {
    constexpr double kTouches = 1e-12;  // larger than rounding; a direction too many does no harm
    constexpr std::size_t kEnough = 8;
    m_rim.clear();
    for (const Vec3& d : m_directions)
        if (m_rim.size() < kEnough && glm::dot(m_cone.axis, d) <= m_cone.cosAngle + kTouches) m_rim.push_back(d);
}

bool GrowingCone::holds(const std::vector<Vec3>& directions) const {
    return std::all_of(directions.begin(), directions.end(), [&](const Vec3& d) { return inside(m_cone, d); });
}

Cone GrowingCone::with(const std::vector<Vec3>& more, double cosMost) const {
    if (holds(more)) return m_cone;
    // The cone around a subset is no wider than that around all directions. The subset grows by the
    // direction that its cone misses most, until none is missed or the cone is too wide to matter.
    std::vector<Vec3> part = m_rim;
    part.insert(part.end(), more.begin(), more.end());
    for (;;) {
        const Cone cone = enclosingCone(part);
        if (cone.cosAngle < cosMost) return cone;
        double least = cone.cosAngle - kSlack;
        const Vec3* outside = nullptr;
        for (const Vec3& d : m_directions)
            if (const double cosine = glm::dot(cone.axis, d); cosine < least) {
                least = cosine;
                outside = &d;
            }
        if (!outside) return cone;
        // Already contained, missed by rounding.
        if (std::find(part.begin(), part.end(), *outside) != part.end()) break;
        part.push_back(*outside);
    }
    std::vector<Vec3> all = m_directions;
    all.insert(all.end(), more.begin(), more.end());
    return enclosingCone(all);
}

void GrowingCone::add(const std::vector<Vec3>& more) {
    m_cone = with(more, -2);
    m_directions.insert(m_directions.end(), more.begin(), more.end());
    if (m_directions.size() > m_most) {
        m_directions = cornersOf(m_directions);
        m_most = std::max(kMany, 2 * m_directions.size());
    }
    findRim();
}

}  // namespace scrim
