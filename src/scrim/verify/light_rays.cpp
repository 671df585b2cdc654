// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/light_rays.h>

#include <scrim/scene/picture_cells.h>
#include <scrim/solid/mesh_parts.h>
#include <scrim/base/running_sums.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The first t > 0 at which origin + t direction, both across the axis, meets a circle from outside;
// infinity if it does not.
double meetsCircle(const Vec2& origin, const Vec2& direction, double radius) {
    const double a = glm::dot(direction, direction), b = glm::dot(origin, direction);
    const double c = glm::dot(origin, origin) - radius * radius, root = b * b - a * c;
    return a == 0 || c <= 0 || root < 0 || b > 0 ? kInfinity : (-b - std::sqrt(root)) / a;
}

// What is seen of a sun's disk or of a surface that shines from `ws` in a direction (unit); nothing
// beside it. Not for domes and meshes.
struct SeenLight {
    Rgb radiance{0};  // but for a picture
    double distance = kInfinity;
    Vec2 onPicture{0};
};
SeenLight seenLight(const Light& light, const Vec3& ws, const Vec3& toLight) {
    const Light::Area* area = light.area();
    if (!area) {
        const double half = std::sin(glm::radians(0.25 * std::get<Light::Distant>(light.kind).angle));
        const double depth = 2 * half * half;  // 1 - cos of half the angle
        if (!(1 + glm::dot(toLight, light.wsDirection) <= depth)) return {};
        return {light.intensity / (2 * kPi * depth)};
    }
    const Mat3 frame = lightFrame(light);
    const Vec3 from = (ws - light.wsPosition) * frame, way = toLight * frame;  // right, up, normal
    if (area->shape == AreaShape::sphere) {
        const double along = -glm::dot(way, from), r2 = glm::dot(from, from);
        const double inside = area->radius * area->radius - (r2 - along * along);
        if (inside < 0 || along < 0 || r2 <= area->radius * area->radius) return {};
        return {light.intensity, along - std::sqrt(inside)};
    }
    if (area->shape == AreaShape::cylinder) {
        const double t = meetsCircle({from.y, from.z}, {way.y, way.z}, area->radius);
        if (!(std::abs(from.x + t * way.x) <= 0.5 * area->width)) return {};
        return {light.intensity, t};
    }
    if (way.z >= 0 || from.z <= 0) return {};
    const double t = -from.z / way.z, x = from.x + t * way.x, y = from.y + t * way.y;
    const Rgb radiance = Spread(area->spread).at(-way.z) * light.intensity;
    if (area->shape == AreaShape::disk)
        return x * x + y * y <= area->radius * area->radius ? SeenLight{radiance, t} : SeenLight{};
    const double u = x / area->width + 0.5, v = 0.5 - y / area->height;
    if (u < 0 || v < 0 || u > 1 || v > 1) return {};
    return {radiance, t, {u, v}};
}

// 1 - cos of half the angle into which a surface shines.
double depthOfCone(const Light::Area& area) {
    return 1 - std::cos(glm::radians(0.5 * area.spread));
}

// Maps a point of the unit square to a direction around `axis`, uniformly over the solid angle of
// the cone whose half angle has 1 - cos = `depth`.
Vec3 inCone(const Vec3& axis, double depth, const Vec2& p) {
    const Mat3 frame = frameAround(axis);
    const double lower = p.x * depth, r = std::sqrt(std::max(0.0, lower * (2 - lower)));
    return (1 - lower) * axis + r * (std::cos(2 * kPi * p.y) * frame[0] + std::sin(2 * kPi * p.y) * frame[1]);
}

// A rectangle as seen from the origin: C. Urena, M. Fajardo, A. King, "An Area-Preserving Parametrization for Spherical
// Rectangles", 2013. It lies in the plane z = z0 < 0, from (x0, y0) to (x1, y1).
struct SphericalRectangle {
    double x0, y0, x1, y1, z0;
    double b0, b1, k, solidAngle;

