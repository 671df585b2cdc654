// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/light_cells.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/transport/cell_media.h>
#include <scrim/engine/transport/light_sources.h>

#include <algorithm>
#include <map>
#include <array>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <numbers>
#include <thread>
#include <tuple>

#include <glm/geometric.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/transport/light_cells.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/transport/light_cells-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// Passes the slices with one source after the other. Threads work on successive sources; each waits at every slice
// until the source before it has passed there, so that the order of all sums is that of the sources, whatever the
// number of threads. The checkpoint is called by the thread that called this.
template <class Raster, class Make>
HWY_ATTR void passSlices(std::size_t count, const Make& make, const CellView& view, CellSlices& box,
                         const std::function<void()>& checkpoint) {
    const TowardsEye towards(view);
    const std::thread::id caller = std::this_thread::get_id();
    std::vector<std::atomic<int>> passed(count);
    std::atomic<std::size_t> next{0};
    // Whoever waits for a source goes on even if that one fails; then the others end, too.
    struct Finish {
        std::atomic<int>& passed;
        std::atomic<std::size_t>& next;
        int uncaught = std::uncaught_exceptions();
        ~Finish() {
            if (std::uncaught_exceptions() > uncaught) next.store(std::numeric_limits<std::size_t>::max() / 2);
            passed.store(std::numeric_limits<int>::max(), std::memory_order_release);
        }
    };
    parallelFor(std::min(count, std::size_t(threadCount())), [&](std::size_t) HWY_ATTR {
        std::vector<Real> memory;
        for (std::size_t m = next++; m < count; m = next++) {
            const Finish finish{passed[m], next};
            Raster raster = make(m, memory);
            for (int step = 0; step < box.size[2] && next < std::numeric_limits<std::size_t>::max() / 2; ++step) {
                if (step % 8 == 0 && std::this_thread::get_id() == caller) checkpoint();
                while (m > 0 && passed[m - 1].load(std::memory_order_acquire) <= step) std::this_thread::yield();
                for (int j = 0; raster.reaches(step) && j < box.size[1]; ++j)
                    if (!box.wanted[box.rowIndex(j, raster.slice(step))].empty())
                        raster.light(step, j, view, towards, box);
                passed[m].store(step + 1, std::memory_order_release);
                for (int row = 0; raster.reaches(step) && row < raster.rows(); ++row) raster.attenuate(step, row);
            }
        }
    });
}

