// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/lamps/area_shine.h>

#include <scrim/engine/lamps/lamp.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kPi = std::numbers::pi;

// The integral over a quarter turn of (a cos^2 + b sin^2) / ((cos^2 + p sin^2) sqrt(cos^2 + kc^2 sin^2)), p > 0
// (R. Bulirsch, Numerical Calculation of Elliptic Integrals and Elliptic Functions III, 1969).
double completeElliptic(double kc, double p, double a, double b) {
    constexpr double kPrecise = 1e-6;  // the root of what is left
    double e = kc, m = 1;
    p = std::sqrt(p);
    b /= p;
    for (;;) {
        const double f = a, g = e / p, before = m;
        a += b / p;
        b = 2 * (b + f * g);
        p += g;
        m += kc;
        if (std::abs(before - kc) <= before * kPrecise) break;
        kc = 2 * std::sqrt(e);
        e = kc * m;
    }
    return 0.5 * kPi * (b + a * m) / (m * (m + p));
}

// Four right triangles with a corner at the foot of `p`, two at a time. `w`, `h`: half the edges.
double ofRectangle(const Vec3& p, double w, double h) {
    const double x0 = -w - p.x, x1 = w - p.x, z = p.z;
    // atan(x1 y / (z r1)) - atan(x0 y / (z r0))
    const auto upTo = [&](double y) {
        const double r0 = std::sqrt(x0 * x0 + y * y + z * z), r1 = std::sqrt(x1 * x1 + y * y + z * z);
        return std::atan2(z * y * (x1 * r0 - x0 * r1), z * z * r0 * r1 + x0 * x1 * y * y);
    };
    return std::max(upTo(h - p.y) - upTo(-h - p.y), 0.0);
}

// F. Paxton, Solid Angle Calculation for a Circular Disk, 1959; its two integrals are one of completeElliptic.
double ofDisk(const Vec3& p, double radius) {
    constexpr double kLeast = 1e-9;  // over the rim both integrals are infinite, but not their sum
    const double r = std::hypot(p.x, p.y), most = std::hypot(p.z, radius + r);
    double q = (r - radius) / (r + radius);
    if (std::abs(q) < kLeast) q = kLeast;
    const double kc = std::max(std::hypot(p.z, r - radius) / most, kLeast);
    const double rest = 2 * p.z / most * (1 - q) * completeElliptic(kc, q * q, 1, -q);
    return std::clamp((q < 0 ? 2 * kPi : 0) - rest, 0.0, 2 * kPi);
}

// The integral, over the angles psi across the axis at which the cylinder is seen, of the difference of the sines to
// its ends. A sine as the variable takes the square root out of the distance at the largest psi.
double ofCylinder(const Vec3& p, double radius, double half) {
    const double far = std::hypot(p.y, p.z);
    if (far <= radius) return 0;
    const double most = std::asin(radius / far), before = -half - p.x, after = half - p.x;
    double sum = 0;
    for (const auto& [u, weight] : kFourPoints) {
        const double psi = most * std::sin(0.5 * kPi * u), across = far * std::sin(psi);
        const double c = far * std::cos(psi) - std::sqrt(std::max(radius * radius - across * across, 0.0));
        const double sines = after / std::sqrt(after * after + c * c) - before / std::sqrt(before * before + c * c);
        sum += weight * std::cos(0.5 * kPi * u) * sines;
    }
    return kPi * most * sum;
}

}  // namespace

bool AreaShine::serves(const Light& light) {
    const Light::Area* area = light.area();
    return area &&
           (area->shape == AreaShape::rectangle || area->shape == AreaShape::disk ||
            area->shape == AreaShape::cylinder) &&
           !light.slide && !Spread(area->spread).any();
}

AreaShine::AreaShine(const Light& light)
    : m_shape(light.area()->shape),
      m_center(light.wsPosition),
      m_frame(lightFrame(light)),
      m_halfWidth(0.5 * light.area()->width),
      m_halfHeight(0.5 * light.area()->height),
      m_radius(light.area()->radius) {}

double AreaShine::at(const Vec3& ws) const {
    return atLocal(local(ws));
}

double AreaShine::distance(const Vec3& ws) const {
    return distanceLocal(local(ws));
}

double AreaShine::atLocal(const Vec3& p) const {
    if (m_shape == AreaShape::cylinder) return ofCylinder(p, m_radius, m_halfWidth);
    if (p.z <= 0) return 0;
    return m_shape == AreaShape::disk ? ofDisk(p, m_radius) : ofRectangle(p, m_halfWidth, m_halfHeight);
}

double AreaShine::distanceLocal(const Vec3& p) const {
    const auto beyond = [](double x, double most) { return std::max(std::abs(x) - most, 0.0); };
    if (m_shape == AreaShape::cylinder)
        return std::hypot(beyond(p.x, m_halfWidth), beyond(std::hypot(p.y, p.z), m_radius));
    if (m_shape == AreaShape::disk) return std::hypot(beyond(std::hypot(p.x, p.y), m_radius), p.z);
    const double x = beyond(p.x, m_halfWidth), y = beyond(p.y, m_halfHeight);
    return std::sqrt(x * x + y * y + p.z * p.z);
}

