// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/held_ray.h>
#include <scrim/geometry/even_points.h>
#include <scrim/verify/reference.h>
#include <scrim/base/split_mix.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/image/sky_parts.h>
#include <scrim/scene/phase_over_caps.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The most pixels of a slide that one step may cross; a step is divided into at most kMostSlideSteps for this.
constexpr double kSlidePixels = 0.5;
constexpr double kMostSlideSteps = 64;

// Two random numbers in [0, 1) that depend only on the place and the light, so that every
// evaluation gives the same result.
Vec2 lotOf(const Vec3& ws, std::size_t light) {
    std::uint64_t state = kSplitMixStep * (light + 1);
    for (int axis = 0; axis < 3; ++axis) state = splitMix(state + std::bit_cast<std::uint64_t>(ws[axis]));
    const auto number = [](std::uint32_t bits) { return bits * 0x1p-32; };
    return {number(static_cast<std::uint32_t>(state)), number(static_cast<std::uint32_t>(state >> 32))};
}

}  // namespace

// The peak of a phase function, straight on, which rays to an extended light seldom meet. It is what is above a
// parabola that goes on as the phase function does kEdge radians from there, and has directions of its own.
class PhasePeak {
  public:
    // Null where there is none to speak of.
    static std::shared_ptr<const PhasePeak> of(const Phase& phase) {
        constexpr double kNarrow = 0.6;
        return lobeWidth(phase) < kNarrow ? std::make_shared<const PhasePeak>(phase) : nullptr;
    }
    explicit PhasePeak(const Phase& phase) : m_phase(phase) {
        const double step = 1e-4;
        m_edge = phaseValue(phase, std::cos(kEdge));
        m_slope = (phaseValue(phase, std::cos(kEdge + step)) - m_edge) / step;
        // Angles are the more the narrower: edge u^3.
        m_sums.push_back(0);
        for (int i = 0; i < kSteps; ++i) {
            const double a = angleAt(i), b = angleAt(i + 1), middle = 0.5 * (a + b);
            m_sums.push_back(m_sums.back() +
                             2 * std::numbers::pi * (std::cos(a) - std::cos(b)) * above(std::cos(middle)));
        }
    }
    // Per steradian.
    double above(double cosine) const {
        const double angle = std::acos(std::clamp(cosine, -1.0, 1.0)), t = angle / kEdge;
        if (t >= 1) return 0;
        return std::max(phaseValue(m_phase, cosine) - (m_edge - 0.5 * m_slope * kEdge * (1 - t * t)), 0.0);
    }
    double mass() const { return m_sums.back(); }
    // A direction around `axis` for a point of the unit square; all have the same part of the mass.
    Vec3 direction(const Vec3& axis, const Vec2& square) const {
        const double at = square.x * mass();
        const auto next = std::upper_bound(m_sums.begin() + 1, m_sums.end() - 1, at);
        const double before = *(next - 1), part = *next > before ? (at - before) / (*next - before) : 0.5;
        const int i = static_cast<int>(next - m_sums.begin()) - 1;
        const double a = std::cos(angleAt(i)), cosine = a + part * (std::cos(angleAt(i + 1)) - a);
        const double sine = std::sqrt(std::max(1 - cosine * cosine, 0.0)), turn = 2 * std::numbers::pi * square.y;
        const Mat3 frame = frameAround(axis);
        return cosine * axis + sine * (std::cos(turn) * frame[0] + std::sin(turn) * frame[1]);
    }

  private:
    static constexpr double kEdge = 0.5;
    static constexpr int kSteps = 400;
    static double angleAt(int i) { return kEdge * std::pow(double(i) / kSteps, 3); }

    Phase m_phase;
    double m_edge, m_slope;
    std::vector<double> m_sums;  // of the peak up to each angle
};