    SphericalRectangle(double ax, double ay, double bx, double by, double z) : x0(ax), y0(ay), x1(bx), y1(by), z0(z) {
        const Vec3 v00(x0, y0, z0), v01(x0, y1, z0), v10(x1, y0, z0), v11(x1, y1, z0);
        const auto across = [](const Vec3& a, const Vec3& b) { return glm::normalize(glm::cross(a, b)); };
        const Vec3 n0 = across(v00, v10), n1 = across(v10, v11), n2 = across(v11, v01), n3 = across(v01, v00);
        const auto angle = [](const Vec3& a, const Vec3& b) {
            return std::acos(std::clamp(-glm::dot(a, b), -1.0, 1.0));
        };
        b0 = n0.z;
        b1 = n2.z;
        k = 2 * kPi - angle(n2, n3) - angle(n3, n0);
        solidAngle = angle(n0, n1) + angle(n1, n2) - k;
    }
    Vec2 at(const Vec2& p) const {
        const double au = p.x * solidAngle + k;
        const double fu = (std::cos(au) * b0 - b1) / std::sin(au);
        const double cu = std::clamp((fu > 0 ? 1 : -1) / std::sqrt(fu * fu + b0 * b0), -1.0, 1.0);
        const double x = std::clamp(-(cu * z0) / std::sqrt(std::max(1e-300, 1 - cu * cu)), x0, x1);
        const double d = std::sqrt(x * x + z0 * z0);
        const double h0 = y0 / std::sqrt(d * d + y0 * y0), h1 = y1 / std::sqrt(d * d + y1 * y1);
        const double h = h0 + p.y * (h1 - h0);
        return {x, h * h < 1 - 1e-12 ? std::clamp(h * d / std::sqrt(1 - h * h), y0, y1) : y1};
    }
};

}  // namespace

LightRays::LightRays(const Light& light) : m_light(light), m_frame(lightFrame(light)) {
    if (light.area() && light.area()->surface) {
        constexpr double kTriangles = 500;
        m_mesh = ShiningMesh(cutTriangles(*light.area()->surface, light.area()->area() / kTriangles));
    }
    if (!light.dome() || !light.slide) return;
    const Texture::Level& level = light.slide->image->levels().front();
    double all = 0;
    for (int y = 0; y < level.height; ++y) {
        const double share = std::cos(kPi * y / level.height) - std::cos(kPi * (y + 1) / level.height);
        double row = 0;
        for (int x = 0; x < level.width; ++x) {
            const float* p = level.pixel(x, y);
            m_pixels.push_back(row += double(p[0]) + p[1] + p[2]);
        }
        m_rows.push_back(all += share * row);
    }
    m_sun = sunBeside(*light.slide);
    if (m_sun == nullptr) return;
    m_toSun = domeDirection(light, m_sun->u, m_sun->v);
    const double half = std::sin(glm::radians(0.25 * m_sun->angle)),
                 sun = m_sun->light.x + m_sun->light.y + m_sun->light.z;
    m_sunDepth = 2 * half * half;
    m_sunPart = sun / (sun + all * 2 * kPi / level.width);
}

Rgb LightRays::pictureAt(double u, double v) const {
    if (!m_light.slide) return Rgb(1);
    const Texture::Level& level = m_light.slide->image->levels().front();
    const float* p = level.pixel(std::clamp(static_cast<int>(u * level.width), 0, level.width - 1),
                                 std::clamp(static_cast<int>(v * level.height), 0, level.height - 1));
    return {p[0], p[1], p[2]};
}

