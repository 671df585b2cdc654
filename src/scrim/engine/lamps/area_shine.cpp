// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/lamps/area_shine.h>

#include <scrim/engine/lamps/lamp.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kPi = std::numbers::pi;

// A part of what a place sees: its solid angle, and the integral over the directions towards it.
struct Patch {
    double solidAngle = 0;
    Vec3 towards{0};
};

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

// The solid angle of a polygon that is seen clockwise from its front, from the middle (A. van
// Oosterom and J. Strackee, The Solid Angle of a Plane Triangle, 1983).
double solidAngleOf(std::span<const Vec3> corners) {
    double sum = 0;
    const auto length = [&](std::size_t i) { return glm::length(corners[i]); };
    const Vec3& first = corners.front();
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
        const Vec3 &a = corners[i], &b = corners[i + 1];
        const double beside = length(0) * length(i) * length(i + 1) + glm::dot(first, a) * length(i + 1) +
                              glm::dot(first, b) * length(i) + glm::dot(a, b) * length(0);
        sum += 2 * std::atan2(glm::dot(first, glm::cross(a, b)), beside);
    }
    return sum;
}

// The same with the integral over the directions towards it (J. H. Lambert's formula).
Patch ofPolygon(std::span<const Vec3> corners) {
    Patch patch{solidAngleOf(corners)};
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3 &a = corners[i], &b = corners[(i + 1) % corners.size()], across = glm::cross(a, b);
        const double sine = glm::length(across);
        if (sine > 0) patch.towards += 0.5 * std::atan2(sine, glm::dot(a, b)) / sine * across;
    }
    return patch;
}

// Half the angle of the cap that has the same mean cosine to its middle, which is (1 + cos a) / 2.
double halfAngleOf(const Patch& patch) {
    return std::acos(std::clamp(2 * glm::length(patch.towards) / patch.solidAngle - 1, 0.0, 1.0));
}

// Places between two along a line, `away` from which the middle is, that see equal angles of at
// most `least` between them as far as kMost parts allow.
struct Cuts {
    static constexpr int kMost = 8;
    int parts;
    std::array<double, kMost + 1> at;

    Cuts(double before, double after, double away, double least) {
        const double from = std::atan2(before, away), to = std::atan2(after, away);
        parts = std::clamp(static_cast<int>(std::ceil((to - from) / least)), 1, kMost);
        at[0] = before, at[std::size_t(parts)] = after;
        for (int i = 1; i < parts; ++i) at[std::size_t(i)] = away * std::tan(from + (to - from) * i / parts);
    }
};

// Calls visit(patch) for parts of a rectangle whose edges are 2w and 2h.
template <class Visit>
void visitRectangle(const Vec3& p, double w, double h, double least, const Visit& visit) {
    const double besideX = std::max(std::abs(p.x) - w, 0.0), besideY = std::max(std::abs(p.y) - h, 0.0);
    const Cuts x(-w - p.x, w - p.x, std::hypot(p.z, besideY), least),
        y(-h - p.y, h - p.y, std::hypot(p.z, besideX), least);
    for (std::size_t j = 0; j < std::size_t(y.parts); ++j)
        for (std::size_t i = 0; i < std::size_t(x.parts); ++i) {
            const std::array<Vec3, 4> corners{Vec3(x.at[i], y.at[j], -p.z), Vec3(x.at[i], y.at[j + 1], -p.z),
                                              Vec3(x.at[i + 1], y.at[j + 1], -p.z), Vec3(x.at[i + 1], y.at[j], -p.z)};
            visit(ofPolygon(corners));
        }
}

// The same of a disk: parts of cones around its normal, each as a cap of its size. They are about as many as the disk.
template <class Visit>
void visitDisk(const Vec3& p, double radius, double least, const Visit& visit) {
    constexpr int kMostTurns = 16;
    const double foot = std::hypot(p.x, p.y), middle = std::atan2(-p.y, -p.x);
    const bool inside = foot < radius;
    const double most = inside ? kPi : std::asin(std::min(radius / foot, 1.0));
    const int turns = std::clamp(static_cast<int>(std::ceil(2 * most / least)), 4, kMostTurns);
    for (int i = 0; i < turns; ++i) {
        const double u = (2 * i + 1.0) / turns - 1;
        // Towards the tangents, the rim comes closer as a root does.
        const double beside = inside ? most * u : most * std::sin(0.5 * kPi * u),
                     width = 2 * most / turns * (inside ? 1 : 0.5 * kPi * std::cos(0.5 * kPi * u));
        const double along = foot * std::cos(beside), across = foot * std::sin(beside),
                     half = std::sqrt(std::max(radius * radius - across * across, 0.0));
        const double from = std::atan2(std::max(along - half, 0.0), p.z), to = std::atan2(along + half, p.z);
        const int parts = std::max(static_cast<int>(std::ceil((to - from) / least)), 1);
        for (int j = 0; j < parts; ++j) {
            const double low = from + (to - from) * j / parts, high = from + (to - from) * (j + 1) / parts;
            // The middle of a wedge is where its mean cosine to the normal is.
            const double solidAngle = width * (std::cos(low) - std::cos(high)),
                         down = 0.5 * (std::cos(low) + std::cos(high)), out = std::sqrt(1 - down * down);
            const Vec3 way(out * std::cos(middle + beside), out * std::sin(middle + beside), -down);
            visit(Patch{solidAngle, solidAngle * (1 - solidAngle / (4 * kPi)) * way});
        }
    }
}

