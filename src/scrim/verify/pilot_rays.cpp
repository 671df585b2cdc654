// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/pilot_rays.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/geometry/even_points.h>
#include <scrim/scene/light_at.h>
#include <scrim/verify/pilot_sheets.h>
#include <scrim/verify/pilot_volume.h>
#include <scrim/volume/coarser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/ext/scalar_constants.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kStep = 3;           // steps of rays, voxels
constexpr double kFlatStep = 0.5;     // the same through flat voxels, whose values change with each along most rays
constexpr double kVeryFlat = 8;       // edges of voxels that take steps half as long
constexpr double kFlatReach = 7;      // voxels by which flat ones that are four times coarser may reach farther
constexpr double kLeastShare = 1e-3;  // steps that contribute less than this to the ray are not lit
constexpr double kMostUnlit = 0.01;   // of a ray through volumes of unlike voxels, between points that are lit
constexpr double kThin = 0.25;        // volumes with less optical depth are lit in finer parts,
constexpr double kThinnest = 1e-4;    // down to this part of these
constexpr double kReach = 2.25;       // of texels: two along one axis, one along the other
constexpr double kMostDepth = 7;      // optical depth at which a ray ends
constexpr int kMostSteps = 400;       // per ray
constexpr int kVoxelsAtEye = 3;
constexpr double kSure = 0.22;  // standard deviation of the mean square, relative to it
constexpr double kFar = 1e300;

// The scene as pilot rays see it.
class PilotScene {
  public:
    /// `like`: the scene whose steps the rays take; null: they are chosen for this one.
    explicit PilotScene(const ViewScene& scene, const PilotScene* like = nullptr)
        : m_rays(wsRays(scene.camera)), m_size(scene.camera.resolution), m_lights(brightestLights(scene)) {
        FieldSamplers samplers;
        std::vector<const ViewVolume*> given;
        for (const ViewVolume& volume : scene.volumes) {
            if (volume.field->empty() && volume.emission.empty()) continue;
            m_bounds.include(m_volumes.emplace_back(volume, samplers, scene, m_lights).bounds);
            given.push_back(&volume);
        }
        if (like != nullptr) m_bounds = like->m_bounds;
        const PilotSheets sheets = pilotSheets(scene, m_lights, m_bounds.center());
        const double across = sheets.across;
        const Mat3 frame = frameAround(sheets.wsAxis);
        m_u = frame[0];
        m_v = frame[1];
        m_flat = like != nullptr ? like->m_flat : across == 1 && anyFlat(scene);
        m_step = like != nullptr ? like->m_step : m_flat ? flatStepOf(scene) : kStep;
        for (std::size_t v = 0; v < m_volumes.size(); ++v) {
            PilotVolume& own = m_volumes[v];
            const double edge = shortestEdge(*given[v]);
            if (m_flat) {
                own.bounds.lower -= kFlatReach * edge;
                own.bounds.upper += kFlatReach * edge;
            }
            own.step = m_step * edge;
            if (like == nullptr) m_bounds.include(own.bounds);
            if (const double depth = mostDepth(*given[v], glm::length(own.bounds.size())); depth > 0)
                m_thin = std::clamp(depth / kThin, kThinnest, m_thin);
        }
        if (like != nullptr) m_thin = like->m_thin;
        m_voxel = like != nullptr ? like->m_voxel : voxelUnit(scene);
        m_texel = m_voxel * across;
        for (PilotVolume& volume : m_volumes) {
            const double octaves = std::floor(std::log2(volume.step / (m_step * m_voxel)) + 1e-9);
            volume.texel = octaves > 0 ? m_voxel * std::exp2(octaves) : m_texel;
            m_reach = std::max(m_reach, kReach * volume.texel);
        }
        sortIntoCells();
        chooseSteps(like);
        if (solidsBlock(scene)) m_solids = scene.solids.get();
        if (scene.solids && scene.solids->any(SolidRole::holdout)) m_holdouts = scene.solids.get();
        m_ambient = 4 * glm::pi<double>() * glm::dot(scene.ambient, Rgb(1.0 / 3));
        chooseWeights(like, anyEmits(scene));
    }