Reference::Reference(const ViewScene& scene, const ReferenceOptions& options, FieldSamplers* shared)
    : m_scene(scene), m_options(options), m_voxel(voxelUnit(scene)) {
    m_step = options.step * m_voxel;
    // A transfer function may jump within a voxel.
    for (const ViewVolume& volume : scene.volumes)
        if (volume.classified) m_step = std::min(m_step, options.classifiedStep * m_voxel);
    m_wsBounds = wsBounds(scene);
    if (hasBackdrop(scene)) m_backdrop = std::make_unique<const Backdrop>(scene, planForBackdrop(scene), [] {});
    m_lights = lightsSent(scene.lights);
    // The error of n x n rays shrinks at least as 1 / n^2, and samples along an eye ray have independent errors.
    // The light of a mesh jumps from triangle to triangle, so it takes more.
    constexpr int kFewest = 6, kMost = 24;
    const bool mesh = std::ranges::any_of(
        scene.lights, [](const Light& light) { return light.area() && light.area()->shape == AreaShape::mesh; });
    if (m_options.lightRays == 0)
        m_options.lightRays = std::clamp(
            static_cast<int>(std::lround((mesh ? 1.2 : 0.8) / std::sqrt(scene.dials.lightError))), kFewest, kMost);
    FieldSamplers own;
    for (const ViewVolume& volume : scene.volumes) {
        m_volumes.emplace_back(volume, scene.dials.kernel, shared ? *shared : own);
        m_peaks.push_back(volume.classified ? nullptr : PhasePeak::of(volume.medium.phase));
    }
}

// Shortens a step so that it crosses at most kSlidePixels of any slide; light that varies within a
// step would be missed.
double Reference::slideStep(const Vec3& ws, const Vec3& direction, double step) const {
    double most = 1;
    for (const auto& light : m_lights) {
        const LightAt* plain = std::get_if<LightAt>(&light);
        const SlideMap* map = plain ? plain->slide() : nullptr;
        if (!map) continue;
        const Vec3 a = map->homogeneous(ws), b = map->homogeneous(ws + step * direction);
        if (a.z > 0 && b.z > 0)
            most = std::max(most, glm::distance(Vec2(a) / a.z, Vec2(b) / b.z) / kSlidePixels);
        else if (a.z > 0 || b.z > 0)
            most = kMostSlideSteps;  // the step enters or leaves the slide's light
    }
    return step / std::min(most, kMostSlideSteps);
}

namespace {

// The angle under which a lamp may see a step from `ws` so that what limits its light changes little in it.
double evenAngle(const Light& lamp, const Vec3& ws) {
    constexpr double kEven = 0.25, kProfile = 0.05, kOfBorder = 0.25, kOfAngle = 0.5;
    double even = lamp.luminaire || lamp.slide ? kProfile : kEven;
    if (const Light::Spot* spot = lamp.spot(); spot && ws != lamp.wsPosition) {
        const SpotEdges edges(*spot);
        const auto angleOf = [](double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)); };
        const double outer = angleOf(edges.outer), inner = angleOf(edges.inner),
                     own = angleOf(glm::dot(glm::normalize(ws - lamp.wsPosition), lamp.wsDirection));
        // Beside the border a step cannot reach it before it has passed the angle up to it.
        even = std::min(even, std::max(kOfBorder * (outer - inner), kOfAngle * std::max(own - outer, inner - own)));
    }
    return even;
}

// What the steps of a ray that meets an area light at a distance from it are to be small beside; none: a mesh.
struct NearArea {
    double distance = 0, size = 0;
};
std::optional<NearArea> nearArea(const Light& light, const Vec3& ws) {
    const Light::Area& area = *light.area();
    const Vec3 p = (ws - light.wsPosition) * lightFrame(light);  // right, up, normal
    const auto beyond = [](double x, double most) { return std::max(std::abs(x) - most, 0.0); };
    const double halfWidth = 0.5 * area.width, halfHeight = 0.5 * area.height;
    switch (area.shape) {
        case AreaShape::sphere:
            return NearArea{std::abs(glm::length(p) - area.radius), area.radius};
        case AreaShape::disk:
            return NearArea{std::hypot(beyond(std::hypot(p.x, p.y), area.radius), p.z), area.radius};
        case AreaShape::cylinder:
            return NearArea{std::hypot(beyond(p.x, halfWidth), std::hypot(p.y, p.z) - area.radius), area.radius};
        case AreaShape::rectangle:
            return NearArea{std::hypot(std::hypot(beyond(p.x, halfWidth), beyond(p.y, halfHeight)), p.z),
                            std::min(area.width, area.height)};
        case AreaShape::mesh:
            break;
    }
    return std::nullopt;
}

}  // namespace