// The directions towards a strip of a cylinder at an angle psi across the axis, between two places along it, with what
// the sum over the strips weighs it by. The slope of a direction has the integral of its cosine as solid angle; along
// the axis that of its sine times the cosine, and across the axis that of the cosine squared.
Patch ofStrip(double psi, double c, double before, double after, double weight) {
    const auto sine2 = [&](double x) { return x * x / (x * x + c * c); };
    const auto upTo = [&](double x) { return std::atan2(x, c) + x * c / (x * x + c * c); };
    const double along = 0.5 * weight * (sine2(after) - sine2(before)),
                 across = 0.5 * weight * (upTo(after) - upTo(before));
    const double sines = after / std::sqrt(after * after + c * c) - before / std::sqrt(before * before + c * c);
    return {weight * sines, {along, across * std::cos(psi), across * std::sin(psi)}};
}

// The same of a cylinder, by eight strips along it.
template <class Visit>
void visitCylinder(const Vec3& p, double radius, double half, double least, const Visit& visit) {
    const double far = std::hypot(p.y, p.z), y = -p.y / far, z = -p.z / far;
    if (far <= radius) return;
    const double most = std::asin(radius / far);
    for (const auto& [u, weight] : kFourPoints)
        for (const int side : {-1, 1}) {
            const double psi = side * most * std::sin(0.5 * kPi * u), across = far * std::sin(psi);
            const double c = far * std::cos(psi) - std::sqrt(std::max(radius * radius - across * across, 0.0));
            const Cuts cuts(-half - p.x, half - p.x, c, least);
            for (std::size_t i = 0; i < std::size_t(cuts.parts); ++i) {
                const Patch strip =
                    ofStrip(psi, c, cuts.at[i], cuts.at[i + 1], 0.5 * kPi * most * weight * std::cos(0.5 * kPi * u));
                const Vec3& t = strip.towards;  // x along the cylinder, y towards its axis
                visit(Patch{strip.solidAngle, {t.x, t.y * y - t.z * z, t.y * z + t.z * y}});
            }
        }
}

// The corners of a triangle as seen from `p`, clockwise from its front; nothing if that is turned away.
std::optional<std::array<Vec3, 3>> seenTriangle(const TriangleMesh& mesh, std::size_t triangle, const Vec3& p) {
    const Vec3 &a = mesh.corner(triangle, 0), &b = mesh.corner(triangle, 1), &c = mesh.corner(triangle, 2);
    if (!(glm::dot(glm::cross(b - a, c - a), p - a) > 0)) return std::nullopt;
    return std::array<Vec3, 3>{a - p, c - p, b - p};
}

// The same of a triangle: a quarter of it at a time.
template <class Visit>
void visitTriangle(const std::array<Vec3, 3>& corners, double least, int quarters, const Visit& visit) {
    const Patch patch = ofPolygon(corners);
    if (!(patch.solidAngle > 0)) return;
    if (quarters == 0 || halfAngleOf(patch) <= 0.5 * least) {
        visit(patch);
        return;
    }
    const auto& [a, b, c] = corners;
    const Vec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    for (const std::array<Vec3, 3>& quarter : {std::array<Vec3, 3>{a, ab, ca}, std::array<Vec3, 3>{ab, b, bc},
                                               std::array<Vec3, 3>{ca, bc, c}, std::array<Vec3, 3>{ab, bc, ca}})
        visitTriangle(quarter, least, quarters - 1, visit);
}

// The solid angle of an area, along its normal, that is small beside the way to it.
double ofPart(const Vec3& area, const Vec3& way) {
    const double r2 = glm::dot(way, way);
    return -glm::dot(area, way) / (r2 * std::sqrt(r2));
}

// The same of a mesh: what is far away as a whole.
template <class Visit>
void visitMesh(const ShiningMesh& mesh, const Vec3& p, double least, const Visit& visit) {
    constexpr int kMostQuarters = 4;
    const auto visitPart = [&](const Vec3& at, const Vec3& area) {
        const Vec3 way = at - p;
        const double solidAngle = ofPart(area, way);
        visit(Patch{solidAngle, solidAngle * (1 - solidAngle / (4 * kPi)) / glm::length(way) * way});
    };
    mesh.visit(p, visitPart, [&](std::size_t triangle) {
        if (const auto corners = seenTriangle(mesh.mesh(), triangle, p))
            visitTriangle(*corners, least, kMostQuarters, visit);
    });
}