    // Radiance of ray `number` of the pilots through the field and through texels of it, and alpha;
    // all 0 where the ray meets nothing. `thickness`: the sum over the ray of the optical depths of
    // voxels, weighted by the radiance that comes from there.
    struct Seen {
        double exact = 0, texels = 0, alpha = 0, alphaTexels = 0, thickness = 0;
    };
    Seen look(int number, bool texels = true) const {
        const auto [origin, direction] = ray(number);
        const double jitter = m_flat ? 0.5 : pilotPlace(number).z;
        Seen seen;
        const auto [first, end] = m_bounds.clip(origin, direction, 0, kFar);
        if (!(first < end)) return seen;
        const double last = m_holdouts ? m_holdouts->firstHit(SolidRole::holdout, origin, direction, 0, end) : end;
        double through[2] = {1, 1}, radiance[2] = {0, 0}, clear[2] = {1, 1}, alpha[2] = {0, 0}, thickness = 0;
        std::array<double, kMostPilotLights + 1> light[2] = {};
        double unlit = 0;  // what has contributed since light was looked up
        walk(origin, direction, first, std::min(last, end), jitter, [&](double t, double step) {
            const Vec3 at = origin + t * direction;
            PilotStuff stuff[2];
            lookUp(at, direction, texels && evenSteps(at, direction, step) == 0, stuff);
            const PilotStuff& exact = stuff[0];
            if (stuff[0].opacity + stuff[1].opacity + stuff[0].glow + stuff[1].glow <= 0) return true;
            const double before = radiance[0], share = through[0] * stuff[0].extinction * step;
            unlit += share;
            if (m_even || unlit > m_thin * kMostUnlit) {
                for (auto& all : light) {
                    all.fill(0);
                    all[kMostPilotLights] = m_ambient;
                }
                if (unlit > m_thin * kLeastShare * m_step / kStep)
                    for (std::size_t l = 0; l < m_lights.size(); ++l) addLight(l, at, jitter, texels, light);
                unlit = 0;
            }
            for (int i = 0; i < 2; ++i) {
                const double tau = stuff[i].extinction * step, left = std::exp(-tau);
                // Mean transmittance of emission within the step, and of the light that is scattered there.
                const double sent = (tau > 1e-6 ? (1 - left) / tau : 1) * step;
                double scattered = 0;
                for (std::size_t l = 0; l < light[i].size(); ++l) scattered += stuff[i].scattering[l] * light[i][l];
                radiance[i] += through[i] * sent * (scattered + stuff[i].glow);
                through[i] *= left;
            }
            for (int i = 0; i < 2; ++i) {
                if (!(stuff[i].opacity > 0)) continue;
                const double left = std::exp(-stuff[i].opacity * step);
                alpha[i] += clear[i] * (1 - left) * stuff[i].shown / stuff[i].opacity;
                clear[i] *= left;
            }
            thickness += (radiance[0] - before) * exact.extinction * m_voxel;
            return std::max({through[0], through[1], clear[0], clear[1]}) >= std::exp(-kMostDepth);
        });
        seen.exact = radiance[0];
        seen.texels = radiance[1];
        seen.alpha = alpha[0];
        seen.alphaTexels = alpha[1];
        seen.thickness = thickness;
        return seen;
    }

    // The optical depth of the first voxels of ray `i`.
    double depthAtEye(int i) const {
        const auto [origin, direction] = ray(i);
        double depth = 0;
        for (const PilotVolume& volume : m_volumes)
            for (int k = 0; k < kVoxelsAtEye; ++k)
                depth += std::max(volume.extinction(origin + (k + 0.5) * m_voxel * direction), 0.0) * m_voxel;
        return depth;
    }

