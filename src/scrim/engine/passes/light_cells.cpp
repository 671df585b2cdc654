// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/passes/light_cells.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/lamps/lamp.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/passes/level_media.h>
#include <scrim/engine/passes/light_jobs.h>
#include <scrim/engine/passes/lit_surfaces.h>
#include <scrim/engine/passes/sharpen.h>
#include <scrim/engine/passes/sky_peaks.h>
#include <scrim/engine/passes/sources.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <span>
#include <thread>
#include <tuple>

#include <glm/geometric.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/passes/light_cells.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/passes/coarser_light-inl.h>
#include <scrim/engine/passes/light_cells-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// Passes the slices with one source after the other. Threads work on successive sources; each waits at every slice
// until the source before it has passed there, so that the order of all sums is that of the sources, whatever the
// number of threads. The checkpoint is called by the thread that called this.
template <class Raster, class Make, class Towards>
HWY_ATTR void passSlices(const std::vector<CellRays>& sources, const Make& make, const Passage& passage,
                         const Towards& towards) {
    CellSlices& box = passage.box;
    const std::size_t count = sources.size();
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
        CoarserLight coarser(passage.coarser, box);
        for (std::size_t m = next++; m < count; m = next++) {
            const Finish finish{passed[m], next};
            const bool held = coarser.any() && sources[m].attenuated;
            if (held) coarser.pass(sources[m], passage.down);
            Raster raster = make(sources[m], memory);
            for (int step = 0; step < box.size[2] && next < std::numeric_limits<std::size_t>::max() / 2; ++step) {
                if (step % 8 == 0 && std::this_thread::get_id() == caller) passage.checkpoint();
                const bool reached = raster.reaches(step);
                if (box.integral() && reached) raster.attenuateTo(step);
                while (m > 0 && passed[m - 1].load(std::memory_order_acquire) <= step) std::this_thread::yield();
                if (reached)
                    for (const int j : box.wantedRows[std::size_t(raster.slice(step))])
                        raster.light(step, j, passage.view, towards,
                                     held ? coarser.row(j, raster.slice(step)) : nullptr, box);
                passed[m].store(step + 1, std::memory_order_release);
                if (!box.integral() && reached) raster.attenuate(step);
            }
        }
    });
}

template <class Towards>
HWY_ATTR void sweepTowards(const std::vector<CellRays>& sources, const Passage& passage, const Towards& towards) {
    if (passage.parallel)
        passSlices<ParallelRaster>(
            sources,
            [&](const CellRays& rays, std::vector<Real>& memory) {
                return ParallelRaster(passage.box, rays, passage.view, memory);
            },
            passage, towards);
    else
        passSlices<PointRaster>(
            sources,
            [&](const CellRays& rays, std::vector<Real>& memory) {
                return PointRaster(passage.box, rays, passage.view, memory, passage.down);
            },
            passage, towards);
}