// Near a lamp its light changes over the distance to it, and at a surface it begins. The border of
// a spot's cone, and a luminaire's profile, are directions that it sees.
double Reference::lampStep(const Vec3& ws, double step) const {
    constexpr double kLeast = 0.02, kLeastAtArea = 0.005;
    for (const Light& light : m_scene.lights) {
        if (light.distant() || light.dome()) continue;
        const std::optional<NearArea> near =
            light.area() ? nearArea(light, ws) : NearArea{glm::distance(ws, light.wsPosition), 0.1 * m_voxel};
        if (!near) continue;
        const bool plain = !light.area() || light.area()->shape == AreaShape::sphere;
        step = std::min(step,
                        std::max(evenAngle(light, ws) * near->distance, (plain ? kLeast : kLeastAtArea) * near->size));
    }
    return step;
}

// One bit for each light without extent (the 65th shares that of the first): set where solids block it.
std::uint64_t Reference::blockedLights(const Vec3& ws) const {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < m_lights.size(); ++i) {
        const LightAt* plain = std::get_if<LightAt>(&m_lights[i]);
        if (!plain || !m_scene.lights[i].shadows) continue;
        const Arriving arriving = plain->at(ws);
        if (blocked(ws, -arriving.travel, arriving.distance)) bits ^= std::uint64_t{1} << i % 64;
    }
    return bits;
}

// Shortens a step so that it ends where a solid begins or ceases to block a light: two points of a
// step cannot tell how much of it is lit.
double Reference::edgeStep(const Vec3& ws, const Vec3& direction, double step) const {
    if (!solidsBlock(m_scene)) return step;
    constexpr int kLooks = 4, kHalvings = 12;
    const std::uint64_t before = blockedLights(ws);
    double same = 0;
    for (int i = 1; i <= kLooks; ++i) {
        double other = step * i / kLooks;
        if (blockedLights(ws + other * direction) == before) {
            same = other;
            continue;
        }
        for (int n = 0; n < kHalvings; ++n) {
            const double middle = 0.5 * (same + other);
            (blockedLights(ws + middle * direction) == before ? same : other) = middle;
        }
        return other;
    }
    return step;
}

Rgb Reference::extinction(const Vec3& ws) const {
    Rgb sum(0);
    for (const VolumeOptics& v : m_volumes) sum += v.extinction(ws);
    return sum;
}

Rgb Reference::opticalDepth(const Vec3& a, const Vec3& b, std::optional<std::size_t> light) const {
    return scrim::opticalDepth(m_volumes, m_wsBounds, m_step, a, b, light);
}

// A point on the ray beyond all volumes.
Vec3 Reference::farAway(const Vec3& ws, const Vec3& direction) const {
    return ws + direction * (std::max(0.0, m_wsBounds.clip(ws, direction, 0, kInfinity).second) + m_voxel);
}

// True if a solid is hit from `ws` along the unit vector `toLight` within `distance`.
bool Reference::blocked(const Vec3& ws, const Vec3& toLight, double distance) const {
    return m_scene.solids && m_scene.solids->firstHit(SolidRole::shadow, ws, toLight, 0, distance) < kInfinity;
}

// Radiance per world unit that one light adds at `ws`.
Rgb Reference::scatter(std::size_t index, const Vec3& ws, const Vec3& eye) const {
    const Light& light = m_scene.lights[index];
    const Arriving arriving = std::get<LightAt>(m_lights[index]).at(ws);
    if (arriving.irradiance == Rgb(0)) return Rgb(0);
    Rgb tau(0);
    if (light.shadows) {
        if (blocked(ws, -arriving.travel, arriving.distance)) return Rgb(0);
        tau = opticalDepth(light.distant() ? farAway(ws, -arriving.travel) : light.wsPosition, ws, index);
    }
    return arriving.irradiance * towardsEye(index, ws, arriving.travel, eye, tau);
}

