// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/reference.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Empty space is measured in balls of this many voxels: half a block's edge.
constexpr double kEmptyRadius = 4;

// A step passes over at most this many pixels of a slide, unless that takes more than so many steps for one.
constexpr double kSlidePixels = 0.5;
constexpr double kMostSlideSteps = 64;

}  // namespace

Reference::Reference(const ViewScene& scene, const ReferenceOptions& options)
    : m_scene(scene), m_options(options), m_voxel(voxelUnit(scene)) {
    m_step = options.step * m_voxel;
    // A transfer function may jump within a voxel.
    for (const ViewVolume& volume : scene.volumes)
        if (volume.classified) m_step = std::min(m_step, options.classifiedStep * m_voxel);
    for (const Vec3& corner : wsCorners(scene)) m_wsBounds.include(corner);
    for (const Light& light : scene.lights)
        m_slides.push_back(light.slide ? std::optional(slideMap(light)) : std::nullopt);
    for (const ViewVolume& volume : scene.volumes) {
        if (volume.field->empty()) continue;
        const Mat4 isFromWs = glm::inverse(volume.wsFromIs);
        double longest = 0;
        for (int axis = 0; axis < 3; ++axis) longest = std::max(longest, glm::length(Vec3(isFromWs[axis])));
        m_volumes.push_back(
            {FieldProbe(*volume.field, scene.dials.kernel), isFromWs, &volume, longest * std::sqrt(3.0)});
    }
}

// The part of a step that the pixels of slides allow: light that varies within a step would be missed.
double Reference::slideStep(const Vec3& ws, const Vec3& direction, double step) const {
    double most = 1;
    for (const auto& map : m_slides) {
        if (!map) continue;
        const Vec3 a = map->homogeneous(ws), b = map->homogeneous(ws + step * direction);
        if (a.z > 0 && b.z > 0)
            most = std::max(most, glm::distance(Vec2(a) / a.z, Vec2(b) / b.z) / kSlidePixels);
        else if (a.z > 0 || b.z > 0)
            most = kMostSlideSteps;  // into the light, or out of it
    }
    return step / std::min(most, kMostSlideSteps);
}

double Reference::extinction(const Vec3& ws) const {
    double sum = 0;
    for (const Volume& v : m_volumes) sum += extinction(v, ws);
    return sum;
}

double Reference::extinction(const Volume& v, const Vec3& ws) const {
    const double value = v.probe.value(transformPoint(v.isFromWs, ws));
    return v.look->classified ? classify(*v.look->classified, value).extinction : v.look->medium.densityScale * value;
}

// Central differences over a voxel on either side, along the lattice's axes.
Vec3 Reference::gradient(const Volume& v, const Vec3& ws) const {
    const Vec3 is = transformPoint(v.isFromWs, ws);
    Vec3 difference;
    for (int axis = 0; axis < 3; ++axis) {
        Vec3 step(0);
        step[axis] = 1;
        difference[axis] = v.probe.value(is + step) - v.probe.value(is - step);
    }
    return glm::transpose(Mat3(v.isFromWs)) * (0.5 * difference);
}

// A distance within which all fields are 0; 0 where none is known.
double Reference::emptyDistance(const Vec3& ws) const {
    double distance = kInfinity;
    for (const Volume& v : m_volumes) {
        if (!v.probe.emptyAround(transformPoint(v.isFromWs, ws), kEmptyRadius)) return 0;
        distance = std::min(distance, kEmptyRadius / v.isPerWs);
    }
    return distance;
}

Reference::Span Reference::clip(const Vec3& o, const Vec3& d, double begin, double end) const {
    for (int axis = 0; axis < 3; ++axis) {
        double a = (m_wsBounds.lower[axis] - o[axis]) / d[axis], b = (m_wsBounds.upper[axis] - o[axis]) / d[axis];
        if (d[axis] == 0) {
            const bool inside = o[axis] >= m_wsBounds.lower[axis] && o[axis] <= m_wsBounds.upper[axis];
            a = inside ? -kInfinity : kInfinity;
            b = inside ? kInfinity : -kInfinity;
        }
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
    }
    return {begin, end};
}

double Reference::opticalDepth(const Vec3& a, const Vec3& b) const {
    const double length = glm::distance(a, b);
    if (length == 0 || m_volumes.empty()) return 0;
    const Vec3 direction = (b - a) / length;
    const Span span = clip(a, direction, 0, length);
    // Steps of two-point Gauss quadrature, exact for the cubics of a trilinear field within a cell.
    const double gauss = 0.5 / std::sqrt(3.0);
    double tau = 0;
    for (double t = span.begin; t < span.end;) {
        if (const double empty = emptyDistance(a + t * direction); empty > 0) {
            t += empty;
            continue;
        }
        const double step = std::min(m_step, span.end - t);
        const Vec3 middle = a + (t + 0.5 * step) * direction;
        const double lower = extinction(middle - gauss * step * direction);
        const double upper = extinction(middle + gauss * step * direction);
        tau += 0.5 * step * (lower + upper);
        t += step;
    }
    return tau;
}

// Reflected radiance per world unit and unit of irradiance (ZC02 eq. 3).
Rgb Reference::reflect(const Volume& v, const Vec3& ws, const Vec3& toLight, const Vec3& toEye) const {
    const Classified& look = *v.look->classified;
    const ClassifiedValue value = classify(look, v.probe.value(transformPoint(v.isFromWs, ws)));
    if (value.extinction == 0) return Rgb(0);
    const Vec3 slope = gradient(v, ws);
    const double length = glm::length(slope);
    const Vec3 normal = length > 0 ? -slope / length : Vec3(0);
    const Reflected share = phong(look, normal, normalWeight(look, length, m_voxel), toLight, toEye);
    return value.extinction / std::acos(-1.0) * (share.diffuse * value.color + share.specular);
}