double ofMesh(const ShiningMesh& mesh, const Vec3& p) {
    double sum = 0;
    const auto addPart = [&](const Vec3& at, const Vec3& area) { sum += ofPart(area, at - p); };
    mesh.visit(p, addPart, [&](std::size_t triangle) {
        if (const auto corners = seenTriangle(mesh.mesh(), triangle, p)) sum += std::max(solidAngleOf(*corners), 0.0);
    });
    return sum;
}

}  // namespace

bool AreaShine::serves(const Light& light) {
    const Light::Area* area = light.area();
    return area && area->shape != AreaShape::sphere && (area->shape != AreaShape::mesh || area->surface) &&
           !light.slide && !Spread(area->spread).any();
}

AreaShine::AreaShine(const Light& light, const std::vector<Octave>& octaves, const Camera& camera)
    : m_shape(light.area()->shape),
      m_center(light.wsPosition),
      m_frame(lightFrame(light)),
      m_halfWidth(0.5 * light.area()->width),
      m_halfHeight(0.5 * light.area()->height),
      m_radius(light.area()->radius),
      m_camera(camera) {
    if (m_shape == AreaShape::mesh) {
        m_center = Vec3(0);
        m_frame = Mat3(1);
        m_mesh = std::make_shared<const ShiningMesh>(*light.area()->surface);
    }
    for (const Octave& octave : octaves)
        if (octave.phase.isotropic())
            m_even += octave.share / (4 * kPi);
        else
            m_directed.push_back({octave.share, PhaseOverCaps(octave.phase, 0.5 * kPi)});
    for (const Octave& octave : octaves) m_lobe = std::min(m_lobe, lobeWidth(octave.phase));
}

double AreaShine::at(const Vec3& ws) const {
    return atLocal(local(ws));
}

Vec3 AreaShine::towards(const Vec3& ws) const {
    return m_frame * towardsLocal(local(ws));
}

double AreaShine::shown(const Vec3& ws) const {
    return shownLocal(local(ws));
}

double AreaShine::distance(const Vec3& ws) const {
    return distanceLocal(local(ws));
}

double AreaShine::atLocal(const Vec3& p) const {
    if (m_mesh) return ofMesh(*m_mesh, p);
    if (m_shape == AreaShape::cylinder) return ofCylinder(p, m_radius, m_halfWidth);
    if (p.z <= 0) return 0;
    return m_shape == AreaShape::disk ? ofDisk(p, m_radius) : ofRectangle(p, m_halfWidth, m_halfHeight);
}

// Calls visit(patch) for parts of the surface that are at most about `least` wide, radians, in each direction.
template <class Visit>
void AreaShine::visitPatches(const Vec3& p, double least, const Visit& visit) const {
    if (m_mesh)
        visitMesh(*m_mesh, p, least, visit);
    else if (m_shape == AreaShape::cylinder)
        visitCylinder(p, m_radius, m_halfWidth, least, visit);
    else if (p.z > 0 && m_shape == AreaShape::disk)
        visitDisk(p, m_radius, least, visit);
    else if (p.z > 0)
        visitRectangle(p, m_halfWidth, m_halfHeight, least, visit);
}

Vec3 AreaShine::towardsLocal(const Vec3& p) const {
    constexpr std::size_t kCorners = 12;
    Vec3 sum(0);
    if (m_shape != AreaShape::disk) {
        visitPatches(p, 2 * kPi, [&](const Patch& patch) { sum += patch.towards; });
        return sum;
    }
    if (p.z <= 0) return sum;
    // A polygon as large as the disk.
    std::array<Vec3, kCorners> corners;
    const double turn = 2 * kPi / kCorners, radius = m_radius * std::sqrt(turn / std::sin(turn));
    for (std::size_t i = 0; i < kCorners; ++i)
        corners[i] = radius * Vec3(std::cos(double(i) * turn), -std::sin(double(i) * turn), 0) - p;
    return ofPolygon(corners).towards;
}