// Adds the light of sources that are all parallel and have the slices' axis as their main one, or of points. `down`:
// only rays that pass the slices in descending order.
HWY_ATTR void sweepCells(const std::vector<CellRays>& sources, const CellView& view, bool parallel, bool down,
                         CellSlices& box, const std::function<void()>& checkpoint) {
    const std::size_t count = sources.size();
    if (parallel)
        passSlices<ParallelRaster>(
            count,
            [&](std::size_t m, std::vector<Real>& memory) { return ParallelRaster(box, sources[m], view, memory); },
            view, box, checkpoint);
    else
        passSlices<PointRaster>(
            count,
            [&](std::size_t m, std::vector<Real>& memory) { return PointRaster(box, sources[m], view, memory, down); },
            view, box, checkpoint);
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(sweepCells);

namespace {

// Sub-lights as sources of rays, and the light that they send if it has one colour.
struct Sources {
    std::vector<Light> lights;
    std::vector<int> owners;         // for each the index of the light that it is a part of, ascending
    std::vector<double> parts = {};  // SubLights::parts of each; empty: none stands for others
    std::vector<int> ofScene = {};   // for each owner its index into the lights of the scene
    Rgb tint{1};
    std::size_t colours = 1;  // 3 if the lights differ in colour
    bool lamp = false;        // points of a lamp, of which the transmittance alone is asked
    bool attenuated = true;   // by volumes
    bool blocked = false;     // by solids
};

// A lamp's cells keep its transmittance: they stand alone, each point shines 4 pi over their number, and all that
// arrives is scattered to all sides alike.
Sources sourcesOfLamp(const Light& light, int count) {
    const std::vector<Vec3> points = pointsOfLamp(light, count);
    Sources lamp;
    lamp.lamp = true;
    lamp.lights.assign(points.size(), light);
    lamp.owners.assign(points.size(), 0);
    for (std::size_t i = 0; i < points.size(); ++i) {
        lamp.lights[i].kind = Light::Point();
        lamp.lights[i].wsPosition = points[i];
        lamp.lights[i].intensity = Rgb(4 * std::numbers::pi / double(points.size()));
    }
    return lamp;
}

bool isMesh(const Light& light) {
    return light.area() && light.area()->shape == AreaShape::mesh;
}

Sources sourcesOf(const ViewScene& scene, const std::vector<int>& lights) {
    Sources out;
    if (const Light& first = scene.lights[std::size_t(lights.front())]; isLampOnCells(scene, first))
        out = sourcesOfLamp(first, pointsOnCells(scene, first));
    out.attenuated = isHeldBack(scene, std::size_t(lights.front()));
    if (out.lamp) return out;
    ViewScene alone = scene;
    alone.lights.clear();
    for (const int i : lights) alone.lights.push_back(scene.lights[std::size_t(i)]);
    out.blocked = isBlocked(scene, std::size_t(lights.front()));
    for (Light& light : alone.lights) light.samples = pointsOnCells(scene, light);
    const SubLights all = subLights(alone);
    for (std::size_t i = 0; i < all.lights.size(); ++i)
        if (all.lights[i].intensity != Rgb(0) && !all.suns[i]) {
            out.lights.push_back(all.lights[i]);
            out.owners.push_back(all.ownerOf(static_cast<int>(i)));
            out.parts.push_back(all.parts[i]);
        }
    out.ofScene = lights;
    if (out.lights.empty()) return out;
    out.tint = out.lights.front().intensity;
    for (const Light& light : out.lights)
        if (!sameColour(out.tint, light.intensity)) out.colours = 3;
    if (out.colours == 1) out.tint /= largest(out.tint);
    return out;
}

// What stands for a phase function where the sub-lights of a light are wider than its lobes. A sky is smooth: a few
// rays see what a peak shows of it. A surface has edges, which the peak blurs, and so do means over what its points
// stand for.
struct WidePhase {
    std::optional<CutPhase> ofSky;                     // its peaks are for rays (addPeaks)
    PhaseRow ofSun{};                                  // the mean over what one of a sun's directions stands for
    std::shared_ptr<const PhaseOverCaps> ofSurface{};  // of all surfaces but meshes
};

// For each light that the sources are parts of; no other light changes it.
std::vector<WidePhase> widePhases(const ViewScene& scene, const Sources& sources, const Phase& phase) {
    const Bounds box = wsBounds(scene);
    std::vector<double> widest(sources.ofScene.size(), 0.0);
    for (std::size_t i = 0; i < sources.lights.size(); ++i) {
        double& own = widest[std::size_t(sources.owners[i])];
        own = std::max(own, widestCap(sources.lights[i], sources.parts[i], box));
    }
    std::vector<WidePhase> all(widest.size());
    for (std::size_t owner = 0; owner < all.size(); ++owner) {
        const Light& light = scene.lights[std::size_t(sources.ofScene[owner])];
        const double own = widest[owner];
        if (isMesh(light) || !needsCaps(phase, light.dome() ? own : kCapsOfSurfaces * own)) continue;
        // The edge of a square as large as the cap.
        if (light.dome())
            all[owner].ofSky.emplace(phase, std::sqrt(std::numbers::pi) * own);
        else if (light.distant())
            all[owner].ofSun = PhaseOverCaps(phase, own).row(own);
        else
            all[owner].ofSurface = std::make_shared<const PhaseOverCaps>(phase, own);
    }
    return all;
}

// One pass of some sources of light through the cells, for one or all colours.
class Pass {
  public:
    Pass(const ViewScene& scene, const CellGrid& grid, Simd simd, const std::function<void()>& checkpoint)
        : m_scene(scene), m_grid(grid), m_simd(simd), m_checkpoint(checkpoint) {}

    // `colour`: the only one that the slices' extinction is for; -1: all.
    // `lamp`: what the sources stand for, if it is a lamp. `far`: what it shares with other lamps, if it does.
    void add(const Sources& sources, const Phase& phase, const std::vector<WidePhase>& wide, const Light* lamp,
             int colour, CellSlices& slices, CellField& field, CellField* far = nullptr) const {
        static const WidePhase kNarrow;
        const std::size_t colours = colour < 0 ? field.colours() : 1;
        CellView view{phase, m_scene.camera.type == CameraType::orthographic, {}, colours, {}};
        view.eye =
            view.parallelEye ? slices.reordered(-viewingAxis(m_scene.camera)) : slices.place(m_scene.camera.wsPosition);
        if (sources.blocked)
            view.darkFrom = [&](const Vec3& from, const Vec3& perStep, bool parallel) {
                const Vec3 ws = slices.wsPlace(from);
                return darkFrom(ws, slices.wsPlace(from + perStep) - ws, parallel);
            };
        const auto before = lamp && hollowOnCells(*lamp, m_grid.edge())
                                ? slices.hollow(lamp->wsPosition, lamp->area()->radius)
                                : std::vector<std::pair<std::size_t, Real>>();
        // Each light is sharpened alone, because what limits that depends on all that is in the sums.
        const auto end = sources.owners.end();
        for (auto first = sources.owners.begin(), last = first; first != end; first = last) {
            last = std::upper_bound(first, end, *first);
            slices.clearSums(colours);
            sweep(sources, wide.empty() ? kNarrow : wide[std::size_t(*first)],
                  std::size_t(first - sources.owners.begin()), std::size_t(last - first), colour, view, slices);
            if (!lamp && sources.attenuated) slices.sharpen(colours);
            slices.addTo(colours, colour < 0 ? 0 : std::size_t(colour), field);
        }
        slices.restore(before);
        if (far) slices.addFarLight(field, colour, *far);
    }

  private:
    // Adds the light of `count` sources from `first` on to the sums of the slices.
    void sweep(const Sources& sources, const WidePhase& wide, std::size_t first, std::size_t count, int colour,
               const CellView& view, CellSlices& slices) const {
        std::vector<CellRays> suns[2], points;  // suns: those that go up, and those that go down
        for (std::size_t i = first; i < first + count; ++i) {
            const Light& light = sources.lights[i];
            CellRays rays = raysOf(sources, light, slices);
            if (wide.ofSky) rays.phaseRow = wide.ofSky->row.data();
            if (!wide.ofSun.empty()) rays.phaseRow = wide.ofSun.data();
            if (wide.ofSurface) {
                rays.caps = wide.ofSurface.get();
                rays.capRadius = std::sqrt(sources.parts[i] / std::numbers::pi) / m_grid.edge();
            }
            // Relative to the tint where there is one value for all colours.
            for (int c = 0; c < static_cast<int>(view.colours); ++c)
                rays.weight[c] = static_cast<Real>(sources.colours == 3 ? light.intensity[colour < 0 ? c : colour]
                                                                        : largest(light.intensity));
            if (!rays.parallel)
                points.push_back(rays);
            else if (axisOfLargest(glm::abs(light.wsDirection)) == slices.axes[2])
                suns[rays.way.z < 0 ? 1 : 0].push_back(rays);
        }
        for (const bool down : {false, true}) {
            SCRIM_ON_TARGET(m_simd, sweepCells)(suns[down ? 1 : 0], view, true, down, slices, m_checkpoint);
            SCRIM_ON_TARGET(m_simd, sweepCells)(points, view, false, down, slices, m_checkpoint);
        }
    }
    // Cells on both sides of a surface, less than a voxel away, are looked up together. If it hides what is behind it,
    // the eye sees but one side of it: where the light shines on that one, cells behind it are lit, too, and else those
    // in front are dark.
    double darkFrom(const Vec3& ws, const Vec3& wsPerStep, bool parallel) const {
        constexpr double kInfinity = std::numeric_limits<double>::infinity();
        const double beside = 1.5 * std::max(voxelUnit(m_scene) / m_grid.edge(), 1.0);
        const SolidHit hit =
            m_scene.solids->trace(SolidRole::shadow, ws, wsPerStep, parallel ? -kInfinity : 0, kInfinity);
        if (hit.t == kInfinity || !hit.solid->holdout) return hit.t;
        const bool seen = glm::dot(hit.wsNormal, wsPerStep) *
                              glm::dot(hit.wsNormal, -travelToEye(m_scene.camera, ws + hit.t * wsPerStep)) >
                          0;
        return hit.t + (seen ? beside : -beside);
    }
    CellRays raysOf(const Sources& sources, const Light& light, const CellSlices& slices) const {
        CellRays rays{.parallel = light.distant(), .way = slices.reordered(light.wsDirection)};
        rays.lamp = sources.lamp;
        rays.attenuated = sources.attenuated;
        rays.blocked = sources.blocked;
        if (rays.parallel) return rays;
        const double edge = m_grid.edge();
        // A lamp exactly at the centre of a cell would belong to no face of the cube around it.
        rays.from = slices.place(light.wsPosition + edge * Vec3(1e-4, 1.1e-4, 1.2e-4));
        if (rays.lamp) return rays;  // the field divides by its distance
        rays.radius2 = light.point().radius * light.point().radius / (edge * edge);
        rays.decayScale = light.point().decay ? 1 / (edge * edge) : 0;
        if (light.luminaire) rays.pattern = slices.seriesOf(light, wsBounds(m_scene));
        rays.oneSided = light.element() != nullptr;
        const Spread spread(rays.oneSided ? light.element()->spread : 180);
        rays.spreadTangent = spread.tangent();
        rays.spreadScale = spread.scale();
        return rays;
    }

    const ViewScene& m_scene;
    const CellGrid& m_grid;
    Simd m_simd;
    const std::function<void()>& m_checkpoint;
};

// What one class of volumes shows of some lights: a field, and the passes that fill it.
struct Job {
    int first;  // index of the first light; the same volumes hold back all
    Sources sources;
    Phase phase;
    std::shared_ptr<CellField> field;
    const Light* lamp;                          // the only light, if it is a lamp
    std::shared_ptr<CellField> far = nullptr;   // of a lamp: what it shares with others; null: it is alone
    std::shared_ptr<CellField> open = nullptr;  // of a lamp: what solids let through; null: there are none
    std::size_t media = 0;                      // index of what holds the light back (addMedia)
    std::vector<WidePhase> wide = {};           // of `phase`, for each light of `sources`; empty: of a lamp
};

// Lights share a field unless layers, or the volumes and solids that cast shadows in them, tell them apart. Lamps share
// one with each other, and have small ones of their own.
std::vector<std::vector<int>> groupsOf(const ViewScene& scene, const std::vector<int>& lights) {
    std::vector<int> lamps, others;
    for (const int light : lights)
        (isLampOnCells(scene, scene.lights[std::size_t(light)]) ? lamps : others).push_back(light);
    std::vector<std::vector<int>> groups;
    std::map<std::tuple<int, std::vector<bool>, bool>, std::vector<int>> alike;
    for (const int light : others)
        alike[{wants(scene, Layer::light) ? lightOfLayer(scene, light) : 0, castersIn(scene, std::size_t(light)),
               isBlocked(scene, std::size_t(light))}]
            .push_back(light);
    for (const auto& [key, some] : alike) groups.push_back(some);
    const bool together = lampsShareCells(scene);
    if (together && !lamps.empty()) groups.push_back(lamps);
    for (std::size_t i = 0; !together && i < lamps.size(); ++i) groups.push_back({lamps[i]});
    return groups;
}

// The field that lamps share, and the jobs for each of them.
std::shared_ptr<CellField> addLamps(const ViewScene& scene, const std::vector<int>& lamps, const Phase& phase,
                                    const std::shared_ptr<const CellGrid>& grid, bool grey, std::vector<Job>& jobs) {
    bool coloured = !grey;
    const Rgb tint = scene.lights[std::size_t(lamps.front())].intensity;
    for (const int i : lamps) coloured = coloured || !sameColour(tint, scene.lights[std::size_t(i)].intensity);
    const auto far = std::make_shared<CellField>(grid, coloured ? 3 : 1, coloured ? Rgb(1) : tint / largest(tint));
    for (const int i : lamps) {
        const Light& lamp = scene.lights[std::size_t(i)];
        const auto near =
            std::make_shared<CellField>(cellsNear(lamp, *grid, cornerOfVoxels(scene, grid->edge())), grey ? 1 : 3);
        near->setLamp(lamp, phase, scene.camera, isHeldBack(scene, std::size_t(i)), true);
        far->addNear(near);
        jobs.push_back({i, sourcesOf(scene, {i}), phase, near, &lamp, far});
    }
    return far;
}

// The jobs of one group of lights, whose fields become those of `light`.
std::vector<Job> jobsOf(const ViewScene& scene, const std::vector<int>& group,
                        const std::shared_ptr<const CellGrid>& grid, bool grey, CellLight& light) {
    std::vector<Job> jobs;
    if (wants(scene, Layer::light)) light.output = Output{Layer::light, lightOfLayer(scene, group.front())};
    light.ofVolume.resize(scene.volumes.size());
    // Volumes that scatter fully are apart, since others bring some lights to them.
    const std::vector<ServedLight> served = servedLights(scene, group);
    std::vector<std::vector<int>> classes;
    for (const bool full : {false, true})
        for (std::vector<int>& volumes : alikeVolumes(scene, [full](const ViewVolume& volume) {
                 return !volume.field->empty() && !volume.holdout && scattersFully(volume) == full;
             }))
            classes.push_back(std::move(volumes));
    for (const std::vector<int>& volumes : classes) {
        const ViewVolume& alike = scene.volumes[std::size_t(volumes.front())];
        const Phase& phase = alike.medium.phase;
        std::vector<int> lit;
        for (const int i : group)
            if (served[std::size_t(i)].volumes[std::size_t(volumes.front())] == Server::cells) lit.push_back(i);
        if (lit.empty()) continue;
        const Light& first = scene.lights[std::size_t(group.front())];
        const bool lamps = isLampOnCells(scene, first);
        std::shared_ptr<CellField> field;
        if (lamps && lampsShareCells(scene)) {
            field = addLamps(scene, lit, phase, grid, grey, jobs);
        } else {
            Sources sources = sourcesOf(scene, lit);
            if (sources.lights.empty()) continue;
            if (!grey) sources.colours = 3;
            if (sources.colours == 3) sources.tint = Rgb(1);
            field = std::make_shared<CellField>(grid, static_cast<int>(sources.colours), sources.tint);
            if (lamps) field->setLamp(first, phase, scene.camera, sources.attenuated, false);
            std::vector<WidePhase> wide;
            if (!lamps) wide = widePhases(scene, sources, phase);
            jobs.push_back({lit.front(), std::move(sources), phase, field, lamps ? &first : nullptr});
            jobs.back().wide = std::move(wide);
        }
        for (const int v : volumes) light.ofVolume[std::size_t(v)] = field;
    }
    return jobs;
}

// The light of a sky in the peaks of a phase function that were cut off for its directions. It comes from where the eye
// looks, or from behind it, and rays find it in the sky.
class SkyPeaks {
  public:
    SkyPeaks(const ViewScene& scene, const Sources& sources, std::size_t owner, const CutPhase& cut,
             const CellMedia& media)
        : m_scene(scene),
          m_sky(scene.lights[std::size_t(sources.ofScene[owner])]),
          m_blocked(sources.blocked),
          m_attenuated(sources.attenuated),
          m_cut(cut),
          m_media(media),
          m_depth(cut.spread / kAround) {}

    Rgb at(const Vec3& ws) const {
        const Vec3 toEye = travelToEye(m_scene.camera, ws);
        Rgb sum(0);
        if (m_cut.onwards > kNarrow) sum += m_cut.onwards * around(ws, -toEye);
        if (m_cut.backwards > kNarrow) sum += m_cut.backwards * around(ws, toEye);
        return sum;
    }

  private:
    // A peak is one ray, or also six around it, so that its mean cosine is kept.
    static constexpr double kNarrow = 1e-3, kAround = 0.75;
    static constexpr int kRays = 6;

    Rgb along(const Vec3& ws, const Vec3& way) const {
        constexpr double kInfinity = std::numeric_limits<double>::infinity();
        const Rgb radiance = skyAt(m_sky, way);
        if (radiance == Rgb(0)) return radiance;
        if (m_blocked && m_scene.solids->firstHit(SolidRole::shadow, ws, way, 0, kInfinity) < kInfinity) return Rgb(0);
        return m_attenuated ? radiance * glm::exp(-depthAlong(m_media, ws, way, kInfinity)) : radiance;
    }
    Rgb around(const Vec3& ws, const Vec3& way) const {
        const Rgb middle = along(ws, way);
        if (m_depth < kNarrow) return middle;
        const double aside = std::sqrt(m_depth * (2 - m_depth));
        const Mat3 frame = frameAround(way);
        Rgb sum(0);
        for (int i = 0; i < kRays; ++i) {
            const double turn = 2 * std::numbers::pi * i / kRays;
            sum += along(ws, (1 - m_depth) * way + aside * (std::cos(turn) * frame[0] + std::sin(turn) * frame[1]));
        }
        return (1 - kAround) * middle + kAround / kRays * sum;
    }

    const ViewScene& m_scene;
    const Light& m_sky;
    bool m_blocked, m_attenuated;
    const CutPhase& m_cut;
    const CellMedia& m_media;
    double m_depth;  // 1 - cos of the angle of the rays around a peak
};

void addPeaks(const ViewScene& scene, const Job& job, const CellMedia& media, const std::function<void()>& checkpoint) {
    if (std::ranges::none_of(job.wide, [](const WidePhase& wide) { return wide.ofSky.has_value(); })) return;
    checkpoint();
    // Rays take their time: in larger cells where there are many, between which their light is interpolated.
    constexpr std::size_t kMostCells = 60'000;
    CellMedia larger;
    const CellMedia* through = &media;
    while (through->grid.cells() > kMostCells) {
        CellMedia next = coarser(*through);
        if (next.grid.cells() >= through->grid.cells()) break;
        larger = std::move(next);
        through = &larger;
    }
    std::vector<SkyPeaks> peaks;
    for (std::size_t owner = 0; owner < job.wide.size(); ++owner)
        if (const auto& cut = job.wide[owner].ofSky) peaks.emplace_back(scene, job.sources, owner, *cut, *through);
    const auto light = [&](const Vec3& ws) {
        Rgb sum(0);
        for (const SkyPeaks& sky : peaks) sum += sky.at(ws);
        return job.sources.colours == 1 ? Rgb(largest(sum) / largest(job.sources.tint)) : sum;
    };
    if (through == &media) return job.field->add(light);
    CellField coarse(std::make_shared<const CellGrid>(larger.grid), static_cast<int>(job.sources.colours));
    coarse.add(light);
    job.field->add([&](const Vec3& ws) {
        Real rgb[3];
        coarse.sample(ws, rgb);
        return Rgb(rgb[0], rgb[1], rgb[2]);
    });
}

// Adds to `media`, which holds those of all volumes, those of the volumes alone that hold back the light of a job.
void addMedia(const ViewScene& scene, const Vec3& wsCorner, double margin, Simd simd, std::vector<Job>& jobs,
              std::vector<CellMedia>& media) {
    std::vector<std::vector<bool>> sets(1);
    for (const ViewVolume& volume : scene.volumes) sets[0].push_back(!volume.field->empty());
    for (Job& job : jobs) {
        if (!job.sources.attenuated) continue;
        const std::vector<bool> casters = castersIn(scene, std::size_t(job.first));
        job.media = std::size_t(std::find(sets.begin(), sets.end(), casters) - sets.begin());
        if (job.media < sets.size()) continue;
        sets.push_back(casters);
        media.push_back(cellMedia(scene, {}, media[0].grid.edge(), simd, wsCorner, margin, false, casters));
    }
}

}  // namespace

std::vector<CellLight> lightOnCells(const ViewScene& scene, const std::vector<int>& lights, double edge, Simd simd,
                                    const std::function<void()>& checkpoint, std::size_t& bytes) {
    // Light is looked up in the middle of sheets, which may lie beyond the kernels that reach into them.
    const double margin = (kernelRadius(scene) + 0.75 * scene.dials.sheetThickness) * voxelUnit(scene);
    const Vec3 wsCorner = cornerOfVoxels(scene, edge);
    std::vector<CellMedia> media{cellMedia(scene, {}, edge, simd, wsCorner, margin)};
    const int reach = 1 + static_cast<int>(std::ceil(margin / edge));
    const auto grid = std::make_shared<const CellGrid>(media.front().grid);
    const std::size_t rows = media.front().extinction.size();
    const bool grey = rows == 1;
    std::vector<Job> jobs;
    std::vector<CellLight> all;
    for (const std::vector<int>& group : groupsOf(scene, lights))
        for (Job& job : jobsOf(scene, group, grid, grey, all.emplace_back())) {
            bytes += job.field->bytes();
            if (job.far && (jobs.empty() || jobs.back().far != job.far)) bytes += job.far->bytes();
            if (job.lamp && isBlocked(scene, std::size_t(job.first))) job.open = std::make_shared<CellField>(grid, 1);
            if (job.open) bytes += job.open->bytes();
            jobs.push_back(std::move(job));
        }
    addMedia(scene, wsCorner, margin, simd, jobs, media);
    std::size_t most = 0;
    const Pass pass(scene, *grid, simd, checkpoint);
    CellSlices slices(*grid);
    for (int axis = 0; axis < 3; ++axis) {
        slices.layAlong(axis);
        for (std::size_t i = 0; i < rows * media.size(); ++i) {
            const std::size_t c = i / media.size(), m = i % media.size();
            m == 0 ? slices.fill(media[m].extinction[c], reach) : slices.refill(media[m].extinction[c]);
            for (const Job& job : jobs)
                if (job.media == m)
                    pass.add(job.sources, job.lamp ? Phase() : job.phase, job.wide, job.lamp,
                             grey ? -1 : static_cast<int>(c), slices, *job.field, job.far.get());
        }
        for (const Job& job : jobs) {
            if (!job.open) continue;
            constexpr int kForEdges = 4;  // times as many points, whose shadows have edges
            Sources open = sourcesOfLamp(*job.lamp, kForEdges * static_cast<int>(job.sources.lights.size()));
            open.attenuated = false;
            open.blocked = true;
            pass.add(open, Phase(), {}, nullptr, -1, slices, *job.open);
        }
        most = std::max(most, slices.bytes());
    }
    for (const Job& job : jobs)
        if (job.lamp)
            job.field->makeMean(media[job.media], job.open);
        else
            addPeaks(scene, job, media[job.media], checkpoint);
    for (const CellMedia& one : media) bytes += one.bytes();
    bytes += most;
    return all;
}

}  // namespace scrim
#endif
