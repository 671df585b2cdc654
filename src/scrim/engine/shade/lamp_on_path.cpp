// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/shade/lamp_on_path.h>

#include <scrim/scene/light_at.h>
#include <scrim/scene/phase_over_caps.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

// Gauss' and Legendre's three points in [-1, 1], and their weights.
constexpr std::pair<double, double> kThreePoints[] = {
    {-0.774596669241483, 5.0 / 9}, {0, 8.0 / 9}, {0.774596669241483, 5.0 / 9}};

// Lengths of paths to distances within which 1/r^2 and the angle of scattering are as in the middle.
constexpr double kFar = 0.25;

double angleOf(double cosine) {
    return std::acos(std::clamp(cosine, -1.0, 1.0));
}

// Behind more than some optical depth of a path, its part in front is all that is seen.
LampOnPath::Passage clearer(LampOnPath::Passage passage, double length) {
    constexpr double kMostTau = 2;
    passage.extinction = std::min(passage.extinction, kMostTau / length);
    return passage;
}

// The part of even light that the eye sees over a path of this length, if the light's way through the sheet is `way`.
double seenOfEven(const LampOnPath::Passage& passage, double length, double way) {
    const double eye = passage.extinction * length, light = passage.extinction * way;
    const auto mean = [](double tau) { return tau > 1e-6 ? -std::expm1(-tau) / tau : 1; };
    if (passage.sameSide) return mean(eye + light);
    return std::exp(-std::min(eye, light)) * mean(std::abs(eye - light));
}

}  // namespace

LampOnPath::LampOnPath(const NearOnSheet& light, Real texel, Real thickness)
    : m_light(light),
      m_axis(double(light.axisU), double(light.axisV), double(light.axisW)),
      m_texel(double(texel)),
      m_thickness(double(thickness)),
      m_plane(double(light.distanceW) + double(light.plane)),
      m_least(1e-3 * double(thickness)),
      m_inFront(std::min(2 * double(light.distanceW) / double(thickness), 1.0)),
      m_even(std::numeric_limits<double>::infinity()) {
    constexpr double kOfBorder = 0.4, kOfProfile = 0.05, kOfSlide = 0.125;
    if (light.slideAngle > 0) {
        m_even = kOfSlide * double(light.slideAngle);
        if (light.slideEnds) m_outer = m_inner = std::cos(double(light.slideAngle));
    }
    if (light.cone) {
        m_outer = double(light.cone->cosOuter), m_inner = double(light.cone->cosInner);
        m_even = std::min(m_even, kOfBorder * (angleOf(m_outer) - angleOf(m_inner)));
    }
    if (light.face && light.face->spreadScale > 0) {
        const double tangent = double(light.face->spreadTangent);
        m_outer = 1 / std::sqrt(1 + tangent * tangent), m_inner = 1;
        m_step = 0.25 * std::atan(tangent);
        m_even = std::min(m_even, m_step);
    }
    if (light.profile) {
        m_even = std::min(m_even, kOfProfile);
        m_step = m_step > 0 ? std::min(m_step, 2 * kOfProfile) : 2 * kOfProfile;
    }
    m_limited = std::isfinite(m_even);
    // An element of a surface is one of many, whose sum is even.
    if (!light.face && light.decay) m_even = std::min(m_even, kFar);
}

bool LampOnPath::changes(const SampleTile& samples) const {
    if (m_limited) return true;
    Real steepest = 0;
    for (int k = 0; k < kTileSize; ++k)
        steepest = std::max(steepest, samples.eyeA[k] * samples.eyeA[k] + samples.eyeB[k] * samples.eyeB[k]);
    return m_thickness * std::sqrt(1 + double(steepest)) > m_even * (m_plane - 0.5 * m_thickness);
}

