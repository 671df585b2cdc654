// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/path_tracer.h>

#include <scrim/verify/held_ray.h>
#include <scrim/base/split_mix.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kBoxes = 64;         // number of majorant boxes along the longest axis
constexpr double kRoulette = 0.1;  // a path of less weight than this is ended at random (Russian roulette)
constexpr int kMostScatterings = 100000;

// The unit vector at the given cosine to `axis`, turned around it by `turn` radians.
Vec3 around(const Vec3& axis, double cosine, double turn) {
    const Mat3 frame = frameAround(axis);
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    return glm::normalize(frame * Vec3(sine * std::cos(turn), sine * std::sin(turn), cosine));
}

// The cosine below which a Henyey-Greenstein lobe scatters the fraction `u` of all light.
double lobeCosine(double g, double u) {
    if (std::abs(g) < 1e-4) return 1 - 2 * u;
    const double s = (1 - g * g) / (1 - g + 2 * g * u);
    return std::clamp((1 + g * g - s * s) / (2 * g), -1.0, 1.0);
}

}  // namespace

// The random numbers of S. Vigna's splitmix64.
struct PathTracer::Random {
    std::uint64_t state;

    double next() {
        const std::uint64_t bits = splitMix(state);
        state += kSplitMixStep;
        return static_cast<double>(bits >> 11) * 0x1p-53;
    }
    double free() { return -std::log(1 - next()); }  // a free path, in mean free paths
};

PathTracer::PathTracer(const ViewScene& scene, FieldSamplers* shared) : m_scene(scene) {
    m_any = anyScattersFully(scene);
    if (!m_any) return;
    m_lights = lightsSent(scene.lights);
    FieldSamplers own;
    for (const ViewVolume& volume : scene.volumes)
        m_volumes.emplace_back(volume, scene.dials.kernel, shared ? *shared : own);
    measure();
}

// Fills the majorants. Every voxel counts in all boxes that its kernel reaches.
void PathTracer::measure() {
    m_wsBounds = wsBounds(m_scene);
    const Vec3 size = m_wsBounds.size();
    m_edge = largest(size) / kBoxes * (1 + 1e-9);
    m_size = glm::max(Int3(glm::ceil(size / m_edge)), Int3(1));
    m_majorants.assign(std::size_t(m_size.x) * std::size_t(m_size.y) * std::size_t(m_size.z), 0.0);
    std::vector<double> ofField(m_majorants.size());
    std::vector<bool> glows(m_majorants.size(), false);
    const auto mark = [&](const ViewField& field, const auto& set) {
        const double reach = kernelRadius(field.kernel.value_or(m_scene.dials.kernel));
        const auto add = [&](const Int3& from, const Int3& to, double value) {
            const Bounds box = transformed(field.wsFromIs, {Vec3(from) - reach, Vec3(to) + reach});
            const Int3 first = glm::max(Int3(glm::floor((box.lower - m_wsBounds.lower) / m_edge)), Int3(0));
            const Int3 last = glm::min(Int3(glm::floor((box.upper - m_wsBounds.lower) / m_edge)), m_size - 1);
            for (int z = first.z; z <= last.z; ++z)
                for (int y = first.y; y <= last.y; ++y)
                    for (int x = first.x; x <= last.x; ++x)
                        set((std::size_t(z) * std::size_t(m_size.y) + std::size_t(y)) * std::size_t(m_size.x) +
                                std::size_t(x),
                            value);
        };
        const SparseField& f = *field.field;
        for (std::size_t b = 0; b < f.blockCount(); ++b)
            for (int i = 0; i < kBlockVoxels; ++i) {
                if (f.block(b)[i] <= 0) continue;
                const Int3 at = f.blockOrigins[b] + Int3(i / 64, i / 8 % 8, i % 8);
                add(at, at, f.block(b)[i]);
            }
        for (const ConstantTile& tile : f.tiles) add(tile.origin, tile.origin + tile.edge - 1, tile.value);
    };
    for (const ViewVolume& volume : m_scene.volumes) {
        if (!volume.field->empty()) {
            std::fill(ofField.begin(), ofField.end(), 0.0);
            mark(densityOf(volume),
                 [&](std::size_t box, double value) { ofField[box] = std::max(ofField[box], value); });
            for (std::size_t i = 0; i < m_majorants.size(); ++i)
                if (ofField[i] > 0)
                    m_majorants[i] += volume.classified ? mostExtinction(*volume.classified, ofField[i])
                                                        : ofField[i] * volume.medium.mostExtinction();
        }
        for (const ViewEmission& emission : volume.emission)
            mark(emission.field, [&](std::size_t box, double) { glows[box] = true; });
    }
    // In boxes that glow, the majorant is large enough for a flight to stop now and then and gather the emission.
    for (std::size_t i = 0; i < m_majorants.size(); ++i)
        if (glows[i]) m_majorants[i] = std::max(m_majorants[i], 2 / m_edge);
}

