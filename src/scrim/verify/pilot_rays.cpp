// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/pilot_rays.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/plan/sub_lights.h>
#include <scrim/engine/splat/kernel.h>
#include <scrim/scene/classified.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <glm/ext/scalar_constants.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr double kStep = 3, kShadowStep = 3;  // voxels, along rays of eye and lights
constexpr double kLeastShare = 1e-3;          // of a step in what is seen, below which its light does not matter
constexpr double kMostDepth = 7;              // optical depth at which a ray ends
constexpr int kMostSteps = 400;               // of a ray
constexpr double kFar = 1e300;
constexpr std::size_t kMostLights = 3;

// One volume's extinction at points of the world.
class PilotVolume {
  public:
    explicit PilotVolume(const ViewVolume& volume)
        : m_volume(volume), m_field(*volume.field), m_isFromWs(glm::inverse(volume.wsFromIs)) {}

    double extinction(const Vec3& ws) const {
        const double value = m_field.value(transformPoint(m_isFromWs, ws));
        if (value == 0) return 0;
        if (m_volume.classified) return classify(*m_volume.classified, value).extinction;
        return value * m_volume.medium.mostExtinction();
    }

  private:
    const ViewVolume& m_volume;
    LinearProbe m_field;
    Mat4 m_isFromWs;
};

struct PilotLight {
    const Light* light;
    double power;  // irradiance; radiant intensity
};

// The scene as pilots see it. Volumes remember their last block: every thread takes a copy.
class PilotScene {
  public:
    explicit PilotScene(const ViewScene& scene) {
        std::vector<Bounds> bounds;
        for (const ViewVolume& volume : scene.volumes) {
            if (volume.field->empty()) continue;
            m_volumes.emplace_back(volume);
            Bounds& own = bounds.emplace_back();
            for (const Vec3& corner : wsCorners(volume, scene.dials.kernel)) own.include(corner);
            m_bounds.include(own);
        }
        sortIntoCells(bounds);
        m_voxel = voxelUnit(scene);
        for (const Light& light : scene.lights) m_lights.push_back({&light, glm::dot(light.intensity, Rgb(1.0 / 3))});
        std::stable_sort(m_lights.begin(), m_lights.end(),
                         [](const PilotLight& a, const PilotLight& b) { return a.power > b.power; });
        if (m_lights.size() > kMostLights) m_lights.resize(kMostLights);
        // Sheets lie half-way between eye and light; any two axes along them do.
        Vec3 axis = viewingAxis(scene.camera);
        if (!m_lights.empty()) {
            const Vec3 way = -toLight(*m_lights.front().light, m_bounds.center());
            axis = glm::dot(way, axis) >= 0 ? axis + way : axis - way;
        }
        axis = glm::normalize(axis);
        m_u = glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
        m_v = glm::cross(axis, m_u);
    }

    // Radiance of a ray, through the field and through texels of it; nothing where the ray meets nothing.
    struct Seen {
        double exact = 0, texels = 0, alpha = 0;
    };
    Seen look(const Vec3& origin, const Vec3& direction, double jitter) const {
        Seen seen;
        const auto [first, last] = m_bounds.clip(origin, direction, 0, kFar);
        if (!(first < last)) return seen;
        const double step = std::max(kStep * m_voxel, (last - first) / kMostSteps);
        double through[2] = {1, 1}, radiance[2] = {0, 0};
        for (double t = first + jitter * step; t < last; t += step) {
            const Vec3 at = origin + t * direction;
            const double sigma[2] = {extinction(at), texelExtinction(at)};
            if (sigma[0] + sigma[1] <= 0) continue;
            double light[2] = {0, 0};
            if (through[0] * sigma[0] * step > kLeastShare)
                for (const PilotLight& l : m_lights) addLight(l, at, jitter, light);
            for (int i = 0; i < 2; ++i) {
                const double left = std::exp(-sigma[i] * step);
                radiance[i] += through[i] * (1 - left) * light[i];
                through[i] *= left;
            }
            if (std::max(through[0], through[1]) < std::exp(-kMostDepth)) break;
        }
        return {radiance[0], radiance[1], 1 - through[0]};
    }