// What the light sends to a path, relative to its intensity, times r^2 over the decay: per angle t.
double LampOnPath::sent(const Ray& ray, double t) const {
    const double cosineOfT = std::cos(t), r2 = ray.nearest * ray.nearest / (cosineOfT * cosineOfT);
    const Vec3 direction = cosineOfT * ray.across + std::sin(t) * ray.along;
    const double cosine = glm::dot(direction, m_axis);
    double part = m_light.decay ? r2 / std::max(r2, double(m_light.ownRadius2)) : r2;
    if (m_light.cone) part *= SpotEdges(m_outer, m_inner).part(cosine);
    if (m_light.profile) {
        const auto& frame = m_light.profile->frame;
        part *= m_light.profile->table->at(
            {glm::dot(frame[0], direction), glm::dot(frame[1], direction), glm::dot(frame[2], direction)});
    }
    if (m_light.face) {
        const double front = std::max(cosine, 0.0), sine = std::sqrt(std::max(1 - front * front, 0.0));
        const double scale = double(m_light.face->spreadScale), tangent = double(m_light.face->spreadTangent);
        part *= scale > 0 ? std::max(front * tangent - sine, 0.0) * scale : front;
    }
    return part;
}

LampOnPath::Path LampOnPath::pathOf(const SampleTile& samples, int k) const {
    const double plane = samples.at ? double(samples.at[k]) - double(samples.step) : 0,
                 part = samples.part ? double(samples.part[k]) : 1;
    return {double(samples.u[k]),    double(samples.v[k]), double(samples.eyeA[k]),
            double(samples.eyeB[k]), plane * m_thickness,  0.5 * part * m_thickness};
}

Vec3 LampOnPath::fromLight(const Path& path) const {
    return {(path.u - double(m_light.texelU)) * m_texel, (path.v - double(m_light.texelV)) * m_texel,
            m_plane + path.plane};
}

LampOnPath::Course LampOnPath::courseOf(const SampleTile& samples, int k) const {
    const Path path = pathOf(samples, k);
    const Vec3 at = fromLight(path);
    const double half = path.half * std::sqrt(1 + path.eyeA * path.eyeA + path.eyeB * path.eyeB), r = glm::length(at);
    const bool cut = m_inFront < 1 && samples.part != nullptr && samples.part[k] < 1;
    if (2 * half <= m_even * r && !cut) return Course::even;
    if (m_outer <= -1) return Course::changing;
    // How far a place is within a cone, or beyond it if this is negative, changes by at most twice the way.
    const double along = glm::dot(at, m_axis);
    if (along - m_outer * r < -2 * half) return Course::dark;
    const bool whole = m_light.cone && m_step == 0 && m_light.slideAngle == 0 && along - m_inner * r > 2 * half;
    return whole && !cut && 2 * half < kFar * r ? Course::even : Course::changing;
}

LampOnPath::Ray LampOnPath::rayOf(const Path& path) const {
    Ray ray{};
    ray.at = fromLight(path);
    ray.half = path.half;
    ray.low = std::max(-path.half, -ray.at.z), ray.high = path.half;
    ray.entry = std::max(-0.5 * m_thickness - path.plane, -ray.at.z);
    if (ray.high <= ray.low) return ray;
    const Vec3 way(path.eyeA, path.eyeB, 1);
    ray.slant = glm::length(way);
    ray.along = way / ray.slant;
    ray.before = glm::dot(ray.at, ray.along);
    const Vec3 foot = ray.at - ray.before * ray.along;
    ray.nearest = std::max(glm::length(foot), m_least);
    ray.across = glm::length(foot) > 1e-3 * m_least ? glm::normalize(foot)
                                                    : glm::normalize(glm::cross(ray.along, Vec3(0.36, 0.48, 0.8)));
    // The cosine to the light's axis is reach * cos(t - turn).
    const double x = glm::dot(m_axis, ray.across), y = glm::dot(m_axis, ray.along), reach = std::sqrt(x * x + y * y);
    ray.lit = reach > m_outer;
    if (!ray.lit) return ray;
    const double begin = std::atan((ray.before + ray.low * ray.slant) / ray.nearest),
                 end = std::atan((ray.before + ray.high * ray.slant) / ray.nearest);
    ray.borders[0] = ray.borders[1] = begin, ray.borders[2] = ray.borders[3] = end;
    if (m_outer > -1) {
        const double turn = std::atan2(y, x), outer = angleOf(m_outer / reach),
                     inner = m_inner < reach ? angleOf(m_inner / reach) : 0, from[] = {-outer, -inner, inner, outer};
        for (int i = 0; i < 4; ++i) ray.borders[i] = std::clamp(turn + from[i], begin, end);
    }
    ray.lit = ray.borders[3] > ray.borders[0];
    return ray;
}