// n x n rays through the square of an extended light's rays. An additive recurrence spreads them evenly (M. Roberts'
// R2), and one random offset per sample shifts them all, so that their errors average out along the eye ray.
std::vector<LightRay> Reference::raysTo(std::size_t index, const Vec3& ws) const {
    const int n = m_options.lightRays;
    const Vec2 offset = lotOf(ws, index);
    std::vector<Vec2> places;
    for (int i = 0; i < n * n; ++i) places.push_back(evenPoint(i, offset));
    return std::get<LightRays>(m_lights[index]).rays(ws, places);
}

Rgb Reference::depthTowards(std::size_t index, const Vec3& ws, const LightRay& ray) const {
    return opticalDepth(std::isinf(ray.distance) ? farAway(ws, ray.toLight) : ws + ray.distance * ray.toLight, ws,
                        index);
}

// As `scatter`, for an extended light.
Rgb Reference::scatterExtended(std::size_t index, const Vec3& ws, const Vec3& eye) const {
    Rgb sum(0);
    const LightRays& rays = std::get<LightRays>(m_lights[index]);
    for (const LightRay& ray : raysTo(index, ws)) {
        Rgb tau(0);
        if (m_scene.lights[index].shadows) {
            if (blocked(ws, ray.toLight, ray.distance)) continue;
            tau = depthTowards(index, ws, ray);
        }
        sum += ray.weight * towardsEye(index, ws, -ray.toLight, eye, tau, &rays);
    }
    sum /= double(m_options.lightRays * m_options.lightRays);
    return rays.knowsRadiance() ? sum + scatterInPeaks(index, ws, eye) : sum;
}

// The light that peaks of phase functions scatter, by rays in them.
Rgb Reference::scatterInPeaks(std::size_t index, const Vec3& ws, const Vec3& eye) const {
    const LightRays& rays = std::get<LightRays>(m_lights[index]);
    const int n = m_options.lightRays;
    Rgb sum(0);
    for (std::size_t v = 0; v < m_volumes.size(); ++v) {
        const ViewVolume& volume = m_scene.volumes[v];
        if (!m_peaks[v] || volume.holdout || !m_volumes[v].hasDensity() || !litBy(volume.lights, index)) continue;
        const PhasePeak& peak = *m_peaks[v];
        const Vec2 offset = lotOf(ws, index + 17);
        Rgb own(0);
        for (int i = 0; i < n * n; ++i) {
            // Light that travels to the eye comes from where the eye looks.
            const Vec3 toLight = peak.direction(eye, evenPoint(i, offset));
            const LightRay ray = rays.from(ws, toLight);
            if (ray.weight == Rgb(0)) continue;
            Rgb tau(0);
            if (m_scene.lights[index].shadows) {
                if (blocked(ws, toLight, ray.distance)) continue;
                tau = depthTowards(index, ws, ray);
            }
            // Rays to the picture of a sky look into the peak, too (E. Veach's balance heuristic).
            const double density = peak.above(glm::dot(toLight, eye)) / peak.mass();
            own += ray.weight * glm::exp(-tau) * (density / (density + rays.density(toLight)));
        }
        sum += m_volumes[v].scattering(ws) * own * (peak.mass() / (n * n));
    }
    return sum;
}

// The part of a phase function, per steradian, that rays to the light are to count in a direction with this cosine.
double Reference::outsideOfPeak(std::size_t index, std::size_t volume, const LightRays& rays, const Vec3& toLight,
                                double cosine) const {
    const double all = phaseValue(m_scene.volumes[volume].medium.phase, cosine);
    if (!m_peaks[volume] || !rays.knowsRadiance()) return all;
    const double above = m_peaks[volume]->above(cosine);
    if (above == 0) return all;
    const double density = above / m_peaks[volume]->mass(), own = std::get<LightRays>(m_lights[index]).density(toLight);
    return all - above * density / (density + own);
}