PathTracer::Matter PathTracer::matterAt(const Vec3& ws) const {
    Matter matter;
    for (const VolumeOptics& v : m_volumes) {
        matter.extinction += v.extinction(ws);
        matter.emission += v.emission(ws);
    }
    return matter;
}

// Calls visit(begin, end, majorant) for the boxes along a ray until it returns false.
template <class Visit>
void PathTracer::forCells(const Vec3& ws, const Vec3& direction, double from, double length, const Visit& visit) const {
    const auto [begin, end] = m_wsBounds.clip(ws, direction, from, length);
    if (!(begin < end)) return;
    const Vec3 origin = (ws - m_wsBounds.lower) / m_edge;
    const Vec3 entry = origin + begin / m_edge * direction;
    Int3 box = glm::clamp(Int3(glm::floor(entry)), Int3(0), m_size - 1), step(0);
    Vec3 next(kInfinity), each(kInfinity);
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0) continue;
        step[axis] = direction[axis] > 0 ? 1 : -1;
        each[axis] = m_edge / std::abs(direction[axis]);
        next[axis] = (box[axis] + (step[axis] > 0 ? 1 : 0) - origin[axis]) * m_edge / direction[axis];
    }
    for (double t = begin; t < end;) {
        const int axis = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
        const double to = std::min(next[axis], end);
        const std::size_t at =
            (std::size_t(box.z) * std::size_t(m_size.y) + std::size_t(box.y)) * std::size_t(m_size.x) +
            std::size_t(box.x);
        if (to > t && !visit(t, to, m_majorants[at])) return;
        t = std::max(t, to);
        box[axis] += step[axis];
        next[axis] += each[axis];
        if (box[axis] < 0 || box[axis] >= m_size[axis]) return;
    }
}

// Flies to the next collision by delta tracking. Coloured extinction changes the flight's weight.
PathTracer::Flight PathTracer::fly(const Vec3& ws, const Vec3& direction, double from, double length,
                                   Random& random) const {
    Flight flight;
    forCells(ws, direction, from, length, [&](double begin, double end, double majorant) {
        if (majorant <= 0) return true;
        for (double t = begin + random.free() / majorant; t < end; t += random.free() / majorant) {
            const Matter matter = matterAt(ws + t * direction);
            flight.glow += flight.weight * matter.emission / majorant;
            const double chance = std::min(largest(matter.extinction) / majorant, 1.0);
            if (random.next() < chance) {
                flight.weight *= matter.extinction / (majorant * chance);
                flight.collided = true;
                flight.ws = ws + t * direction;
                return false;
            }
            if (chance < 1) flight.weight *= (majorant - matter.extinction) / (majorant * (1 - chance));
        }
        return true;
    });
    return flight;
}

// Transmittance by ratio tracking.
Rgb PathTracer::transmittance(const Vec3& ws, const Vec3& direction, double length, Random& random) const {
    Rgb left(1);
    forCells(ws, direction, 0, length, [&](double begin, double end, double majorant) {
        if (majorant <= 0) return true;
        for (double t = begin + random.free() / majorant; t < end; t += random.free() / majorant) {
            left *= 1.0 - matterAt(ws + t * direction).extinction / majorant;
            if (largest(left) < 0.05) {
                if (random.next() < 0.5) {
                    left = Rgb(0);
                    return false;
                }
                left *= 2;
            }
        }
        return true;
    });
    return left;
}