  private:
    static double flatStepOf(const ViewScene& scene) {
        const bool very =
            std::ranges::any_of(scene.volumes, [](const ViewVolume& v) { return flatness(v) > kVeryFlat; });
        return very ? 0.5 * kFlatStep : kFlatStep;
    }
    // Where ray `i` of the pilots begins, and its direction.
    std::pair<Vec3, Vec3> ray(int i) const {
        const Vec3 place = pilotPlace(i);
        const double x = place.x * m_size.x, y = place.y * m_size.y;
        const Vec3 perDepth = m_rays.direction(x, y);
        return {m_rays.origin(x, y) + m_rays.near * perDepth, glm::normalize(perDepth)};
    }
    // In a scene without light only opacity is visible; constant ambient light then stands for it.
    void chooseWeights(const PilotScene* like, bool emits) {
        double brightest = 0;
        for (const PilotVolume& volume : m_volumes) brightest = std::max(brightest, volume.brightest());
        const bool lit = !m_lights.empty() && m_lights.front().power > 0 && brightest > 0;
        if (m_ambient == 0 && !emits && !lit) {
            m_ambient = 1;
            for (PilotVolume& volume : m_volumes) volume.showOpacity();
        } else if (like != nullptr) {
            for (std::size_t v = 0; v < m_volumes.size(); ++v) m_volumes[v].takeWeights(like->m_volumes[v]);
        } else if (lit) {
            for (PilotVolume& volume : m_volumes) volume.divide(brightest);
        }
    }
    // All volumes have steps of about one length; or, of many volumes, the finest are taken for all.
    void chooseSteps(const PilotScene* like) {
        constexpr double kAlike = 1.5;
        constexpr std::size_t kMany = 1000;
        if (like != nullptr) {
            m_even = like->m_even;
            for (std::size_t v = 0; v < m_volumes.size(); ++v) {
                m_volumes[v].step = like->m_volumes[v].step;
                m_volumes[v].bounds = like->m_volumes[v].bounds;
            }
            return;
        }
        double most = 0;
        for (const PilotVolume& volume : m_volumes) most = std::max(most, volume.step);
        m_even = most <= kAlike * m_step * m_voxel || m_volumes.size() > kMany;
    }
    // Calls visit(t, length) for the steps of a ray, each as long as the finest volume there asks
    // for, until it returns false. Nothing is visited outside of all volumes.
    template <class Visit>
    void walk(const Vec3& origin, const Vec3& direction, double first, double last, double jitter,
              const Visit& visit) const {
        if (m_even) {
            const double step = std::max(m_step * m_voxel, (last - first) / kMostSteps);
            for (double t = first + jitter * step; t < last; t += step)
                if (!visit(t, step)) return;
            return;
        }
        struct Part {
            double first, last, step;
        };
        std::vector<Part> parts;
        double steps = 0;
        for (const PilotVolume& volume : m_volumes) {
            const auto [from, to] = volume.bounds.clip(origin, direction, first, last);
            if (!(from < to)) continue;
            parts.push_back({from, to, volume.step});
            steps += (to - from) / volume.step;
        }
        const double longer = std::max(1.0, steps / kMostSteps);
        for (double t = first; t < last;) {
            double step = kFar, next = last, end = kFar;
            for (const Part& part : parts) {
                if (part.first > t) next = std::min(next, part.first);
                if (part.first > t || part.last <= t) continue;
                if (part.step < step) step = part.step, end = part.last;
            }
            if (step < kFar) {
                step = std::min({longer * step, next - t, end - t});
                if (!visit(t + jitter * step, step)) return;
                t += std::max(step, 1e-12 * last);
            } else {
                t = next;
            }
        }
    }
    // What is at a point, and what texels show there if they are asked for. Of several volumes, those that are even
    // there show the same. `light`: the light whose shadows are looked up; none: the eye looks.
    template <class Stuff>
    void lookUp(const Vec3& ws, const Vec3& direction, bool texels, Stuff (&stuff)[2],
                std::optional<std::size_t> light = {}) const {
        if (m_volumes.size() == 1 && (!light || m_volumes.front().castsShadow(*light))) {
            stuff[0] = Stuff::at(m_volumes.front(), ws);
            stuff[1] = texels ? texelsAt<Stuff>(m_volumes.front(), ws) : stuff[0];
            return;
        }
        forVolumesNear(ws, texels ? m_reach : 0, [&](const PilotVolume& volume) {
            if (light && !volume.castsShadow(*light)) return;
            const Stuff own = Stuff::at(volume, ws);
            const bool same = !texels || volume.evenAlong(ws, direction, kReach * volume.texel) >= 0;
            stuff[0].add(own, 1);
            stuff[1].add(same ? own : texelsAt<Stuff>(volume, ws), 1);
        });
    }
    // Calls visit(volume) for those in whose box a point is, or less than `reach` beside it.
    template <class Visit>
    void forVolumesNear(const Vec3& ws, double reach, const Visit& visit) const {
        const auto visitIfNear = [&](const PilotVolume& volume) {
            if (Bounds{volume.bounds.lower - reach, volume.bounds.upper + reach}.contains(ws)) visit(volume);
        };
        if (m_cells.empty())
            for (const PilotVolume& volume : m_volumes) visitIfNear(volume);
        else if (m_bounds.contains(ws))
            for (const std::uint32_t v : m_cells[cellOf(ws)]) visitIfNear(m_volumes[v]);
    }
    // Among thousands of instances only a few volumes contain a given point. Each cell of a grid
    // lists the volumes whose boxes it touches, or nearly so.
    static constexpr int kCells = 24;  // along an axis
    using Cells = std::vector<std::vector<std::uint32_t>>;
    int cellAlong(double x, int axis) const {
        const double part = (x - m_bounds.lower[axis]) / std::max(m_bounds.size()[axis], 1e-300);
        return std::clamp(static_cast<int>(part * kCells), 0, kCells - 1);
    }
    std::size_t cellOf(const Vec3& ws) const {
        return std::size_t((cellAlong(ws.x, 0) * kCells + cellAlong(ws.y, 1)) * kCells + cellAlong(ws.z, 2));
    }
    void sortIntoCells() {
        constexpr std::size_t kFew = 8;
        if (m_volumes.size() <= kFew) return;
        m_cells.resize(std::size_t(kCells) * kCells * kCells);
        for (std::size_t v = 0; v < m_volumes.size(); ++v) {
            Int3 first, last;
            for (int axis = 0; axis < 3; ++axis) {
                first[axis] = cellAlong(m_volumes[v].bounds.lower[axis] - m_reach, axis);
                last[axis] = cellAlong(m_volumes[v].bounds.upper[axis] + m_reach, axis);
            }
            for (int x = first.x; x <= last.x; ++x)
                for (int y = first.y; y <= last.y; ++y)
                    for (int z = first.z; z <= last.z; ++z)
                        m_cells[std::size_t((x * kCells + y) * kCells + z)].push_back(static_cast<std::uint32_t>(v));
        }
    }
    // How many steps along a ray from `at` see the same values as `at`, both in the field and in texels; 0 if unknown.
    int evenSteps(const Vec3& at, const Vec3& direction, double step) const {
        if (m_volumes.size() != 1) return 0;
        const double way = m_volumes.front().evenAlong(at, direction, kReach * m_texel);
        return way < 0 ? 0 : 1 + static_cast<int>(std::min(way / step, 1.0 * kMostSteps));
    }
    // The field as texels reconstruct it: bilinear between the four nearest texels of f - 1/12
    // (second differences), a prefilter that makes up for the blur of the bilinear look-up. Texels
    // at -1 and 2 of a row or column contribute only through the prefilter.
    template <class Stuff>
    Stuff texelsAt(const PilotVolume& volume, const Vec3& ws) const {
        const double u = glm::dot(ws, m_u) / volume.texel, v = glm::dot(ws, m_v) / volume.texel;
        const double fu = u - std::floor(u), fv = v - std::floor(v);
        const double wu[4] = {0, 1 - fu, fu, 0}, wv[4] = {0, 1 - fv, fv, 0};
        Stuff sum;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {
                const auto at = [](const double* w, int k) { return k < 0 || k > 3 ? 0.0 : w[k]; };
                const double around = wv[j] * (at(wu, i - 1) + at(wu, i + 1)) + wu[i] * (at(wv, j - 1) + at(wv, j + 1));
                const double weight = wu[i] * wv[j] * (1 + 4.0 / 12) - around / 12;
                if (weight != 0)
                    sum.add(Stuff::at(volume, ws + volume.texel * ((i - 1 - fu) * m_u + (j - 1 - fv) * m_v)), weight);
            }
        sum.cutBelowZero();
        return sum;
    }
    void addLight(std::size_t number, const Vec3& at, double jitter, bool texels,
                  std::array<double, kMostPilotLights + 1> (&light)[2]) const {
        const PilotLight& l = m_lights[number];
        const Vec3 way = toLight(*l.light, at);
        if (way == Vec3(0)) return;
        double power = l.power, most = kFar;
        if (!l.light->distant()) {
            most = glm::distance(l.light->wsPosition, at);
            if (l.light->point().decay) power /= std::max(most * most, 1e-300);
            if (const Light::Spot* spot = l.light->spot();
                spot && glm::dot(-way, l.light->wsDirection) < std::cos(glm::pi<double>() / 360 * spot->coneAngle))
                return;
        }
        if (l.light->luminaire) power *= luminairePart(*l.light, lightFrame(*l.light), -way);
        if (l.light->element()) power *= glm::dot(-way, l.light->wsDirection);
        if (power <= 0) return;
        double tau[2] = {0, 0};
        if (l.light->shadows) {
            // Where solids leave little light, what texels lose counts more.
            if (m_solids && m_solids->firstHit(SolidRole::shadow, at, way, 0, most) < most) return;
            const double last = m_bounds.clip(at, way, 0, most).second;
            if (!m_even)
                walk(at, way, 0, last, jitter, [&](double t, double step) {
                    const Vec3 here = at + t * way;
                    PilotShade stuff[2];
                    lookUp(here, way, texels, stuff, number);
                    for (int i = 0; i < 2; ++i) tau[i] += stuff[i].extinction * step;
                    return std::min(tau[0], tau[1]) < kMostDepth;
                });
            const double step = std::max(m_step * m_voxel, last / kMostSteps);
            for (double t = jitter * step; m_even && t < last && std::min(tau[0], tau[1]) < kMostDepth;) {
                const Vec3 here = at + t * way;
                const int even = std::min(evenSteps(here, way, step), static_cast<int>(std::ceil((last - t) / step)));
                const double along = std::max(even, 1) * step;
                PilotShade stuff[2];
                lookUp(here, way, texels && even == 0, stuff, number);
                for (int i = 0; i < 2; ++i) tau[i] += stuff[i].extinction * along;
                t += along;
            }
        }
        for (int i = 0; i < 2; ++i) light[i][number] = power * std::exp(-tau[i]);
    }

