// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/seen_cells.h>

#include <scrim/base/parallel.h>
#include <scrim/scene/light_at.h>
#include <scrim/scene/optics.h>
#include <scrim/verify/pilot_rays.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr int kRays = 64, kTries = 8;  // rays that see something, and rays for each of them at most
constexpr int kSteps = 64;             // along a ray through the volumes
constexpr double kOpaque = 1e-4;       // transmittance at which a ray ends
constexpr double kFar = 1e300;

double grey(const Rgb& v) {
    return (v.x + v.y + v.z) / 3;
}

// The parts of a ray that are within the boxes of volumes, one after the other.
class WaysWithin {
  public:
    WaysWithin(const std::vector<Bounds>& boxes, const Vec3& origin, const Vec3& direction, double from, double to) {
        for (const Bounds& box : boxes)
            if (const auto way = box.clip(origin, direction, from, to); way.first < way.second) m_ways.push_back(way);
        std::ranges::sort(m_ways);
        std::size_t last = 0;
        for (const auto& [begin, end] : m_ways) {
            if (begin <= m_ways[last].second)
                m_ways[last].second = std::max(m_ways[last].second, end);
            else
                m_ways[++last] = {begin, end};
        }
        if (!m_ways.empty()) m_ways.resize(last + 1);
        for (const auto& [begin, end] : m_ways) m_length += end - begin;
    }

    double length() const { return m_length; }
    // The ray's parameter where `along` of the length is behind it.
    double at(double along) const {
        for (const auto& [begin, end] : m_ways) {
            if (along <= end - begin) return begin + along;
            along -= end - begin;
        }
        return m_ways.back().second;
    }

  private:
    std::vector<std::pair<double, double>> m_ways;
    double m_length = 0;
};

// The scene as the rays see it.
class Look {
  public:
    Look(const ViewScene& scene, const std::vector<CellLight>& fine, const std::vector<CellLight>& other)
        : m_scene(scene), m_cells{&fine, &other}, m_voxel(voxelUnit(scene)) {
        FieldSamplers samplers;
        for (const ViewVolume& volume : scene.volumes) {
            m_volumes.emplace_back(volume, scene.dials.kernel, samplers);
            Bounds& box = m_boxes.emplace_back();
            for (const Vec3& corner : wsCorners(volume, scene.dials.kernel)) box.include(corner);
        }
        for (std::size_t i = 0; i < scene.lights.size(); ++i)
            if (scene.lights[i].intensity != Rgb(0)) m_lights.emplace_back(i, scene.lights[i]);
    }

    // Light that is not on cells or is emitted, and by each size of cells that which is.
    struct Seen {
        double direct = 0, cells[2] = {0, 0}, alpha = 0;
    };
    Seen along(const Vec3& origin, const Vec3& direction, double near, double jitter) const {
        Seen seen;
        const WaysWithin ways(m_boxes, origin, direction, near, kFar);
        if (!(ways.length() > 0)) return seen;
        const double step = ways.length() / kSteps;
        double left = 1;
        for (int i = 0; i < kSteps && left > kOpaque; ++i) {
            const Vec3 ws = origin + ways.at((i + jitter) * step) * direction;
            const double tau = step * extinction(ws), passed = std::exp(-tau);
            // The light of a step is attenuated within the step.
            add(ws, direction, left * step * (tau > 1e-6 ? (1 - passed) / tau : 1), seen);
            left *= passed;
        }
        seen.alpha = 1 - left;
        return seen;
    }