LightRay LightRays::fromRectangle(const Vec3& ws, const Vec2& square) const {
    const Light::Area& area = *m_light.area();
    // The rectangle's place as seen from the point: right, up, and the distance of its plane, which is at -height.
    const Vec3 to = m_light.wsPosition - ws;
    const double x = glm::dot(to, m_frame[0]), y = glm::dot(to, m_frame[1]), z = glm::dot(to, m_frame[2]);
    if (z >= 0) return {};
    const double w = 0.5 * area.width, h = 0.5 * area.height;
    const SphericalRectangle seen(x - w, y - h, x + w, y + h, z);
    // At such a distance the angles of the corners cancel to nothing, and the solid angle is taken
    // as area over distance squared.
    constexpr double kTiny = 1e-6;
    const double r2 = glm::dot(to, to);
    const double plain = area.area() * -z / (r2 * std::sqrt(r2));
    const bool isTiny = plain < kTiny;
    const Vec2 at = isTiny ? Vec2(x - w + 2 * w * square.x, y - h + 2 * h * square.y) : seen.at(square);
    const Vec3 hit = at.x * m_frame[0] + at.y * m_frame[1] + z * m_frame[2];
    const double distance = glm::length(hit);
    const double solidAngle = isTiny ? area.area() * -z / (distance * distance * distance) : seen.solidAngle;
    const double aslant = Spread(area.spread).at(-z / distance);
    const Rgb radiance = aslant * m_light.intensity * pictureAt((at.x - x + w) / (2 * w), (h - (at.y - y)) / (2 * h));
    return {hit / distance, distance, radiance * solidAngle};
}

// Polar coordinates around the foot of the perpendicular from the point: the angle there and the
// cosine to the perpendicular.
LightRay LightRays::fromDisk(const Vec3& ws, const Vec2& square) const {
    const double radius = m_light.area()->radius;
    const Vec3 from = ws - m_light.wsPosition;
    const double height = glm::dot(from, m_frame[2]);
    if (height <= 0) return {};
    const Vec3 foot = from - height * m_frame[2];
    const double c = glm::length(foot);
    const Vec3 inwards = c > 0 ? -foot / c : m_frame[0], aside = glm::cross(m_frame[2], inwards);
    double angle = 2 * kPi * square.x, perSquare = 2 * kPi;
    if (c > radius) {
        // The chord vanishes like a square root at either end; a sine substitution makes the integrand smooth.
        const double widest = std::asin(radius / c), t = kPi * (square.x - 0.5);
        angle = widest * std::sin(t);
        perSquare = widest * kPi * std::cos(t);
    }
    const double middle = c * std::cos(angle);
    const double half = std::sqrt(std::max(0.0, radius * radius - c * c * std::sin(angle) * std::sin(angle)));
    const auto cosine = [&](double r) { return height / std::sqrt(height * height + r * r); };
    const double near = cosine(c > radius ? middle - half : 0), far = cosine(middle + half);
    const double cosAt = near + square.y * (far - near), sinAt = std::sqrt(std::max(0.0, 1 - cosAt * cosAt));
    const Vec3 direction = sinAt * (std::cos(angle) * inwards + std::sin(angle) * aside) - cosAt * m_frame[2];
    const double aslant = Spread(m_light.area()->spread).at(cosAt);
    return {direction, height / cosAt, m_light.intensity * (aslant * perSquare * (near - far))};
}

// By the solid angle: an angle across the axis, and the sine of that to the plane across it, which
// lies between those to the ends. Points that are spread over the surface would leave out what is
// next to `ws`, where most of its light comes from.
LightRay LightRays::fromCylinder(const Vec3& ws, const Vec2& square) const {
    const Light::Area& area = *m_light.area();
    const Vec3 from = ws - m_light.wsPosition;
    const double x = glm::dot(from, m_frame[0]), y = glm::dot(from, m_frame[1]), z = glm::dot(from, m_frame[2]),
                 c = std::hypot(y, z);
    if (c <= area.radius) return {};
    const double most = std::asin(area.radius / c), turn = most * (2 * square.y - 1), aside = c * std::sin(turn);
    const double across =
        std::max(c * std::cos(turn) - std::sqrt(std::max(area.radius * area.radius - aside * aside, 0.0)), 1e-12 * c);
    const auto sineTo = [&](double end) { return (end - x) / std::hypot(end - x, across); };
    const double first = sineTo(-0.5 * area.width), last = sineTo(0.5 * area.width),
                 sine = first + square.x * (last - first), cosine = std::sqrt(std::max(1 - sine * sine, 1e-24));
    const Vec3 inwards = -(y * m_frame[1] + z * m_frame[2]) / c, beside = glm::cross(m_frame[0], inwards);
    const Vec3 direction = sine * m_frame[0] + cosine * (std::cos(turn) * inwards + std::sin(turn) * beside);
    return {direction, across / cosine, m_light.intensity * (2 * most * (last - first))};
}