    RayFamily m_rays;
    Int2 m_size;
    std::vector<PilotLight> m_lights;
    std::vector<PilotVolume> m_volumes;
    Cells m_cells;                       // empty if there are few volumes
    const Solids* m_solids = nullptr;    // null: none that blocks light
    const Solids* m_holdouts = nullptr;  // null: none hides volumes from the eye
    double m_ambient = 0;
    Bounds m_bounds;
    double m_voxel = 1;
    double m_texel = 1;     // of the finest volumes
    double m_step = kStep;  // voxels
    double m_thin = 1;      // by the thinnest volume: how fine the parts are that are lit
    bool m_flat = false;    // some voxels are
    double m_reach = 0;     // of the largest texels, world units
    bool m_even = true;
    Vec3 m_u, m_v;
};

}  // namespace

Vec3 pilotPlace(int i) {
    return {evenPoint(i), glm::fract(0.5 + 0.618034 * i)};
}

namespace {

constexpr double kFaint = 1e-3;

// The least that counts as shown, relative to the most that any ray shows: a picture may be thin all over.
struct FaintLimit {
    double alpha = 0, radiance = 0;

    template <class Rays>
    explicit FaintLimit(const Rays& rays) {
        for (const auto& ray : rays) {
            alpha = std::max(alpha, kFaint * ray.alpha);
            radiance = std::max(radiance, kFaint * ray.radiance);
        }
    }
    template <class Ray>
    bool shows(const Ray& ray) const {
        return (ray.alpha > 0 && ray.alpha >= alpha) || (ray.radiance > 0 && ray.radiance >= radiance);
    }
};

}  // namespace