  private:
    double extinction(const Vec3& ws) const {
        double sum = 0;
        for (std::size_t v = 0; v < m_volumes.size(); ++v)
            if (m_boxes[v].contains(ws)) sum += grey(m_volumes[v].extinction(ws));
        return sum;
    }
    void add(const Vec3& ws, const Vec3& direction, double weight, Seen& seen) const {
        for (std::size_t v = 0; v < m_volumes.size(); ++v) {
            if (!m_boxes[v].contains(ws)) continue;
            const ViewVolume& volume = m_volumes[v].volume();
            if (volume.holdout) continue;
            seen.direct += weight * grey(m_volumes[v].emission(ws));
            const Rgb scattering = m_volumes[v].scattering(ws);
            if (scattering == Rgb(0)) continue;
            for (const auto& [number, light] : m_lights)
                if (litBy(volume.lights, number)) seen.direct += weight * grey(lit(light, m_volumes[v], ws, direction));
            for (std::size_t s = 0; s < 2; ++s)
                for (const CellLight& light : *m_cells[s]) {
                    if (!light.ofVolume[v]) continue;
                    Real rgb[3];
                    light.ofVolume[v]->sample(ws, rgb);
                    seen.cells[s] += weight * grey(scattering * Rgb(rgb[0], rgb[1], rgb[2]));
                }
        }
    }
    // What the volume sends against `direction` of the light that comes straight from a light.
    Rgb lit(const LightAt& light, const VolumeOptics& volume, const Vec3& ws, const Vec3& direction) const {
        constexpr int kShadowSteps = 24;
        const Arriving in = light.at(ws);
        if (in.irradiance == Rgb(0)) return Rgb(0);
        const WaysWithin ways(m_boxes, ws, -in.travel, 0, in.distance);
        const double step = ways.length() / kShadowSteps;
        double tau = 0;
        for (int i = 0; i < kShadowSteps && tau < -std::log(kOpaque); ++i)
            tau += step * extinction(ws - ways.at((i + 0.5) * step) * in.travel);
        if (volume.volume().classified)
            return std::exp(-tau) * in.irradiance * volume.reflected(ws, m_voxel, -in.travel, -direction);
        const double phase = phaseValue(volume.volume().medium.phase, -glm::dot(in.travel, direction));
        return volume.scattering(ws) * (phase * std::exp(-tau) * in.irradiance);
    }

    const ViewScene& m_scene;
    const std::vector<CellLight>* m_cells[2];
    double m_voxel;
    std::vector<VolumeOptics> m_volumes;
    std::vector<Bounds> m_boxes;                            // of the volumes, world space
    std::vector<std::pair<std::size_t, LightAt>> m_lights;  // with their numbers in the scene
};

}  // namespace

SeenCells seenCells(const ViewScene& scene, const std::vector<CellLight>& fine, const std::vector<CellLight>& other) {
    const Look eye(scene, fine, other);
    const RayFamily rays = wsRays(scene.camera);
    const Int2 size = scene.camera.resolution;
    double all = 0, onCells = 0, onOther = 0;
    std::vector<std::pair<double, double>> found;  // of each ray: all of its light, and the difference
    for (int first = 0; first < kTries * kRays && found.size() < kRays; first += kRays) {
        std::vector<Look::Seen> seen(kRays);
        parallelFor(seen.size(), [&](std::size_t k) {
            const Vec3 place = pilotPlace(first + static_cast<int>(k));
            const double x = place.x * size.x, y = place.y * size.y;
            seen[k] = eye.along(rays.origin(x, y), glm::normalize(rays.direction(x, y)), rays.near, place.z);
        });
        for (const Look::Seen& s : seen) {
            if (found.size() == kRays || s.alpha < 1e-3) continue;
            found.emplace_back(s.direct + s.cells[0], s.cells[0] - s.cells[1]);
            onCells += s.cells[0];
            onOther += s.cells[1];
            all += s.direct + s.cells[0];
        }
    }
    if (!(all > 0)) return {};
    const double count = double(found.size()), mean = all / count;
    double squares = 0, relative = 0;
    for (const auto& [light, difference] : found) {
        squares += std::pow(difference, 2);
        relative += std::pow(difference / std::max(light, 0.1 * mean), 2);
    }
    return {std::sqrt(squares / count) / mean, std::sqrt(relative / count), onCells / all, onOther / all};
}

}  // namespace scrim