  private:
    static Vec3 toLight(const Light& light, const Vec3& from) {
        return light.distant() ? -light.wsDirection : glm::normalize(light.wsPosition - from);
    }
    double extinction(const Vec3& ws) const {
        double sum = 0;
        if (!m_cells)
            for (const PilotVolume& volume : m_volumes) sum += volume.extinction(ws);
        else if (m_bounds.contains(ws))
            for (const std::uint32_t v : (*m_cells)[cellOf(ws)]) sum += m_volumes[v].extinction(ws);
        return sum;
    }
    // Of thousands of instances a point lies in a few: which, is known for each cell of a grid.
    static constexpr int kCells = 24;  // along an axis
    using Cells = std::vector<std::vector<std::uint32_t>>;
    int cellAlong(double x, int axis) const {
        const double part = (x - m_bounds.lower[axis]) / std::max(m_bounds.size()[axis], 1e-300);
        return std::clamp(static_cast<int>(part * kCells), 0, kCells - 1);
    }
    std::size_t cellOf(const Vec3& ws) const {
        return std::size_t((cellAlong(ws.x, 0) * kCells + cellAlong(ws.y, 1)) * kCells + cellAlong(ws.z, 2));
    }
    void sortIntoCells(const std::vector<Bounds>& of) {
        constexpr std::size_t kFew = 8;
        if (m_volumes.size() <= kFew) return;
        auto cells = std::make_shared<Cells>(std::size_t(kCells) * kCells * kCells);
        for (std::size_t v = 0; v < of.size(); ++v) {
            Int3 first, last;
            for (int axis = 0; axis < 3; ++axis) {
                first[axis] = cellAlong(of[v].lower[axis], axis);
                last[axis] = cellAlong(of[v].upper[axis], axis);
            }
            for (int x = first.x; x <= last.x; ++x)
                for (int y = first.y; y <= last.y; ++y)
                    for (int z = first.z; z <= last.z; ++z)
                        (*cells)[std::size_t((x * kCells + y) * kCells + z)].push_back(static_cast<std::uint32_t>(v));
        }
        m_cells = std::move(cells);
    }
    // Between the four prefiltered texels around: f - 1/12 (second differences), from which what a bilinear look-up
    // adds on average is missing. Texels at -1 and 2 of a row or column count through that alone.
    double texelExtinction(const Vec3& ws) const {
        const double u = glm::dot(ws, m_u) / m_voxel, v = glm::dot(ws, m_v) / m_voxel;
        const double fu = u - std::floor(u), fv = v - std::floor(v);
        const double wu[4] = {0, 1 - fu, fu, 0}, wv[4] = {0, 1 - fv, fv, 0};
        double sum = 0;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {
                const auto at = [](const double* w, int k) { return k < 0 || k > 3 ? 0.0 : w[k]; };
                const double around = wv[j] * (at(wu, i - 1) + at(wu, i + 1)) + wu[i] * (at(wv, j - 1) + at(wv, j + 1));
                const double weight = wu[i] * wv[j] * (1 + 4.0 / 12) - around / 12;
                if (weight != 0) sum += weight * extinction(ws + m_voxel * ((i - 1 - fu) * m_u + (j - 1 - fv) * m_v));
            }
        return std::max(sum, 0.0);
    }
    void addLight(const PilotLight& l, const Vec3& at, double jitter, double* light) const {
        const Vec3 way = toLight(*l.light, at);
        double power = l.power, most = kFar;
        if (!l.light->distant()) {
            most = glm::distance(l.light->wsPosition, at);
            if (l.light->point().decay) power /= std::max(most * most, 1e-300);
            if (const Light::Spot* spot = l.light->spot();
                spot && glm::dot(-way, l.light->wsDirection) < std::cos(glm::pi<double>() / 360 * spot->coneAngle))
                return;
        }
        if (l.light->element()) power *= glm::dot(-way, l.light->wsDirection);
        if (power <= 0) return;
        double tau[2] = {0, 0};
        if (l.light->shadows) {
            const double last = m_bounds.clip(at, way, 0, most).second;
            const double step = std::max(kShadowStep * m_voxel, last / kMostSteps);
            for (double t = jitter * step; t < last && std::min(tau[0], tau[1]) < kMostDepth; t += step) {
                tau[0] += extinction(at + t * way) * step;
                tau[1] += texelExtinction(at + t * way) * step;
            }
        }
        for (int i = 0; i < 2; ++i) light[i] += power * std::exp(-tau[i]);
    }

    std::vector<PilotVolume> m_volumes;
    std::shared_ptr<const Cells> m_cells;  // null: there are few volumes
    std::vector<PilotLight> m_lights;
    Bounds m_bounds;
    double m_voxel = 1;
    Vec3 m_u, m_v;
};

}  // namespace

double pilotError(const ViewScene& given, int rays) {
    const ViewScene scene = withFewSubLights(given, static_cast<int>(kMostLights));
    const RayFamily family = wsRays(scene.camera);
    const Int2 size = scene.camera.resolution;
    // Additive recurrence over the picture: even, and the same every time.
    const auto place = [](int i, double alpha) {
        const double x = 0.5 + alpha * i;
        return x - std::floor(x);
    };
    constexpr int kTasks = 8, kMostTries = 16;
    struct Sums {
        double squares = 0, values = 0;
        int count = 0;
    };
    const PilotScene whole(scene);
    std::vector<Sums> sums(kTasks);
    parallelFor(kTasks, [&](std::size_t task) {
        const PilotScene pilots(whole);
        Sums& own = sums[task];
        for (int i = static_cast<int>(task); i < kMostTries * rays && own.count * kTasks < rays; i += kTasks) {
            const double x = place(i, 0.7548776662466927) * size.x, y = place(i, 0.5698402909980532) * size.y;
            const auto seen =
                pilots.look(family.origin(x, y), glm::normalize(family.direction(x, y)), place(i, 0.618034));
            if (seen.alpha < 1e-3) continue;
            own.squares += (seen.texels - seen.exact) * (seen.texels - seen.exact);
            own.values += seen.exact;
            ++own.count;
        }
    });
    Sums all;
    for (const Sums& s : sums) {
        all.squares += s.squares;
        all.values += s.values;
        all.count += s.count;
    }
    return all.count > 0 && all.values > 0 ? std::sqrt(all.squares / all.count) / (all.values / all.count) : 0;
}

}  // namespace scrim