PilotSight pilotSight(const ViewScene& given, int rays) {
    const ViewScene scene = withFewSubLights(given, static_cast<int>(kMostPilotLights));
    const PilotScene pilots(scene);
    struct Ray {
        double radiance = 0, alpha = 0, thickness = 0, depthAtEye = 0;
    };
    std::vector<Ray> all(static_cast<std::size_t>(rays));
    parallelFor(all.size(), [&](std::size_t i) {
        const PilotScene::Seen seen = pilots.look(static_cast<int>(i), false);
        all[i] = {seen.exact, seen.alpha, seen.thickness, pilots.depthAtEye(static_cast<int>(i))};
    });
    PilotSight sight;
    const FaintLimit limit(all);
    double light = 0, thickness = 0, squares = 0, depthAtEye = 0;
    int count = 0;
    for (const Ray& ray : all) {
        light += ray.radiance;
        thickness += ray.thickness;
        depthAtEye += ray.depthAtEye;
        if (!limit.shows(ray)) continue;
        sight.radiance += ray.radiance;
        squares += ray.radiance * ray.radiance;
        ++count;
    }
    if (light > 0) sight.thickness = thickness / light;
    if (sight.radiance > 0) sight.contrast = std::sqrt(squares * count) / sight.radiance;
    sight.depthAtEye = depthAtEye / rays;
    return sight;
}