// In how many pieces a part of a path is to be asked. `lobe`: the width of that of a phase function, radians.
int LampOnPath::piecesOf(const Ray& ray, double width, double lobe) const {
    constexpr double kMost = 32, kWide = 0.5, kLobes = 2;
    constexpr int kWithin = 4;
    const double step = std::min(m_step > 0 ? m_step : kWide, kLobes * lobe);
    const int pieces = static_cast<int>(std::clamp(std::ceil(width / step), 1.0, kMost));
    const bool flat = !m_light.decay || ray.nearest * ray.nearest < double(m_light.ownRadius2);
    return flat ? std::max(pieces, kWithin) : pieces;
}

// Calls visit(t, place, light) for some angles of a path that is lit; the sum of `light` is the
// integral, per angle, of what the light sends and the eye sees.
template <class Visit>
void LampOnPath::forPoints(const Ray& ray, const Passage& passage, double lobe, const Visit& visit) const {
    // Light that comes more aslant has come through more of the sheets before.
    const double slant = glm::length(ray.at) / std::max(ray.at.z, m_least),
                 perSlant = ray.at.z + ray.entry > m_least ? passage.entry / slant : 0;
    const auto seen = [&](double t, double place) {
        constexpr double kMost = 2;  // a clamp for middles of paths that are far from where the light is
        const double eye = (ray.half + (passage.sameSide ? place : -place)) * ray.slant;
        // The light's way within the sheet, which begins at its face or at the light.
        const double z = std::max(ray.at.z + place, m_least), along = ray.nearest / (std::cos(t) * z),
                     way = along * std::clamp(place - ray.entry, 0.0, z),
                     before = std::clamp(perSlant * (along - slant), -kMost, kMost);
        return std::exp(-passage.extinction * (eye + (passage.attenuated ? way : 0)) - before);
    };
    for (int i = 0; i < 3; ++i) {
        const double width = ray.borders[i + 1] - ray.borders[i];
        if (width <= 0) continue;
        const int pieces = piecesOf(ray, width, lobe);
        for (int piece = 0; piece < pieces; ++piece)
            for (const auto& [point, weight] : kThreePoints) {
                const double step = 0.5 * width / pieces, t = ray.borders[i] + (2 * piece + 1 + point) * step;
                const double place = std::clamp(ray.place(t), ray.low, ray.high);
                visit(t, place, weight * step * sent(ray, t) * seen(t, place));
            }
    }
}

LampOnPath::Mean LampOnPath::over(const SampleTile& samples, int k, const Passage& passage) const {
    const Path path = pathOf(samples, k);
    const Ray ray = rayOf(path);
    if (!ray.lit) return {};
    const Passage clear = clearer(passage, 2 * path.half * ray.slant);
    double sum = 0, places = 0;
    forPoints(ray, clear, std::numbers::pi, [&](double, double place, double light) {
        sum += light;
        places += light * place;
    });
    if (!(sum > 0)) return {};
    const double place = std::clamp(places / sum, ray.low, ray.high), z = std::max(ray.at.z + place, m_least);
    const double a = (ray.at.x + place * path.eyeA) / z, b = (ray.at.y + place * path.eyeB) / z;
    const double way = clear.attenuated ? std::sqrt(1 + a * a + b * b) : 0;
    // The path is nearest dt / cos(t)^2 long, and 1/r^2 is cos(t)^2 / nearest^2.
    // What is behind the light gets none: as much of whole sheets as its intensity says, but more
    // or less of the part that an eye within the sheet sees.
    const double mean = sum / (ray.nearest * 2 * path.half * m_inFront * ray.slant);
    // That part is shown as its share of the opacity of a whole sheet, on which light is even.
    const double whole = clear.extinction * m_thickness * ray.slant, part = 2 * path.half / m_thickness;
    const double share = whole > 1e-6 ? std::expm1(-part * whole) / std::expm1(-whole) : part;
    return {part * mean / (share * seenOfEven(clear, m_thickness * ray.slant, m_thickness * way)), a, b};
}