// Radiance per world unit that one light adds at `ws`.
Rgb Reference::scatter(const Light& light, const Vec3& ws, const Vec3& eye) const {
    Vec3 travel = light.wsDirection;
    double irradiance = 1, distance = 0;
    if (light.type != LightType::distant) {
        travel = ws - light.wsPosition;
        distance = glm::length(travel);
        if (distance == 0) return Rgb(0);
        travel /= distance;
        if (light.decay) irradiance = 1 / std::max(distance * distance, light.radius * light.radius);
        if (light.type == LightType::spot) {
            const double half = 0.5 * light.coneAngle * std::acos(-1.0) / 180;
            const double outer = std::cos(half), inner = std::cos(std::min(half * (1 - light.blend), half - 1e-4));
            const double t = std::clamp((glm::dot(travel, light.wsDirection) - outer) / (inner - outer), 0.0, 1.0);
            irradiance *= t * t * (3 - 2 * t);
        }
    }
    Rgb scattering(0);
    for (const Volume& v : m_volumes) {
        if (v.look->classified) {
            scattering += reflect(v, ws, -travel, -eye);
            continue;
        }
        const double phase = phaseValue(v.look->medium.phase, -glm::dot(travel, eye));
        scattering += extinction(v, ws) * phase * v.look->medium.albedo;
    }
    Rgb radiance = light.intensity * irradiance * scattering;
    if (light.slide)
        radiance *= slideValue(light, *m_slides[static_cast<std::size_t>(&light - m_scene.lights.data())], ws);
    if (radiance == Rgb(0)) return radiance;
    if (light.shadows) {
        const Vec3 from = light.type == LightType::distant
                              ? ws - travel * (clip(ws, -travel, 0, kInfinity).end + m_voxel)
                              : light.wsPosition;
        radiance *= std::exp(-opticalDepth(from, ws));
    }
    return radiance;
}

Reference::Sample Reference::sample(const Vec3& ws, const Vec3& eye) const {
    Sample out;
    out.extinction = extinction(ws);
    if (out.extinction == 0) return out;
    for (const Light& light : m_scene.lights) out.source += scatter(light, ws, eye);
    for (const Volume& v : m_volumes) {
        if (v.look->classified) {
            const ClassifiedValue value = classify(*v.look->classified, v.probe.value(transformPoint(v.isFromWs, ws)));
            out.source += value.extinction * v.look->classified->ambient * value.color * m_scene.ambient;
        } else {
            out.source += extinction(v, ws) * v.look->medium.albedo * m_scene.ambient;
        }
    }
    return out;
}

std::array<double, 4> Reference::ray(double x, double y) const {
    const RayFamily rays = wsRays(m_scene.camera);
    const Vec3 origin = rays.origin(x, y);
    Vec3 direction = rays.direction(x, y);
    const double depthScale = glm::length(direction);
    direction /= depthScale;
    if (m_volumes.empty()) return {0, 0, 0, 0};

    const Span span = clip(origin, direction, rays.near * depthScale, kInfinity);
    const double gauss = 0.5 / std::sqrt(3.0);
    Rgb radiance(0);
    double tau = 0;
    for (double t = span.begin; t < span.end && std::exp(-tau) > m_options.leastTransmittance;) {
        if (const double empty = emptyDistance(origin + t * direction); empty > 0) {
            t += empty;
            continue;
        }
        // A step is as long as its optical depth allows.
        double step = std::min(m_step, span.end - t);
        step = slideStep(origin + t * direction, direction, step);
        for (int halvings = 0; halvings < 40; ++halvings) {
            const double densest =
                std::max({extinction(origin + t * direction), extinction(origin + (t + 0.5 * step) * direction),
                          extinction(origin + (t + step) * direction)});
            if (densest * step <= m_options.mostTau) break;
            step = std::max(0.5 * step, m_options.mostTau / densest);
            if (step * densest <= m_options.mostTau * 1.0001) break;
        }
        // Two Gauss points; each sees half of the step's optical depth in front of or behind it.
        const double middle = t + 0.5 * step;
        const Sample near = sample(origin + (middle - gauss * step) * direction, direction);
        const Sample far = sample(origin + (middle + gauss * step) * direction, direction);
        const double stepTau = 0.5 * step * (near.extinction + far.extinction);
        const double fraction = 0.5 - gauss;
        radiance += 0.5 * step *
                    (near.source * std::exp(-tau - fraction * step * near.extinction) +
                     far.source * std::exp(-tau - stepTau + fraction * step * far.extinction));
        tau += stepTau;
        t += step;
    }
    return {radiance.x, radiance.y, radiance.z, -std::expm1(-tau)};
}

std::array<double, 4> Reference::pixel(int x, int y) const {
    const int n = m_scene.dials.antialias;
    std::array<double, 4> sum{0, 0, 0, 0};
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const std::array<double, 4> one = ray(x + (i + 0.5) / n, y + (j + 0.5) / n);
            for (std::size_t c = 0; c < 4; ++c) sum[c] += one[c] / (n * n);
        }
    return sum;
}

}  // namespace scrim