namespace {

// What some rays found of one value.
struct Errors {
    double squares = 0, fourths = 0, values = 0;

    void add(double exact, double found) {
        const double square = (exact - found) * (exact - found);
        squares += square;
        fourths += square * square;
        values += exact;
    }
    void add(const Errors& o) {
        squares += o.squares;
        fourths += o.fourths;
        values += o.values;
    }
    // Standard deviation of the mean square of `count` rays, relative to it.
    double deviation(int count) const { return std::sqrt(std::max(fourths / (squares * squares) - 1.0 / count, 0.0)); }
    // The relative RMSE, one standard deviation above what they find; 0 where they find no error.
    double oneDeviationAbove(int count) const {
        if (!(squares > 0 && values > 0)) return 0;
        return std::sqrt((1 + deviation(count)) * squares / count) / (values / count);
    }
};

}  // namespace

struct PilotRadiance {
    struct Ray {
        double radiance = 0, alpha = 0;
    };

    PilotRadiance(const ViewScene& given, int count)
        : scene(withFewSubLights(given, static_cast<int>(kMostPilotLights))),
          pilots(scene),
          seen(look(pilots, count)),
          limit(seen) {
        clearHidden(seen);
    }

    static std::vector<Ray> look(const PilotScene& through, int count) {
        std::vector<Ray> rays(static_cast<std::size_t>(count));
        parallelFor(rays.size(), [&](std::size_t i) {
            const PilotScene::Seen ray = through.look(static_cast<int>(i), false);
            rays[i] = {ray.exact, ray.alpha};
        });
        return rays;
    }
    void clearHidden(std::vector<Ray>& rays) const {
        for (Ray& ray : rays)
            if (!limit.shows(ray)) ray = {};
    }