SolidHit PathTracer::solidAhead(SolidRole role, const Vec3& ws, const Vec3& direction, double begin) const {
    return m_scene.solids ? m_scene.solids->trace(role, ws, direction, begin, kInfinity) : SolidHit{kInfinity};
}

// The light that arrives from a light before any attenuation. For an extended light, the ray is drawn at random.
Arriving PathTracer::arriving(std::size_t index, const Vec3& ws, Random& random) const {
    if (const LightAt* light = std::get_if<LightAt>(&m_lights[index])) return light->at(ws);
    const double u = random.next(), v = random.next();
    const LightRay ray = std::get<LightRays>(m_lights[index]).ray(ws, {u, v});
    return {ray.weight, -ray.toLight, ray.distance};
}

// The light that arrives directly from those of the lights which are in `lights`, times factor(direction of travel).
template <class Factor>
Rgb PathTracer::lit(const std::vector<bool>& lights, const Vec3& ws, const Factor& factor, Random& random) const {
    Rgb sum(0);
    for (std::size_t i = 0; i < m_scene.lights.size(); ++i) {
        if (!litBy(lights, i)) continue;
        const Arriving in = arriving(i, ws, random);
        Rgb light = in.irradiance * factor(in.travel);
        if (light == Rgb(0)) continue;
        if (m_scene.lights[i].shadows) {
            if (solidAhead(SolidRole::shadow, ws, -in.travel, 0).t < in.distance) continue;
            light *= transmittance(ws, -in.travel, in.distance, random);
        }
        sum += light;
    }
    return sum;
}

// Ends most paths of little weight at random.
bool PathTracer::goesOn(Rgb& weight, Random& random) {
    if (largest(weight) >= kRoulette) return true;
    weight *= 2;
    return random.next() < 0.5;
}

// A collision at `ws` with a path along `direction`, which is `first` if the path comes from the eye. `once`: the path
// was scattered by a volume in which light scatters once; it may be by one. False: the path ends there.
bool PathTracer::scatter(const Vec3& ws, Vec3& direction, bool first, bool& once, Rgb& weight, Rgb& sum,
                         Random& random) const {
    // Draws the volume that scatters the path, or its absorption.
    Rgb extinction(0), all(0);
    std::vector<Rgb> parts(m_volumes.size(), Rgb(0));
    for (std::size_t i = 0; i < m_volumes.size(); ++i) {
        extinction += m_volumes[i].extinction(ws);
        const ViewVolume& own = m_volumes[i].volume();
        if (first && own.holdout) continue;  // it scatters nothing to the eye
        if (scattersFully(own) || (!once && scattersOnce(own))) parts[i] = m_volumes[i].scattering(ws);
        all += parts[i];
    }
    if (largest(all) <= 0) return false;
    double choice = random.next() * largest(all);
    std::size_t drawn = 0;
    while (drawn + 1 < parts.size() && choice >= largest(parts[drawn])) choice -= largest(parts[drawn++]);
    if (largest(parts[drawn]) <= 0) return false;
    const double chance = largest(parts[drawn]) / largest(all);
    for (int c = 0; c < 3; ++c) weight[c] *= extinction[c] > 0 ? parts[drawn][c] / (extinction[c] * chance) : 0;
    const ViewVolume& volume = m_volumes[drawn].volume();
    once = once || !scattersFully(volume);
    const Phase& phase = volume.medium.phase;
    const auto towards = [&](const Vec3& travel) { return phaseValue(phase, -glm::dot(travel, direction)); };
    if (!first) sum += weight * lit(volume.lights, ws, towards, random);
    if (!goesOn(weight, random)) return false;
    // The path is traced backwards, but the phase function depends only on the cosine between its two directions.
    double cosine = 0;
    if (phase.type == PhaseType::rayleigh) {
        cosine = 2 * random.next() - 1;
        weight *= 4 * std::numbers::pi * phaseValue(phase, cosine);
    } else {
        const bool second = phase.type == PhaseType::twoLobe && random.next() < phase.blend;
        cosine = lobeCosine(second ? phase.g2 : phase.g, random.next());
        // Draine's lobe by rejection, which keeps a third of the draws or more.
        while (second && random.next() * (1 + phase.alpha) > 1 + phase.alpha * cosine * cosine)
            cosine = lobeCosine(phase.g2, random.next());
    }
    direction = around(direction, cosine, 2 * std::numbers::pi * random.next());
    return true;
}