LightRay LightRays::fromSphere(const Vec3& ws, const Vec2& square) const {
    const double radius = m_light.area()->radius;
    const Vec3 to = m_light.wsPosition - ws;
    const double distance = glm::length(to);
    if (distance <= radius) return {};
    const double sine2 = radius * radius / (distance * distance), depth = sine2 / (1 + std::sqrt(1 - sine2));
    const Vec3 direction = inCone(to / distance, depth, square);
    const double along = glm::dot(direction, to);
    const double half = std::sqrt(std::max(0.0, radius * radius - (distance * distance - along * along)));
    return {direction, along - half, m_light.intensity * (2 * kPi * depth)};
}

// Chooses a triangle by the light that its middle sends to `ws`, and a place on it.
LightRay LightRays::fromMesh(const ShiningMesh::Seen& seen, const Vec3& ws, const Vec2& square) const {
    const auto chosen = m_mesh.choose(seen, ws, square.x);
    if (!chosen) return {};
    const TriangleMesh& mesh = m_mesh.mesh();
    const Vec3 to = mesh.place(chosen->triangle, {chosen->rest, square.y}) - ws;
    const double distance = glm::length(to);
    if (!(distance > 0)) return {};
    const double facing = 0.5 * std::max(-glm::dot(mesh.cross(chosen->triangle), to), 0.0) / distance;
    constexpr double kBefore = 1 - 1e-4;  // so that the triangle is not in the way of its own light
    return {to / distance, kBefore * distance, m_light.intensity * (facing / (chosen->chance * distance * distance))};
}

// The radiance of the sun beside the picture, but for the light's colour.
Rgb LightRays::sunAt(const Vec3& toLight) const {
    if (m_sun == nullptr || 1 - glm::dot(toLight, m_toSun) > m_sunDepth) return Rgb(0);
    return sunRadiance(*m_sun, pictureOfDome(m_light, toLight).y);
}

LightRay LightRays::fromSun(const Vec2& square) const {
    const Vec3 toLight = inCone(m_toSun, m_sunDepth, square);
    const Rgb radiance = sunRadiance(*m_sun, pictureOfDome(m_light, toLight).y);
    return {toLight, kInfinity, m_light.intensity * radiance * (2 * kPi * m_sunDepth)};
}

// Chooses a pixel in proportion to its light, and a place within it.
LightRay LightRays::fromPicture(const Vec2& square) const {
    const Texture::Level& level = m_light.slide->image->levels().front();
    if (!(m_rows.back() > 0)) return {};
    const auto [row, down] = findInSums(m_rows, square.x);
    const auto width = static_cast<std::size_t>(level.width);
    const auto [column, across] = findInSums(std::span(m_pixels).subspan(row * width, width), square.y);
    const double top = std::cos(kPi * double(row) / level.height),
                 bottom = std::cos(kPi * double(row + 1) / level.height);
    const double v = std::acos(std::clamp(top + down * (bottom - top), -1.0, 1.0)) / kPi;
    const float* p = level.pixel(static_cast<int>(column), static_cast<int>(row));
    const Rgb value(p[0], p[1], p[2]);
    // The total light, in the colour of this pixel.
    const double total = m_rows.back() * 2 * kPi / level.width;
    return {domeDirection(m_light, (double(column) + across) / level.width, v), kInfinity,
            m_light.intensity * value * (total / (value.x + value.y + value.z))};
}

// True if the cone of directions that a surface shines into is smaller than what it fills of the sky at `ws`.
bool LightRays::sendsIntoLess(const Vec3& ws) const {
    const Light::Area& area = *m_light.area();
    if (area.spread >= 180) return false;
    const Vec3 from = ws - m_light.wsPosition;
    const double height = glm::dot(from, m_frame[2]), r2 = glm::dot(from, from);
    if (height <= 0) return true;
    const double fills = std::min(area.area() * height / (r2 * std::sqrt(r2)), 2 * kPi);
    return 2 * kPi * depthOfCone(area) < fills;
}