// The place between two of a path that is nearest to the shape, which is convex: by golden sections.
double AreaShine::nearest(const Path& path, double from, double to) const {
    constexpr int kSections = 18;
    constexpr double kPart = 1 / std::numbers::phi;
    const auto at = [&](double s) { return distanceLocal(path.begin + s * path.way); };
    double a = to - kPart * (to - from), b = from + kPart * (to - from), atA = at(a), atB = at(b);
    for (int i = 0; i < kSections; ++i)
        if (atA <= atB) {
            to = b, b = a, atB = atA;
            a = to - kPart * (to - from), atA = at(a);
        } else {
            from = a, a = b, atA = atB;
            b = from + kPart * (to - from), atB = at(b);
        }
    return at(from) <= std::min(atA, atB) ? from : at(to) <= std::min(atA, atB) ? to : 0.5 * (a + b);
}

// The length over which the solid angle changes at a place of a path that is the nearest one, world units. Before a
// rectangle or disk: to its rim. Beside a cylinder: that of the tangent to it.
double AreaShine::scaleAt(const Vec3& p) const {
    constexpr double kOfRadius = 0.1;
    const double d = distanceLocal(p);
    if (m_shape == AreaShape::cylinder) return std::max(std::sqrt(d * (d + 2 * m_radius)), kOfRadius * m_radius);
    const double inside = m_shape == AreaShape::disk
                              ? m_radius - std::hypot(p.x, p.y)
                              : std::min(m_halfWidth - std::abs(p.x), m_halfHeight - std::abs(p.y));
    return std::hypot(d, std::max(inside, 0.0));
}

// The parts of a path, from 0 to 1, in which there may be light: before the plane, or outside of the endless cylinder.
std::size_t AreaShine::litParts(const Path& path, std::array<std::array<double, 2>, 2>& parts) const {
    const Vec3 &p = path.begin, &w = path.way;
    std::size_t count = 0;
    const auto add = [&](double from, double to) {
        from = std::max(from, 0.0), to = std::min(to, 1.0);
        if (to > from) parts[count++] = {from, to};
    };
    if (m_shape != AreaShape::cylinder) {
        const double end = p.z + w.z;
        if (p.z > 0 || end > 0) add(p.z > 0 ? 0 : -p.z / w.z, end > 0 ? 1 : -p.z / w.z);
        return count;
    }
    const double a = w.y * w.y + w.z * w.z, b = p.y * w.y + p.z * w.z, c = p.y * p.y + p.z * p.z - m_radius * m_radius,
                 root = b * b - a * c;
    if (a <= 0 || root <= 0) {
        if (c > 0) add(0, 1);
        return count;
    }
    add(0, (-b - std::sqrt(root)) / a);
    add((-b + std::sqrt(root)) / a, 1);
    return count;
}

// From the place `from`, at which light changes fastest, to `to`. With s = from + b sinh(u) what falls off as a power
// of b^2 + s^2 is smooth in u.
void AreaShine::addPiece(const Path& path, double from, double to, Pieces& pieces) const {
    constexpr double kLeast = 1e-3;  // of the path, for those that meet a rim
    const double length = std::abs(to - from), towards = to > from ? 1 : -1;
    if (length < 1e-9) return;
    const double scale = std::max(scaleAt(path.begin + from * path.way) / path.length, kLeast);
    const double most = std::asinh(length / scale);
    double sum = 0, places = 0;
    for (const auto& [node, weight] : kFourPoints) {
        const double e = std::exp(node * most), s = from + towards * scale * 0.5 * (e - 1 / e);
        const double own = weight * 0.5 * (e + 1 / e) * std::exp(-path.tau * s) * atLocal(path.begin + s * path.way);
        sum += own;
        places += own * s;
    }
    if (sum <= 0) return;
    Piece& piece = pieces.all[pieces.count++];
    piece.solidAngle = sum * most * scale / path.seen;
    piece.ws = m_center + m_frame * (path.begin + places / sum * path.way);
}

// A part in which light changes little: by Gauss' two points.
void AreaShine::addEven(const Path& path, double from, double to, Pieces& pieces) const {
    const double half = 0.5 * (to - from), middle = from + half, beside = half / std::sqrt(3.0);
    const auto seenAt = [&](double s) { return std::exp(-path.tau * s) * atLocal(path.begin + s * path.way); };
    const double near = seenAt(middle - beside), far = seenAt(middle + beside), sum = near + far;
    if (sum <= 0) return;
    Piece& piece = pieces.all[pieces.count++];
    piece.solidAngle = sum * half / path.seen;
    piece.ws = m_center + m_frame * (path.begin + (middle + beside * (far - near) / sum) * path.way);
}

AreaShine::Pieces AreaShine::along(const Vec3& wsBegin, const Vec3& wsPath, double tau) const {
    constexpr double kFar = 10, kEven = 2;  // lengths of the path: to a quarter and a fifth of a per cent
    Path path{local(wsBegin), wsPath * m_frame, glm::length(wsPath), tau, 1};
    path.seen = std::abs(tau) < 1e-6 ? 1 : -std::expm1(-tau) / tau;
    Pieces pieces;
    const double away = distanceLocal(path.begin + 0.5 * path.way);
    std::array<std::array<double, 2>, 2> lit;
    if (away > kFar * path.length) {
        // What changes evenly counts as it is where the eye sees half of the path.
        const double s = 0.5 - tau / 12 / (1 + std::abs(tau) / 6);
        pieces.all[pieces.count++] = {atLocal(path.begin + s * path.way), wsBegin + s * wsPath};
        return pieces;
    }
    const std::size_t parts = litParts(path, lit);
    for (std::size_t i = 0; i < parts; ++i) {
        const auto [from, to] = lit[i];
        if (away > kEven * path.length) {
            addEven(path, from, to, pieces);
            continue;
        }
        const double middle = nearest(path, from, to);
        addPiece(path, middle, from, pieces);
        addPiece(path, middle, to, pieces);
    }
    return pieces;
}

}  // namespace scrim