// The same for a path that meets a solid, which is lit by all lights: Lambert's law, with
// directions drawn by their cosine.
bool PathTracer::sendBack(const SolidHit& hit, Vec3& ws, Vec3& direction, Rgb& weight, Rgb& sum, Random& random) const {
    weight *= hit.solid->albedo;
    if (largest(weight) <= 0) return false;
    Vec3 normal = glm::normalize(hit.wsNormal);
    if (glm::dot(normal, direction) > 0) normal = -normal;
    // Solids are traced in floats, so the next ray begins beside the surface.
    ws += hit.t * direction + 1e-6 * glm::length(m_scene.solids->wsBounds(SolidRole::shadow).size()) * normal;
    const auto lambert = [&](const Vec3& travel) {
        return std::max(-glm::dot(travel, normal), 0.0) / std::numbers::pi;
    };
    sum += weight * lit({}, ws, lambert, random);
    direction = around(normal, std::sqrt(random.next()), 2 * std::numbers::pi * random.next());
    return goesOn(weight, random);
}

Rgb PathTracer::path(Vec3 ws, Vec3 direction, double begin, double length, const HeldRay& held, Random& random) const {
    const Vec3 eye = ws;
    Rgb weight(1), sum(0);
    SolidHit ahead{length};
    bool once = false;
    for (int scattered = 0; scattered < kMostScatterings; ++scattered) {
        const bool first = scattered == 0;
        const Flight flight = fly(ws, direction, first ? begin : 0, ahead.t, random);
        if (!first) sum += weight * flight.glow;
        weight *= flight.weight;
        if (flight.collided) {
            ws = flight.ws;
            if (first) weight *= held.transmittance(glm::distance(eye, ws));
            if (!scatter(ws, direction, first, once, weight, sum, random)) return sum;
        } else {
            if (first) return sum;
            // What a medium that scatters once gets of ambient light is the reference's.
            if (ahead.t == kInfinity) return scattered == 1 && once ? sum : sum + weight * m_scene.ambient;
            if (!sendBack(ahead, ws, direction, weight, sum, random)) return sum;
        }
        ahead = solidAhead(SolidRole::shadow, ws, direction, 0);
    }
    return sum;
}

Estimate PathTracer::pixel(int x, int y, int paths, std::uint64_t seed) const {
    Estimate out;
    if (!m_any || paths <= 0) return out;
    const RayFamily rays = wsRays(m_scene.camera);
    const int n = m_scene.dials.antialias;
    // Mixed, since seeds that differ by the step of the numbers would give one sequence, shifted.
    Random random{splitMix(splitMix(seed) + std::uint64_t(std::uint32_t(x)) * 0xd1342543de82ef95 +
                           std::uint64_t(std::uint32_t(y)) * 0xaf251af3b0f025b5)};
    Rgb squares(0);
    for (int i = 0; i < paths; ++i) {
        const int ray = i % (n * n);
        const double px = x + (ray % n + 0.5) / n, py = y + (ray / n + 0.5) / n;
        const Vec3 along = rays.direction(px, py);
        const double scale = glm::length(along);
        const Vec3 direction = along / scale, origin = rays.origin(px, py);
        const HeldRay held(m_scene.depths.get(), px, py, scale);
        const double end = std::min(solidAhead(SolidRole::holdout, origin, direction, rays.near * scale).t, held.end());
        const Rgb value = path(origin, direction, rays.near * scale, end, held, random);
        out.mean += value;
        squares += value * value;
    }
    out.mean /= paths;
    out.variance = glm::max(squares / double(paths) - out.mean * out.mean, Rgb(0)) / double(std::max(paths - 1, 1));
    return out;
}

}  // namespace scrim