    const ViewScene scene;
    const PilotScene pilots;
    std::vector<Ray> seen;  // 0 where a ray shows nothing
    const FaintLimit limit;
};

CoarserPilot::CoarserPilot(const ViewScene& scene, int rays)
    : m_rays(std::make_unique<const PilotRadiance>(scene, rays)) {}
CoarserPilot::~CoarserPilot() = default;

double CoarserPilot::error(const ViewScene& coarser) const {
    const ViewScene scene = withFewSubLights(coarser, static_cast<int>(kMostPilotLights));
    const PilotScene pilots(scene, &m_rays->pilots);
    std::vector<PilotRadiance::Ray> seen = PilotRadiance::look(pilots, static_cast<int>(m_rays->seen.size()));
    m_rays->clearHidden(seen);
    // Of radiance, and of alpha, which shows edges where there is little light.
    double most = 0;
    for (const auto value : {&PilotRadiance::Ray::radiance, &PilotRadiance::Ray::alpha}) {
        Errors errors;
        int count = 0;
        for (std::size_t i = 0; i < seen.size(); ++i) {
            const double exact = m_rays->seen[i].*value, found = seen[i].*value;
            errors.add(exact, found);
            count += exact > 0 || found > 0;
        }
        most = std::max(most, errors.oneDeviationAbove(count));
    }
    return most;
}

double pilotError(const ViewScene& given, int rays, int mostRays) {
    const ViewScene scene = withFewSubLights(given, static_cast<int>(kMostPilotLights));
    constexpr int kParts = 8, kMostTries = 16;
    // Ray i is of part i % kParts. Each part has as many rays that see something.
    struct Part {
        Errors radiance, alpha;
        int count = 0, tries = 0;
    };
    const PilotScene pilots(scene);
    std::vector<Part> parts(kParts);
    std::vector<int> numbers;
    for (;; rays *= 2) {
        do {
            numbers.clear();
            for (int p = 0; p < kParts; ++p) {
                const Part& part = parts[std::size_t(p)];
                const int wanted = (rays + kParts - 1) / kParts - part.count;
                const int allowed = (kMostTries * rays + kParts - 1) / kParts - part.tries;
                for (int i = 0; i < std::min(wanted, allowed); ++i) numbers.push_back((part.tries + i) * kParts + p);
            }
            std::vector<PilotScene::Seen> seen(numbers.size());
            parallelFor(seen.size(), [&](std::size_t i) { seen[i] = pilots.look(numbers[i]); });
            for (std::size_t i = 0; i < seen.size(); ++i) {
                Part& part = parts[std::size_t(numbers[i] % kParts)];
                ++part.tries;
                if (seen[i].alpha < kFaint && seen[i].exact <= 0) continue;
                part.radiance.add(seen[i].exact, seen[i].texels);
                part.alpha.add(seen[i].alpha, seen[i].alphaTexels);
                ++part.count;
            }
        } while (!numbers.empty());
        Part all;
        for (const Part& part : parts) {
            all.radiance.add(part.radiance);
            all.alpha.add(part.alpha);
            all.count += part.count;
        }
        if (!(all.radiance.values > 0 && all.radiance.squares > 0)) return 0;
        // Where errors are equal, the mean of their squares is known from a few rays. In layers and
        // thin shells a few rays have most of it, so it takes more: 48 rays found 0.4 of it in
        // layers, 384 rays 0.8. What is returned is one standard deviation above.
        if (!(all.radiance.deviation(all.count) > kSure) || rays >= mostRays || all.count * 2 < rays)
            return std::max(all.radiance.oneDeviationAbove(all.count), all.alpha.oneDeviationAbove(all.count));
    }
}

}  // namespace scrim