double LampOnPath::phaseOver(const SampleTile& samples, int k, const Passage& passage, const Phase& phase) const {
    const Path path = pathOf(samples, k);
    const Ray ray = rayOf(path);
    const double toEye = passage.sameSide ? -1 : 1;
    double sum = 0, all = 0;
    if (ray.lit)
        forPoints(ray, clearer(passage, 2 * path.half * ray.slant), lobeWidth(phase),
                  [&](double t, double, double light) {
                      sum += light * phaseValue(phase, toEye * std::sin(t));
                      all += light;
                  });
    return all > 0 ? sum / all : 0;
}

void LampOnPath::takePart(const SampleTile& samples, const Ray* rays, int i, int count, Part& out) const {
    if (i == 0) out.samples = samples;
    for (int k = 0; k < kTileSize; ++k) {
        const Ray& ray = rays[k];
        const Path path = pathOf(samples, k);
        double low = -path.half, high = path.half, light = 0;
        if (ray.lit) {
            const double first = ray.borders[0], step = (ray.borders[3] - first) / count;
            low = std::clamp(ray.place(first + i * step), low, high);
            high = std::clamp(ray.place(first + (i + 1) * step), low, high);
            for (const auto& [point, weight] : kThreePoints)
                light += weight * step * sent(ray, first + (i + 0.5 + 0.5 * point) * step);
        } else if (i > 0) {
            continue;
        }
        const double middle = 0.5 * (low + high);
        out.samples.u[k] = static_cast<Real>(path.u + middle * path.eyeA / m_texel);
        out.samples.v[k] = static_cast<Real>(path.v + middle * path.eyeB / m_texel);
        out.parts[k] = static_cast<Real>((high - low) / m_thickness);
        out.places[k] = static_cast<Real>((path.plane + middle) / m_thickness) + samples.step;
        out.light[k] = static_cast<Real>(light);
    }
    out.samples.part = out.parts;
    out.samples.at = out.places;
}

bool LampOnPath::average(const SampleTile& samples, const bool (&wanted)[kTileSize], int rows,
                         const std::function<void(const SampleTile& part, Real* values)>& meets, Real* means) const {
    constexpr int kParts = 6;
    bool changes = false;
    Course courses[kTileSize];
    for (int k = 0; k < kTileSize; ++k) {
        courses[k] = limited() && wanted[k] ? courseOf(samples, k) : Course::dark;
        changes = changes || courses[k] == Course::changing;
    }
    if (!changes) return false;
    thread_local Part part;
    thread_local Ray rays[kTileSize];
    bool lit = false;
    for (int k = 0; k < kTileSize; ++k) {
        rays[k] = courses[k] == Course::changing ? rayOf(pathOf(samples, k)) : Ray{};
        lit = lit || rays[k].lit || courses[k] == Course::even;
    }
    alignas(64) Real values[kMostRows * kTileSize];
    alignas(64) Real all[kTileSize] = {};
    std::fill_n(means, std::size_t(rows) * kTileSize, Real(0));
    for (int n = 0; lit && n < kParts; ++n) {
        takePart(samples, rays, n, kParts, part);
        meets(part.samples, values);
        for (int k = 0; k < kTileSize; ++k) {
            if (courses[k] == Course::even) part.light[k] = n == 0 ? Real(1) : Real(0);
            all[k] += part.light[k];
        }
        for (int i = 0; i < rows * kTileSize; ++i) means[i] += part.light[i % kTileSize] * values[i];
    }
    for (int i = 0; i < rows * kTileSize; ++i)
        if (all[i % kTileSize] > 0) means[i] /= all[i % kTileSize];
    return true;
}

}  // namespace scrim