double LightRays::density(const Vec3& toLight) const {
    if (!m_light.dome() || !m_light.slide || !(m_rows.back() > 0)) return 0;
    const Vec2 at = pictureOfDome(m_light, toLight);
    const Rgb value = pictureAt(at.x, at.y);
    const double ofPicture =
        (value.x + value.y + value.z) / (m_rows.back() * 2 * kPi / m_light.slide->image->levels().front().width);
    if (m_sun == nullptr) return ofPicture;
    const bool inSun = 1 - glm::dot(toLight, m_toSun) <= m_sunDepth;
    return (1 - m_sunPart) * ofPicture + (inSun ? m_sunPart / (2 * kPi * m_sunDepth) : 0);
}

LightRay LightRays::from(const Vec3& ws, const Vec3& toLight) const {
    if (m_light.dome()) {
        const Vec2 at = m_light.slide ? pictureOfDome(m_light, toLight) : Vec2(0);
        return {toLight, kInfinity, m_light.intensity * (pictureAt(at.x, at.y) + sunAt(toLight))};
    }
    const SeenLight seen = seenLight(m_light, ws, toLight);
    return {toLight, seen.distance, seen.radiance * pictureAt(seen.onPicture.x, seen.onPicture.y)};
}

LightRay LightRays::ray(const Vec3& ws, const Vec2& square) const {
    if (m_light.dome()) {
        if (m_sun != nullptr) {
            const bool sun = square.x < m_sunPart;
            const double part = sun ? m_sunPart : 1 - m_sunPart;
            const Vec2 own((sun ? square.x : square.x - m_sunPart) / part, square.y);
            LightRay ray = sun ? fromSun(own) : fromPicture(own);
            ray.weight /= part;
            return ray;
        }
        if (m_light.slide) return fromPicture(square);
        return {inCone(Vec3(0, 0, 1), 2, square), kInfinity, m_light.intensity * (4 * kPi)};
    }
    if (const Light::Area* area = m_light.area()) {
        if (sendsIntoLess(ws)) {
            const double depth = depthOfCone(*area);
            LightRay ray = from(ws, inCone(-m_frame[2], depth, square));
            ray.weight *= 2 * kPi * depth;
            return ray;
        }
        if (area->shape == AreaShape::rectangle) return fromRectangle(ws, square);
        if (area->shape == AreaShape::mesh) return fromMesh(m_mesh.seenFrom(ws), ws, square);
        if (area->shape == AreaShape::cylinder) return fromCylinder(ws, square);
        return area->shape == AreaShape::disk ? fromDisk(ws, square) : fromSphere(ws, square);
    }
    const double half = std::sin(glm::radians(0.25 * std::get<Light::Distant>(m_light.kind).angle));
    return {inCone(-m_light.wsDirection, 2 * half * half, square), kInfinity, m_light.intensity};
}

std::vector<LightRay> LightRays::rays(const Vec3& ws, std::span<const Vec2> squares) const {
    const bool mesh = m_light.area() && m_light.area()->shape == AreaShape::mesh;
    const ShiningMesh::Seen seen = mesh ? m_mesh.seenFrom(ws) : ShiningMesh::Seen{};
    std::vector<LightRay> all;
    all.reserve(squares.size());
    for (const Vec2& square : squares) {
        all.push_back(mesh ? fromMesh(seen, ws, square) : ray(ws, square));
        if (all.back().weight == Rgb(0)) all.pop_back();
    }
    return all;
}

std::vector<LightSent> lightsSent(const std::vector<Light>& lights) {
    std::vector<LightSent> sent;
    for (const Light& light : lights)
        if (light.extended())
            sent.emplace_back(std::in_place_type<LightRays>, light);
        else
            sent.emplace_back(std::in_place_type<LightAt>, light);
    return sent;
}

}  // namespace scrim