Rgb Reference::arriving(std::size_t index, const Vec3& ws) const {
    const Light& light = m_scene.lights[index];
    if (!light.shadows) return Rgb(1);
    if (!light.extended())
        return glm::exp(-opticalDepth(light.distant() ? farAway(ws, -light.wsDirection) : light.wsPosition, ws, index));
    Rgb sum(0), all(0);
    for (const LightRay& ray : raysTo(index, ws)) {
        all += ray.weight;
        sum += ray.weight * glm::exp(-depthTowards(index, ws, ray));
    }
    for (int c = 0; c < 3; ++c) sum[c] = all[c] > 0 ? sum[c] / all[c] : 1;
    return sum;
}

// True if a classified volume scatters the light as it does light from all around: that of a dome, but for its suns.
bool Reference::isAround(std::size_t index, const ViewVolume& volume, const Vec3& travel) const {
    const Light& light = m_scene.lights[index];
    if (!light.dome() || !volume.classified->scatters) return false;
    if (!light.slide || !light.slide->parts || !light.slide->parts->smooth) return true;
    return std::ranges::none_of(light.slide->parts->suns, [&](const SkySun& sun) {
        const double cosine = glm::dot(domeDirection(light, sun.u, sun.v), -travel);
        return cosine >= std::cos(glm::radians(0.5 * sun.angle));
    });
}

// Radiance per world unit and unit of irradiance that the volumes send along `eye`, from light that
// arrives along `travel`.
Rgb Reference::towardsEye(std::size_t index, const Vec3& ws, const Vec3& travel, const Vec3& eye, const Rgb& tau,
                          const LightRays* rays) const {
    Rgb sum(0);
    for (std::size_t i = 0; i < m_volumes.size(); ++i) {
        const VolumeOptics& v = m_volumes[i];
        const ViewVolume& volume = v.volume();
        if (!v.hasDensity() || volume.holdout || (!volume.lights.empty() && !volume.lights[index])) continue;
        if (volume.classified) {
            sum += (isAround(index, volume, travel) ? v.scattering(ws) / (4 * std::numbers::pi)
                                                    : v.reflected(ws, m_voxel, -travel, -eye)) *
                   glm::exp(-tau);
            continue;
        }
        const Medium& medium = volume.medium;
        const Rgb coefficient = v.scattering(ws);
        for (int n = 0; n < medium.octaves.count; ++n) {
            const Phase phase = flattened(medium.phase, std::pow(medium.octaves.phase, n));
            const double cosine = -glm::dot(travel, eye);
            const double value =
                n == 0 && rays ? outsideOfPeak(index, i, *rays, -travel, cosine) : phaseValue(phase, cosine);
            sum += std::pow(medium.octaves.contribution, n) * value * coefficient *
                   glm::exp(-std::pow(medium.octaves.extinction, n) * tau);
        }
    }
    return sum;
}

Reference::Sample Reference::sample(const Vec3& ws, const Vec3& eye) const {
    Sample out;
    for (const VolumeOptics& v : m_volumes) {
        const Rgb own = v.extinction(ws);
        out.extinction += own;
        if (v.volume().holdout) continue;
        out.seen += own;
        out.source += v.emission(ws);
    }
    if (largest(out.seen) == 0) return out;
    for (std::size_t i = 0; i < m_scene.lights.size(); ++i)
        out.source += m_scene.lights[i].extended() ? scatterExtended(i, ws, eye) : scatter(i, ws, eye);
    for (const VolumeOptics& v : m_volumes) {
        const ViewVolume& volume = v.volume();
        if (!v.hasDensity() || volume.holdout) continue;
        if (scattersFully(volume)) continue;  // the path tracer computes its ambient light
        if (volume.classified) {
            const ClassifiedValue value = v.classified(ws);
            out.source += value.extinction * volume.classified->ambient * value.color * m_scene.ambient;
        } else {
            out.source += v.scattering(ws) * m_scene.ambient;
        }
    }
    return out;
}