HWY_ATTR void sweepCells(const std::vector<CellRays>& sources, const Passage& passage) {
    const CellView& view = passage.view;
    if (!view.surface)
        sweepTowards(sources, passage, TowardsEye(view));
    else if (view.surface->specular > 0)
        sweepTowards(sources, passage, Reflected<true>(view, passage.box));
    else
        sweepTowards(sources, passage, Reflected<false>(view, passage.box));
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(sweepCells);

namespace {

// Exactly at the centre of a cell, a point would belong to no face of the cube around it.
// `wsFront`: to where it is moved from there, so that a surface does not hide it.
Vec3 placeOfPoint(const Vec3& ws, const Vec3& wsFront, const CellSlices& slices) {
    Vec3 shift = slices.edge() * Vec3(1e-4, 1.1e-4, 1.2e-4);
    for (int i = 0; i < 3; ++i) shift[i] = std::copysign(shift[i], wsFront[i]);
    return slices.place(ws + shift);
}

// One pass of some sources of light through the cells, for one or all colours.
class Pass {
  public:
    Pass(const ViewScene& scene, const CellGrid& grid, Simd simd, const std::function<void()>& checkpoint)
        : m_scene(scene),
          m_grid(grid),
          m_simd(simd),
          m_checkpoint(checkpoint),
          m_beside(1.5 * std::max(voxelUnit(scene) / grid.edge(), 1.0)) {}

    // `colour`: the only one that the slices' extinction is for; -1: all. What is shown of surfaces
    // must be faced. `coarser`: see Passage.
    void add(const LightJob& job, int colour, const std::vector<CellSlices>& coarser, CellSlices& slices) {
        const Sources& sources = job.sources;
        const Octave& octave = job.octave;
        const LampField* lamp = job.lamp.get();
        CellField& field = lamp ? job.lamp->knots()[job.knot].values : *job.field;
        const std::size_t colours = colour < 0 ? field.colours() : 1;
        CellView view;
        view.colours = colours;
        view.parallelEye = m_scene.camera.type == CameraType::orthographic;
        if (job.surface >= 0) {
            view.surface = m_scene.volumes[std::size_t(job.surface)].classified.get();
        } else if (!lamp) {
            view.phase = octave.phase;
        }
        view.eye =
            view.parallelEye ? slices.reordered(-viewingAxis(m_scene.camera)) : slices.place(m_scene.camera.wsPosition);
        if (sources.blocked)
            view.darkFrom = [&](const Vec3& from, const Vec3& perStep, bool parallel) {
                const Vec3 ws = slices.wsPlace(from);
                return darkFrom(ws, slices.wsPlace(from + perStep) - ws, parallel);
            };
        const auto before = lamp && hollowOnCells(lamp->lamp(), m_grid.edge())
                                ? slices.hollow(lamp->lamp().wsPosition, lamp->lamp().area()->radius)
                                : std::vector<std::pair<std::size_t, Real>>();
        // Each light is sharpened alone, because what limits that depends on all that is in the sums. What comes from
        // points has a part of it along each axis, which ends where the next one begins: it waits for all of them.
        const auto end = sources.owners.end();
        for (auto first = sources.owners.begin(), last = first; first != end; first = last) {
            last = std::upper_bound(first, end, *first);
            const std::size_t sums = job.mirrored ? 2 * colours : colours, to = colour < 0 ? 0 : std::size_t(colour);
            slices.clearSums(sums);
            const auto begin = std::size_t(first - sources.owners.begin());
            const auto [suns, points] =
                raysFrom(job, {begin, std::size_t(last - sources.owners.begin())}, colour, colours, slices);
            // The cells see each point along one of three axes.
            m_directions +=
                slices.wanted.cells() * (suns[0].size() + suns[1].size()) + slices.wanted.cells() * points.size() / 3;
            for (const bool down : {false, true}) {
                const auto pass = [&](const std::vector<CellRays>& rays, bool parallel) {
                    SCRIM_ON_TARGET(m_simd, sweepCells)(rays, {view, slices, coarser, m_checkpoint, parallel, down});
                };
                pass(suns[down ? 1 : 0], true);
                pass(points, false);
            }
            AreaField* area = job.areas.empty() ? nullptr : job.areas[std::size_t(sources.owners[begin])].get();
            if (area) slices.addTo(0, colours, to, area->lit());
            const bool sharp = !lamp && sources.attenuated, whole = area || (sharp && !points.empty());
            if (sharp && !whole) slices.sharpen(sums, job.surface >= 0);
            Waiting* waits = whole ? &waitingOf(job, begin, std::size_t(last - first)) : nullptr;
            slices.addTo(0, colours, to, waits ? waits->light : field);
            if (job.mirrored) slices.addTo(colours, colours, to, waits ? *waits->mirrored : *job.mirrored);
        }
        slices.restore(before);
        if (lamp && job.field) slices.addFarLight(*lamp, job.knot, colour, *job.field);
    }

    // Once light has passed along all axes: adds what has waited for that to the fields of its jobs.
    void finish() {
        for (Waiting& waits : m_waiting) {
            const LightJob& job = *waits.job;
            const bool steep = job.surface >= 0;
            if (job.sources.attenuated) sharpenAround(waits.wsSource, steep, waits.light);
            if (waits.area) waits.area->keepFar(waits.light);
            job.field->add(waits.light);
            if (!job.mirrored) continue;
            sharpenAround(waits.wsSource, steep, *waits.mirrored);
            job.mirrored->add(*waits.mirrored);
        }
    }

    // Pairs of cells and sources so far.
    std::uint64_t directions() const { return m_directions; }
    std::size_t bytes() const {
        std::size_t bytes = 0;
        for (const Waiting& waits : m_waiting)
            bytes += waits.light.bytes() + (waits.mirrored ? waits.mirrored->bytes() : 0);
        return bytes;
    }

  private:
    // What has come of one light's points so far.
    struct Waiting {
        const LightJob* job;
        std::size_t first;  // of its sources
        const AreaField* area;
        Vec3 wsSource;
        CellField light;
        std::optional<CellField> mirrored;
    };
    // That of `count` sources of a job from `first` on.
    Waiting& waitingOf(const LightJob& job, std::size_t first, std::size_t count) {
        const auto known =
            std::ranges::find_if(m_waiting, [&](const Waiting& w) { return w.job == &job && w.first == first; });
        if (known != m_waiting.end()) return *known;
        Vec3 wsSource(0);
        for (std::size_t i = 0; i < count; ++i)
            wsSource += job.sources.lights[first + i].wsPosition / static_cast<double>(count);
        const auto owner = std::size_t(job.sources.owners[first]);
        Waiting& waits = m_waiting.emplace_back(Waiting{
            &job, first, job.areas.empty() ? nullptr : job.areas[owner].get(), wsSource, job.field->blackAlike(), {}});
        if (job.mirrored) waits.mirrored = job.mirrored->blackAlike();
        return waits;
    }
    // Of a light, those that go up, those that go down, and those of points.
    struct Rays {
        std::vector<CellRays> suns[2], points;
    };
    // The rays of the sources of one light, `range` of those of a job, that pass the slices along their axis, with
    // weights for `colours`, of which `colour` is the first and only one unless it is -1.
    Rays raysFrom(const LightJob& job, std::pair<std::size_t, std::size_t> range, int colour, std::size_t colours,
                  const CellSlices& slices) const {
        static const WidePhase kNarrow;
        const Sources& sources = job.sources;
        const Octave& octave = job.octave;
        const WidePhase& wide = job.wide.empty() ? kNarrow : job.wide[std::size_t(sources.owners[range.first])];
        Rays out;
        for (std::size_t i = range.first; i < range.second; ++i) {
            const Light& light = sources.lights[i];
            CellRays rays = raysOf(sources, light, slices);
            rays.extinction = octave.extinction;
            if (wide.ofSky) rays.phaseRow = wide.ofSky->row.data();
            if (!wide.ofSun.empty()) rays.phaseRow = wide.ofSun.data();
            if (wide.ofSurface) {
                rays.caps = wide.ofSurface.get();
                rays.capRadius = std::sqrt(sources.parts[i] / std::numbers::pi) / m_grid.edge();
            }
            // Relative to the tint where there is one value for all colours.
            for (int c = 0; c < static_cast<int>(colours); ++c)
                rays.weight[c] =
                    static_cast<Real>(octave.share * (sources.colours == 3 ? light.intensity[colour < 0 ? c : colour]
                                                                           : largest(light.intensity)));
            if (!rays.parallel)
                out.points.push_back(rays);
            else if (axisOfLargest(glm::abs(light.wsDirection)) == slices.axes[2])
                out.suns[rays.way.z < 0 ? 1 : 0].push_back(rays);
        }
        return out;
    }
    // Cells on both sides of a surface, less than a voxel away, are looked up together. If it hides
    // what is behind it, the eye sees but one side of it: where the light shines on that one, cells
    // behind it are lit, too, and else those in front are dark.
    double darkFrom(const Vec3& ws, const Vec3& wsPerStep, bool parallel) const {
        constexpr double kInfinity = std::numeric_limits<double>::infinity();
        const SolidHit hit =
            m_scene.solids->trace(SolidRole::shadow, ws, wsPerStep, parallel ? -kInfinity : 0, kInfinity);
        if (hit.t == kInfinity || !hit.solid->holdout) return hit.t;
        const bool seen = glm::dot(hit.wsNormal, wsPerStep) *
                              glm::dot(hit.wsNormal, -travelToEye(m_scene.camera, ws + hit.t * wsPerStep)) >
                          0;
        return hit.t + (seen ? m_beside : -m_beside);
    }
    CellRays raysOf(const Sources& sources, const Light& light, const CellSlices& slices) const {
        CellRays rays{.parallel = light.distant(), .way = slices.reordered(light.wsDirection)};
        rays.lamp = sources.lamp;
        rays.attenuated = sources.attenuated;
        rays.blocked = sources.blocked;
        if (rays.parallel) return rays;
        const double edge = m_grid.edge();
        rays.from = placeOfPoint(light.wsPosition, light.element() ? light.wsDirection : Vec3(1), slices);
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
    double m_beside;  // how far behind a surface cells may be looked up together with those in front, cells
    std::uint64_t m_directions = 0;
    std::vector<Waiting> m_waiting;
};

// Finds what holds back the light of each job: on the level's own cells without its surfaces'
// extinction, which is added.
void findMedia(const LevelScene& level, const LevelMedia& media, const LitSurfaces& surfaces,
               std::vector<LightJob>& jobs, std::vector<Holding>& held) {
    for (LightJob& job : jobs) {
        if (!job.sources.attenuated) continue;
        const std::vector<bool> casters = castersIn(level.all, std::size_t(job.first));
        const auto known = std::ranges::find(held, casters, &Holding::casters);
        job.media = std::size_t(known - held.begin());
        if (known != held.end()) continue;
        held.push_back(media.of(casters, &held.front().own.grid));
        surfaces.addTo(held.back().own, both(casters, withVoxels(level.holding)));
    }
}

// Of the grid's stored blocks, those that the eye sees something of, through surfaces alone. Light
// need not be known where less than kUnseen of it would come through.
std::vector<bool> blocksSeen(const ViewScene& scene, const CellGrid& grid, const LitSurfaces& surfaces, int reach,
                             Simd simd, const std::function<void()>& checkpoint) {
    constexpr double kUnseen = 1e-4;
    std::vector<bool> hiding;
    for (const ViewVolume& volume : scene.volumes) hiding.push_back(!volume.holdout);
    std::vector<Real> extinction(grid.cells(), Real(0));
    surfaces.addTo(extinction, hiding);
    const bool parallel = scene.camera.type == CameraType::orthographic;
    const Vec3 wsAxis = viewingAxis(scene.camera);
    CellSlices slices(grid);
    std::vector<bool> seen(grid.storedBlocks().size(), false);
    for (int axis = 0; axis < 3; ++axis) {
        if (parallel && axisOfLargest(glm::abs(wsAxis)) != axis) continue;
        slices.layAlong(axis);
        slices.fill(extinction, reach, surfaces.byValue());
        surfaces.classify(slices);
        slices.clearSums(1);
        CellRays rays{.parallel = parallel,
                      .way = slices.reordered(wsAxis),
                      .from = placeOfPoint(scene.camera.wsPosition, Vec3(1), slices)};
        rays.weight[0] = 1;
        const CellView even;
        const std::vector<CellSlices> coarser;
        for (const bool down : {false, true})
            if (!parallel || down == (rays.way.z < 0))
                SCRIM_ON_TARGET(simd, sweepCells)({rays}, {even, slices, coarser, checkpoint, parallel, down});
        slices.markBlocks(static_cast<Real>(kUnseen / (4 * std::numbers::pi)), seen);
    }
    return seen;
}

// Fills what area lights would show close to them if nothing held it back, for a radiance of 1.
void passOpenAreas(const std::vector<LightJob>& jobs, Pass& pass) {
    for (const LightJob& job : jobs)
        for (std::size_t owner = 0; owner < job.areas.size(); ++owner) {
            const std::shared_ptr<AreaField>& area = job.areas[owner];
            if (!area) continue;
            LightJob open{job.first, {}, job.octave, {area, &area->open()}};
            open.sources.attenuated = false;
            open.wide = {job.wide[owner]};
            for (std::size_t i = 0; i < job.sources.lights.size(); ++i) {
                if (std::size_t(job.sources.owners[i]) != owner) continue;
                Light& light = open.sources.lights.emplace_back(job.sources.lights[i]);
                light.intensity = Rgb(job.sources.parts[i]);
                open.sources.parts.push_back(job.sources.parts[i]);
            }
            open.sources.owners.assign(open.sources.lights.size(), 0);
            CellSlices slices(area->open().grid());
            const std::vector<Real> empty(area->open().grid().cells(), Real(0));
            for (int axis = 0; axis < 3; ++axis) {
                slices.layAlong(axis);
                slices.fill(empty, CellSlices::kEverywhere);
                pass.add(open, -1, {}, slices);
            }
        }
}

// Fills what solids let through of the lamps' light.
void passOpen(const std::vector<LightJob>& jobs, Pass& pass, CellSlices& slices) {
    std::set<const CellField*> opened;  // octaves of a lamp share it
    for (const LightJob& job : jobs) {
        if (!job.open || !opened.insert(job.open.get()).second) continue;
        constexpr int kForEdges = 4;  // times as many points, whose shadows have edges
        Sources open = sourcesOfLamp(job.lamp->lamp(), kForEdges * static_cast<int>(job.sources.lights.size()));
        open.attenuated = false;
        open.blocked = true;
        pass.add(LightJob{job.first, std::move(open), {}, job.open}, -1, {}, slices);
    }
}

// What is left to do once light has passed along all axes. `held`: what holds back that of each job.
void finishJobs(const ViewScene& scene, const std::vector<LightJob>& jobs, const std::vector<Holding>& held, Pass& pass,
                const std::function<void()>& checkpoint) {
    pass.finish();
    std::set<const AreaField*> areas;  // octaves share them
    for (const LightJob& job : jobs)
        for (const std::shared_ptr<AreaField>& area : job.areas)
            if (area && areas.insert(area.get()).second) area->keepNear();
    passOpenAreas(jobs, pass);
    for (const LightJob& job : jobs)
        if (job.lamp && job.knot == 0)
            job.lamp->makeMean(held[job.media].together(), job.open);
        else if (!job.lamp && job.surface < 0)
            addPeaks(scene, job.sources, job.wide, job.octave, held[job.media].together(), *job.field, checkpoint);
}

// The light of these octaves on cells of `edge`.
std::vector<CellLight> octavesOnCells(const LevelScene& level, const std::vector<int>& lights,
                                      const OctaveCells& octaves, double edge, Simd simd,
                                      const std::function<void()>& checkpoint, CellLightWork& work) {
    const ViewScene &scene = level.all, &own = level.own, &holding = level.holding;
    // Light is looked up in the middle of sheets, which may lie beyond the kernels that reach into
    // them. Cells of surfaces know where these begin; only texels blur that.
    const std::vector<bool> filled = mediaAmong(holding, withVoxels(holding));
    const bool alone = std::ranges::find(filled, true) == filled.end();
    const double sheets = 0.75 * scene.dials.sheetThickness, kernels = kernelRadius(own), unit = voxelUnit(own);
    const double margin = (kernels + sheets) * unit;
    const double near = (alone ? std::min(scene.dials.texel, kernels) + sheets : kernels + sheets) * unit;
    const int reach = 1 + static_cast<int>(std::ceil(near / edge));
    const LevelMedia media(level, edge, margin, simd);
    std::vector<Holding> held{media.of(withVoxels(scene), nullptr)};
    const auto grid = std::make_shared<const CellGrid>(held.front().own.grid);
    LitSurfaces surfaces(holding, *grid);
    if (hasSurfaces(own))
        surfaces.show(blocksSeen(holding, *grid, surfaces, reach, simd, checkpoint), withVoxels(own), media.corner(),
                      near);
    const std::vector<const CellGrid*> shown = alone ? surfaces.grids() : std::vector<const CellGrid*>();
    surfaces.addTo(held.front().own, withVoxels(holding));
    const std::size_t rows = held.front().own.extinction.size();
    const bool grey = rows == 1;
    std::vector<CellLight> all;
    std::vector<LightJob> jobs = lightJobs(level, lights, octaves, grid, surfaces, grey, all);
    if (jobs.empty()) return all;
    work.bytes += bytesOf(jobs);
    findMedia(level, media, surfaces, jobs, held);
    std::size_t most = 0;
    Pass pass(own, *grid, simd, checkpoint);
    const CoarserSlices coarser(held.front());
    CellSlices slices(*grid);
    for (int axis = 0; axis < 3; ++axis) {
        slices.layAlong(axis);
        for (std::size_t i = 0; i < rows * held.size(); ++i) {
            const std::size_t c = i / held.size(), m = i % held.size();
            m == 0 ? slices.fill(held[m].own.extinction[c], reach, surfaces.byValue(), shown)
                   : slices.refill(held[m].own.extinction[c]);
            const std::vector<CellSlices> before = coarser.along(axis, held[m], c);
            for (const LightJob& job : jobs) {
                if (job.media != m) continue;
                if (job.surface >= 0) surfaces.face(job.surface, slices);
                if (m == 0 && job.sources.attenuated) surfaces.classify(slices);
                pass.add(job, grey ? -1 : static_cast<int>(c), before, slices);
                slices.classify(nullptr, nullptr);
            }
        }
        passOpen(jobs, pass, slices);
        most = std::max(most, slices.bytes());
    }
    finishJobs(scene, jobs, held, pass, checkpoint);
    for (const Holding& one : held) work.bytes += one.bytes();
    work.bytes += most + surfaces.bytes() + pass.bytes();
    work.directions += pass.directions();
    return all;
}

}  // namespace

std::vector<CellLight> lightOnCells(const LevelScene& level, const std::vector<int>& lights, double edge, Simd simd,
                                    const std::function<void()>& checkpoint, CellLightWork& work) {
    std::vector<CellLight> all;
    for (const OctaveCells& octaves : octaveCells(level, lights, edge))
        for (CellLight& light : octavesOnCells(level, lights, octaves, octaves.larger * edge, simd, checkpoint, work))
            all.push_back(std::move(light));
    return all;
}

}  // namespace scrim
#endif
