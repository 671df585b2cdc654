// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/caught_shadow.h>

#include <scrim/base/parallel.h>
#include <scrim/scene/optics.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Optical depth along world-space segments, by steps of one voxel with two-point Gauss quadrature, which is exact for
// the cubics of a trilinear field within a cell.
class Marcher {
  public:
    explicit Marcher(const ViewScene& scene) : m_step(voxelUnit(scene)) {
        FieldSamplers samplers;
        for (const ViewVolume& volume : scene.volumes) {
            if (volume.field->empty()) continue;
            m_volumes.emplace_back(volume, Kernel::linear, samplers);
            for (const Vec3& corner : wsCorners(volume, scene.dials.kernel)) m_wsBounds.include(corner);
        }
    }

    // The optical depth from `origin` along the unit vector `direction`, over `length`.
    Rgb opticalDepth(const Vec3& origin, const Vec3& direction, double length) const {
        Rgb tau(0);
        if (m_volumes.empty()) return tau;
        const auto [begin, end] = m_wsBounds.clip(origin, direction, 0, length);
        const double gauss = 0.5 / std::sqrt(3.0);
        for (double t = begin; t < end; t += m_step) {
            const double step = std::min(m_step, end - t), middle = t + 0.5 * step;
            for (const double at : {middle - gauss * step, middle + gauss * step})
                tau += 0.5 * step * extinction(origin + at * direction);
        }
        return tau;
    }

  private:
    Rgb extinction(const Vec3& ws) const {
        Rgb sum(0);
        for (const VolumeOptics& volume : m_volumes) sum += volume.extinction(ws);
        return sum;
    }

    double m_step;
    Bounds m_wsBounds;
    std::vector<VolumeOptics> m_volumes;
};

// The point on the first solid of the ray at raster position (x, y), if that solid catches shadows.
std::optional<Vec3> caughtAt(const Solids& solids, const RayFamily& rays, double x, double y) {
    const Vec3 origin = rays.origin(x, y), direction = rays.direction(x, y);
    const double caught = solids.firstHit(SolidRole::catcher, origin, direction, rays.near, kInfinity);
    if (caught == kInfinity) return std::nullopt;
    constexpr double kSame = 1e-6;  // relative to the distance: one solid may both catch and hide
    if (solids.firstHit(SolidRole::holdout, origin, direction, rays.near, caught * (1 - kSame)) < kInfinity)
        return std::nullopt;
    return origin + caught * direction;
}

Rgb transmittance(const Marcher& marcher, const Light& light, const Vec3& ws) {
    if (light.distant()) return glm::exp(-marcher.opticalDepth(ws, -light.wsDirection, kInfinity));
    const Vec3 way = light.wsPosition - ws;
    const double distance = glm::length(way);
    return distance > 0 ? glm::exp(-marcher.opticalDepth(ws, way / distance, distance)) : Rgb(1);
}

// The relative weight of a sub-light at a point, without regard to the surface there.
double weightOf(const Light& light, const Vec3& ws) {
    const double power = light.intensity.x + light.intensity.y + light.intensity.z;
    if (!light.element()) return power;
    const Vec3 way = ws - light.wsPosition;
    const double distance2 = std::max(glm::dot(way, way), light.point().radius * light.point().radius);
    if (!(distance2 > 0)) return 0;
    const double facing = std::max(0.0, glm::dot(way, light.wsDirection)) / std::sqrt(distance2);
    return power * facing * Spread(light.element()->spread).at(facing) / distance2;
}

// The transmittance towards a light of the scene, which may consist of several lights.
using Parts = std::vector<const Light*>;

Rgb transmittance(const Marcher& marcher, const Parts& parts, const Vec3& ws) {
    if (parts.size() == 1) return transmittance(marcher, *parts.front(), ws);
    Rgb sum(0);
    double weights = 0;
    for (const Light* part : parts) {
        const double weight = weightOf(*part, ws);
        if (weight <= 0) continue;
        sum += weight * transmittance(marcher, *part, ws);
        weights += weight;
    }
    return weights > 0 ? sum / weights : Rgb(1);
}

// The sub-lights of light `index` of the scene; empty if it casts no shadows.
Parts partsOf(const ViewScene& scene, const SubLights& subLights, std::size_t index) {
    Parts parts;
    if (!scene.lights[index].shadows) return parts;
    if (subLights.owners.empty() && !scene.lights[index].extended()) parts.push_back(&scene.lights[index]);
    for (std::size_t i = 0; i < subLights.owners.size(); ++i)
        if (subLights.owners[i] == static_cast<int>(index)) parts.push_back(&subLights.lights[i]);
    return parts;
}

}  // namespace

std::uint64_t catchShadows(const ViewScene& scene, const SubLights& subLights, Frame& frame,
                           const Checkpoint& checkpoint) {
    struct Caught {
        std::vector<float>* data;
        Parts parts;
    };
    std::vector<Caught> layers;
    for (FrameLayer& layer : frame.layers) {
        if (layer.layer != Layer::shadow) continue;
        std::fill(layer.data.begin(), layer.data.end(), 1.0f);
        Caught caught{&layer.data, partsOf(scene, subLights, std::size_t(layer.light))};
        if (!caught.parts.empty()) layers.push_back(std::move(caught));
    }
    if (layers.empty() || !scene.solids || !scene.solids->any(SolidRole::catcher)) return 0;
    const Marcher marcher(scene);
    const int n = scene.dials.antialias;
    const RayFamily rays = wsRays(supersampled(scene.camera, n));
    const PixelWindow& region = scene.region;
    std::atomic<std::uint64_t> marched = 0;
    const auto catchRow = [&](std::size_t row) {
        const int y = region.y0 + static_cast<int>(row);
        std::uint64_t count = 0;
        for (int x = region.x0; x < region.x1; ++x) {
            const std::size_t at = 3 * (row * std::size_t(region.width()) + std::size_t(x - region.x0));
            for (int i = 0; i < n * n; ++i) {
                const auto ws = caughtAt(*scene.solids, rays, x * n + i % n + 0.5, y * n + i / n + 0.5);
                if (!ws) continue;
                for (const Caught& layer : layers) {
                    const Rgb lost = (1.0 - transmittance(marcher, layer.parts, *ws)) / double(n * n);
                    for (std::size_t c = 0; c < 3; ++c)
                        (*layer.data)[at + c] -= static_cast<float>(lost[static_cast<int>(c)]);
                    count += layer.parts.size();
                }
            }
        }
        marched += count;
    };
    constexpr std::size_t kRows = 32;  // between two checkpoints
    for (std::size_t first = 0; first < std::size_t(region.height()); first += kRows) {
        checkpoint();
        parallelFor(std::min(kRows, std::size_t(region.height()) - first),
                    [&](std::size_t row) { catchRow(first + row); });
    }
    return marched;
}

}  // namespace scrim