std::array<double, 4> Reference::ray(double x, double y, const std::function<bool()>& late) const {
    const RayFamily rays = wsRays(m_scene.camera);
    const Vec3 origin = rays.origin(x, y);
    Vec3 direction = rays.direction(x, y);
    const double depthScale = glm::length(direction);
    direction /= depthScale;
    const std::array<double, 4> behind = m_backdrop ? m_backdrop->at(x, y) : std::array<double, 4>{};
    if (m_volumes.empty()) return behind;

    auto [begin, end] = m_wsBounds.clip(origin, direction, rays.near * depthScale, m_options.far * depthScale);
    if (m_scene.solids)
        end =
            std::min(end, m_scene.solids->firstHit(SolidRole::holdout, origin, direction, rays.near * depthScale, end));
    const HeldRay held(m_scene.depths.get(), x, y, depthScale);
    end = std::min(end, held.end());
    const double gauss = 0.5 / std::sqrt(3.0);
    Rgb radiance(0), tau(0), shown(0);
    for (double t = begin; t < end && !(late && late()) && std::exp(-smallest(tau)) > m_options.leastTransmittance;) {
        if (const double empty = emptyDistance(m_volumes, origin + t * direction); empty > 0) {
            t += empty;
            continue;
        }
        // The step's optical depth limits its length.
        double step = slideStep(origin + t * direction, direction, std::min(m_step, end - t));
        step = held.limited(t, lampStep(origin + t * direction, step), m_options.mostTau);
        for (int halvings = 0; halvings < 40; ++halvings) {
            const double densest = std::max({largest(extinction(origin + t * direction)),
                                             largest(extinction(origin + (t + 0.5 * step) * direction)),
                                             largest(extinction(origin + (t + step) * direction))});
            if (densest * step <= m_options.mostTau) break;
            step = std::max(0.5 * step, m_options.mostTau / densest);
            if (step * densest <= m_options.mostTau * 1.0001) break;
        }
        step = edgeStep(origin + t * direction, direction, step);
        // Two Gauss points; at each, half of the step's optical depth lies in front of it or behind it.
        const double middle = t + 0.5 * step;
        const double nearT = middle - gauss * step, farT = middle + gauss * step;
        const Sample near = sample(origin + nearT * direction, direction);
        const Sample far = sample(origin + farT * direction, direction);
        const Rgb stepTau = 0.5 * step * (near.extinction + far.extinction);
        const double fraction = 0.5 - gauss;
        const Rgb fromNear =
            0.5 * step * held.transmittance(nearT) * glm::exp(-tau - fraction * step * near.extinction);
        const Rgb fromFar =
            0.5 * step * held.transmittance(farT) * glm::exp(-tau - stepTau + fraction * step * far.extinction);
        radiance += fromNear * near.source + fromFar * far.source;
        shown += fromNear * near.seen + fromFar * far.seen;
        tau += stepTau;
        t += step;
    }
    // If everything that hides is also shown, alpha is 1 - transmittance. Otherwise alpha is summed
    // along the ray like radiance.
    const double hidden = -(std::expm1(-tau.x) + std::expm1(-tau.y) + std::expm1(-tau.z)) / 3;
    const double alpha = holdsOut(m_scene) ? (shown.x + shown.y + shown.z) / 3 : hidden;
    const Rgb all = radiance + glm::exp(-tau) * Rgb(behind[0], behind[1], behind[2]);
    return {all.x, all.y, all.z, alpha + behind[3] * (1 - hidden)};
}

std::array<double, 4> Reference::pixel(int x, int y, const std::function<bool()>& late) const {
    const int n = m_scene.dials.antialias;
    std::array<double, 4> sum{0, 0, 0, 0};
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const std::array<double, 4> one = ray(x + (i + 0.5) / n, y + (j + 0.5) / n, late);
            for (std::size_t c = 0; c < 4; ++c) sum[c] += one[c] / (n * n);
        }
    return sum;
}

}  // namespace scrim