double AreaShine::shownLocal(const Vec3& p) const {
    constexpr double kWide = 0.75;  // of the width of the lobe
    if (m_directed.empty()) return m_even * atLocal(p);
    const double solidAngle = m_mesh ? 0 : atLocal(p);
    if (!m_mesh && solidAngle <= 0) return 0;
    const Vec3 toEye = travelToEye(m_camera, m_center + m_frame * p) * m_frame;
    double directed = 0, all = 0;
    const auto add = [&](const Patch& patch) {
        const double length = glm::length(patch.towards);
        if (!(patch.solidAngle > 0 && length > 0)) return;
        const double halfAngle = halfAngleOf(patch),
                     cosine = std::clamp(-glm::dot(patch.towards, toEye) / length, -1.0, 1.0);
        for (const Directed& octave : m_directed)
            directed += patch.solidAngle * octave.share * octave.caps.at(cosine, halfAngle);
        all += patch.solidAngle;
    };
    if (m_mesh) {
        visitPatches(p, m_lobe, add);
        return m_even * all + directed;
    }
    const Patch whole{solidAngle, towardsLocal(p)};
    if (halfAngleOf(whole) > kWide * m_lobe)
        visitPatches(p, m_lobe, add);
    else
        add(whole);
    return m_even * solidAngle + (all > 0 ? directed / all * solidAngle : 0);
}

double AreaShine::distanceLocal(const Vec3& p) const {
    if (m_mesh) return m_mesh->distance(p);
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

// The length over which the solid angle changes at a place of a path that is the nearest one, world
// units. Before a rectangle or disk: to its rim. Beside a cylinder: that of the tangent to it.
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
    if (m_mesh) {
        add(0, 1);
        return count;
    }
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

// From the place `from`, at which light changes fastest, to `to`. With s = from + b sinh(u) what
// falls off as a power of b^2 + s^2 is smooth in u.
void AreaShine::addPiece(const Path& path, double from, double to, Pieces& pieces) const {
    constexpr double kLeast = 1e-3;  // of the path, for those that meet a rim
    const double length = std::abs(to - from), towards = to > from ? 1 : -1;
    if (length < 1e-9) return;
    const double scale = std::max(scaleAt(path.begin + from * path.way) / path.length, kLeast);
    const double most = std::asinh(length / scale);
    double sum = 0, places = 0;
    for (const auto& [node, weight] : kFourPoints) {
        const double e = std::exp(node * most), s = from + towards * scale * 0.5 * (e - 1 / e);
        const double own = weight * 0.5 * (e + 1 / e) * std::exp(-path.tau * s) * shownLocal(path.begin + s * path.way);
        sum += own;
        places += own * s;
    }
    if (sum <= 0) return;
    Piece& piece = pieces.all[pieces.count++];
    piece.shown = sum * most * scale / path.seen;
    piece.ws = m_center + m_frame * (path.begin + places / sum * path.way);
}

// A part in which light changes little: by Gauss' two points.
void AreaShine::addEven(const Path& path, double from, double to, Pieces& pieces) const {
    const double half = 0.5 * (to - from), middle = from + half, beside = half / std::sqrt(3.0);
    const auto seenAt = [&](double s) { return std::exp(-path.tau * s) * shownLocal(path.begin + s * path.way); };
    const double near = seenAt(middle - beside), far = seenAt(middle + beside), sum = near + far;
    if (sum <= 0) return;
    Piece& piece = pieces.all[pieces.count++];
    piece.shown = sum * half / path.seen;
    piece.ws = m_center + m_frame * (path.begin + (middle + beside * (far - near) / sum) * path.way);
}

// From one crossing of a mesh to the next, by steps about as long as the mesh is far away: over
// each the light changes by about its half. A piece is a part of the path with all that is in it.
void AreaShine::addAcrossMesh(const Path& path, Pieces& pieces) const {
    constexpr double kOfDistance = 0.8, kLeast = 1.0 / 24;
    const auto add = [&](double at, double length) {
        const Vec3 place = path.begin + at * path.way;
        const double own = std::exp(-path.tau * at) * shownLocal(place) * length / path.seen;
        const double part = at * double(pieces.all.size());
        Piece& piece = pieces.all[std::min(static_cast<std::size_t>(part), pieces.all.size() - 1)];
        piece.shown += own;
        piece.ws += own * place;
    };
    std::vector<double> ends = m_mesh->crossings(path.begin, path.way);
    ends.push_back(1);
    double s = 0;
    for (const double to : ends)
        while (s < to) {
            const double away = distanceLocal(path.begin + s * path.way) / path.length;
            double end = s + std::max(kOfDistance * away, kLeast);
            if (end > to - 0.5 * kLeast) end = to;
            const double half = 0.5 * (end - s), middle = s + half, beside = half / std::sqrt(3.0);
            add(middle - beside, half);
            add(middle + beside, half);
            s = end;
        }
    for (const Piece& piece : pieces.all)
        if (piece.shown > 0) pieces.all[pieces.count++] = {piece.shown, piece.ws / piece.shown};
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
        pieces.all[pieces.count++] = {shownLocal(path.begin + s * path.way), wsBegin + s * wsPath};
        return pieces;
    }
    if (m_mesh && away <= kEven * path.length) {
        addAcrossMesh(path, pieces);
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
