// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/solve/scattered_light.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/solve/last_sweep.h>
#include <scrim/engine/solve/first_light.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

// The parts of a target that are solved for one by one, and the colour of each solve's light, relative to its largest
// component. Where all media are grey, a part is all light of one colour; else it is red, green or blue.
std::vector<std::pair<ScatterTarget, Rgb>> partsOf(const ViewScene& scene, const TransportPlan& plan,
                                                   const ScatterTarget& target) {
    std::vector<std::pair<ScatterTarget, Rgb>> parts;
    const auto ofColour = [&](const Rgb& colour) -> ScatterTarget& {
        for (auto& [part, own] : parts)
            if (plan.brightest || sameColour(own, colour)) return part;
        return parts.emplace_back(ScatterTarget{target.output, {}}, colour / largest(colour)).first;
    };
    bool separable = greyScattering(scene) && greySolids(scene);
    for (const int light : target.lights) {
        ofColour(scene.lights[std::size_t(light)].intensity).lights.push_back(light);
        separable = separable && !scene.lights[std::size_t(light)].slide;
    }
    if (target.ambient) ofColour(scene.ambient).ambient = true;
    Rgb glow(0);
    for (const ViewVolume& volume : scene.volumes)
        for (const ViewEmission& emission : volume.emission) {
            if (!target.emission || emission.color == Rgb(0)) continue;
            separable = separable && (glow == Rgb(0) || sameColour(glow, emission.color));
            glow = emission.color;
            ofColour(glow).emission = true;
        }
    if (plan.brightest || (separable && parts.size() <= 3)) return parts;
    parts.clear();
    for (const Rgb& colour : {Rgb(1, 0, 0), Rgb(0, 1, 0), Rgb(0, 0, 1)}) parts.emplace_back(target, colour);
    return parts;
}

// True if light of the target comes in from outside of the cells.
bool comesIn(const ViewScene& scene, const ScatterTarget& target) {
    return target.ambient || std::any_of(target.lights.begin(), target.lights.end(),
                                         [&](int light) { return scene.lights[std::size_t(light)].dome(); });
}

// What the cells keep of radiance along ordinates: what an eye sees of it after one more scattering, its mean over all
// directions, or that and its flux.
enum class Kept { towardsEye, mean, meanAndFlux };

class ScatteredLight {
  public:
    ScatteredLight(const ViewScene& scene, const TransportPlan& plan, Kept kept, Simd simd,
                   const std::function<void()>& checkpoint);

    std::vector<CellLight> lights() const;
    // Along x, y and z; null unless it is kept.
    const std::array<std::shared_ptr<CellField>, 3>& flux() const { return m_flux; }

    const Solved& solved() const { return m_solved; }
    // Peak memory.
    std::size_t bytes() const { return m_bytes; }

  private:
    void solve(const ViewScene& scene, const CellMedia& media, const std::vector<ScatterClass>& classes,
               const TransportPlan& plan, Simd simd, const std::function<void()>& checkpoint);
    enum { full = 1, once = 2 };
    void keep(const std::vector<ScatterClass>& classes, const TransportSolver& solver,
              const std::vector<std::vector<Real>>& kept, const std::vector<std::vector<Real>>& straight, int which,
              const Rgb& colours, const std::shared_ptr<CellField>* fields) const;
    void keepFlux(const TransportSolver& solver, const std::vector<std::vector<Real>>& kept,
                  const std::vector<std::vector<Real>>& straight, const Rgb& colours);
    void limitFlux();
    // Returns the bytes that it took.
    std::size_t extrapolate(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                            const std::function<void()>& checkpoint);
    // Takes what has not scattered before out of the fields.
    void separate();
    void fillBorders(const TransportSolver& solver, CellField& field) const;

    Kept m_kept;
    std::shared_ptr<const CellGrid> m_grid;
    std::vector<ScatterTarget> m_targets;
    std::vector<int> m_classOf;  // class of each volume of the scene; -1: none
    std::size_t m_classes = 0;
    std::vector<std::shared_ptr<CellField>> m_fields;  // [target][class]
    // Likewise, what of it comes in from outside and has not scattered before; null: nothing, or nobody asks for it.
    std::vector<std::shared_ptr<CellField>> m_unscattered;
    std::array<std::shared_ptr<CellField>, 3> m_flux;  // of all targets, along x, y and z
    Solved m_solved;
    std::size_t m_bytes = 0;
};

ScatteredLight::ScatteredLight(const ViewScene& scene, const TransportPlan& plan, Kept kept, Simd simd,
                               const std::function<void()>& checkpoint)
    : m_kept(kept), m_targets(plan.targets) {
    const std::vector<ScatterClass> classes = scatterClasses(scene, solvedOrdinates(plan.ordinates));
    m_classes = classes.size();
    m_classOf.assign(scene.volumes.size(), -1);
    for (std::size_t k = 0; k < classes.size(); ++k)
        for (const int volume : classes[k].volumes) m_classOf[std::size_t(volume)] = static_cast<int>(k);
    const CellMedia media = cellMedia(scene, classes, plan.edge, simd, {.walls = true});
    m_grid = std::make_shared<const CellGrid>(media.grid);
    const bool apart = wants(scene, Layer::indirect);
    for (const ScatterTarget& target : m_targets)
        for (std::size_t k = 0; k < m_classes; ++k) {
            m_bytes += m_fields.emplace_back(std::make_shared<CellField>(m_grid, 3))->bytes();
            auto& unscattered = m_unscattered.emplace_back();
            if (apart && comesIn(scene, target)) unscattered = std::make_shared<CellField>(m_grid, 3);
            if (unscattered) m_bytes += unscattered->bytes();
        }
    for (auto& flux : m_flux)
        if (m_kept == Kept::meanAndFlux) m_bytes += (flux = std::make_shared<CellField>(m_grid, 3))->bytes();
    m_bytes += media.bytes();
    const std::size_t fields = m_bytes;
    if (m_grid->cells() > 0) solve(scene, media, classes, plan, simd, checkpoint);
    // The solver is gone when that of larger cells comes.
    if (m_grid->cells() > 0 && !plan.coarse && m_grid->sides() == 0)
        m_bytes = std::max(m_bytes, fields + extrapolate(scene, plan, simd, checkpoint));
    if (!plan.coarse) separate();
    limitFlux();
}

// A path of light runs from a light to the eye by way of volumes that scatter fully, which scatter it any number of
// times, and of volumes that scatter once: at most one of them scatters it, and only once. So there are two solves.
// The first is of paths that only volumes that scatter fully have scattered so far; all volumes show its light. The
// second begins with the light that volumes that scatter once send on, from lights and from the first solve; only
// volumes that scatter fully show it.
void ScatteredLight::solve(const ViewScene& scene, const CellMedia& media, const std::vector<ScatterClass>& classes,
                           const TransportPlan& plan, Simd simd, const std::function<void()>& checkpoint) {
    const Ordinates directions = ordinates(solvedOrdinates(plan.ordinates));
    const bool eye = m_kept == Kept::towardsEye, flux = m_kept == Kept::meanAndFlux;
    TransportSolver solver(media, classes, {directions, scene.dials.scatterError, 60, simd, checkpoint, flux});
    LastSweep last(scene, media, classes, plan.ordinates, {eye ? &scene.camera : nullptr, flux}, solver, simd);
    const bool someOnce = std::ranges::any_of(classes, &ScatterClass::once);
    std::size_t beside = 0;  // the most bytes of the light beside the solver
    for (std::size_t t = 0; t < m_targets.size(); ++t) {
        for (const auto& [target, colours] : partsOf(scene, plan, m_targets[t])) {
            const auto colour = std::size_t(axisOfLargest(colours));
            const auto light = [&](bool ofOnce) {
                return FirstLight(scene, target, int(colour), ofOnce, media, {last.media(), last.classes(), !eye},
                                  solver);
            };
            const auto keepIn = [&](const std::vector<std::shared_ptr<CellField>>& fields, int which, const auto& kept,
                                    const auto& straight, double factor) {
                keep(last.classes(), solver, kept, straight, which, factor * colours, &fields[t * m_classes]);
            };
            const std::vector<std::vector<Real>> none;
            const FirstLight first = light(false);
            first.addTo(directions, classes, media, simd, solver.clearedSource());
            m_solved += solver.solve(colour, inflowOf(scene, target, directions, int(colour)));
            const std::vector<Real> before = someOnce ? solver.radiance() : std::vector<Real>();
            const std::vector<Real> inflow = inflowOf(scene, target, last.ordinates(), int(colour));
            const auto kept = last.pass(colour, inflow, true, [&](const Ordinates& along, std::vector<Real>& source) {
                first.addTo(along, last.classes(), last.media(), simd, source);
            });
            keepIn(m_fields, full | once, kept, first.straight(), 1);
            keepFlux(solver, kept, first.straight(), colours);
            beside = std::max(beside, (someOnce ? 2 : 1) * first.bytes() + before.size() * sizeof(Real));
            const bool apart = !inflow.empty() && m_classes > 0 && m_unscattered[t * m_classes];
            if (!inflow.empty() && (apart || someOnce)) {
                const auto unscattered = last.pass(colour, inflow, false, {});
                if (apart) keepIn(m_unscattered, full, unscattered, none, 1);
                if (apart) keepFlux(solver, unscattered, none, -colours);
                keepIn(m_fields, once, unscattered, none, -1);  // they see it as a medium that scatters once does
            }
            if (!someOnce) continue;
            const FirstLight again = light(true);
            again.addTo(directions, classes, media, simd, solver.clearedSource());
            last.addScattered(true, colour, before, directions, solver.source());
            m_solved += solver.solve(colour, {});
            const auto second = last.pass(colour, {}, true, [&](const Ordinates& along, std::vector<Real>& source) {
                again.addTo(along, last.classes(), last.media(), simd, source);
                last.addScattered(true, colour, before, along, source);
            });
            keepIn(m_fields, full, second, none, 1);
            keepFlux(solver, second, none, colours);
        }
        for (std::size_t f = t * m_classes; f < (t + 1) * m_classes; ++f)
            for (const auto& field : {m_fields[f], m_unscattered[f]})
                if (field) fillBorders(solver, *field);
    }
    for (const auto& field : m_flux)
        if (field) fillBorders(solver, *field);
    m_solved.cellDirections += last.cellDirections();
    m_bytes += solver.bytes() + last.bytes() + beside;
}

// Adds what is kept of a pass to a target's fields, for the cells inside of blocks. `which`: full, once or both.
void ScatteredLight::keep(const std::vector<ScatterClass>& classes, const TransportSolver& solver,
                          const std::vector<std::vector<Real>>& kept, const std::vector<std::vector<Real>>& straight,
                          int which, const Rgb& colours, const std::shared_ptr<CellField>* fields) const {
    for (std::size_t k = 0; k < classes.size(); ++k) {
        if ((which & (classes[k].once ? once : full)) == 0) continue;
        const bool beams = !straight.empty() && !classes[k].once;
        const std::size_t own = m_kept == Kept::towardsEye ? k : 0;
        parallelFor(solver.rows(), [&](std::size_t row) {
            // Series and differences may go below zero.
            const Real light = std::max(kept[k][row] + (beams ? straight[own][row] : Real(0)), Real(0));
            Real* to = fields[k]->cell(solver.cellOfRow()[row]);
            for (int c = 0; c < 3; ++c) to[c] = std::max(to[c] + static_cast<Real>(colours[c]) * light, Real(0));
        });
    }
}

// Adds the flux of a pass.
void ScatteredLight::keepFlux(const TransportSolver& solver, const std::vector<std::vector<Real>>& kept,
                              const std::vector<std::vector<Real>>& straight, const Rgb& colours) {
    for (std::size_t axis = 0; m_kept == Kept::meanAndFlux && axis < 3; ++axis)
        parallelFor(solver.rows(), [&](std::size_t row) {
            const Real flux = kept[m_classes + axis][row] + (straight.empty() ? Real(0) : straight[1 + axis][row]);
            Real* to = m_flux[axis]->cell(solver.cellOfRow()[row]);
            for (int c = 0; c < 3; ++c) to[c] += static_cast<Real>(colours[c]) * flux;
        });
}

// Fills the cells around each block from its neighbours. Cells without a row of their own get the mean of neighbours
// that have one, because kernels reach a little further than voxels.
void ScatteredLight::fillBorders(const TransportSolver& solver, CellField& field) const {
    const auto known = [&](const Int3& place) -> const Real* {
        const std::ptrdiff_t cell = m_grid->index(place);
        if (cell < 0 || solver.rowOfCell()[std::size_t(cell)] < 0) return nullptr;
        return field.cell(std::size_t(cell));
    };
    parallelFor(m_grid->storedBlocks().size(), [&](std::size_t block) {
        const Int3 first = m_grid->storedBlocks()[block] * kCellEdge - 1;
        const bool walls = m_grid->walled(block) >= 0;
        Real* to = field.block(block);
        for (int z = 0; z < kPaddedEdge; ++z)
            for (int y = 0; y < kPaddedEdge; ++y)
                for (int x = 0; x < kPaddedEdge; ++x, to += 3) {
                    const Int3 place = first + Int3(x, y, z);
                    if (const Real* own = known(place)) {
                        if (own != to) std::copy_n(own, 3, to);
                        continue;
                    }
                    int count = 0;
                    Real sum[3] = {0, 0, 0};
                    for (int i = 0; i < 27; ++i) {
                        const Int3 beside = place + Int3(i % 3, i / 3 % 3, i / 9) - 1;
                        const Real* near = known(beside);
                        if (near && (!walls || m_grid->sees(m_grid->wsInside(place), m_grid->wsInside(beside)))) {
                            ++count;
                            for (int c = 0; c < 3; ++c) sum[c] += near[c];
                        }
                    }
                    for (int c = 0; c < 3; ++c) to[c] = count > 0 ? sum[c] / static_cast<Real>(count) : Real(0);
                }
    });
}

// The mean is extrapolated, and the flux is not; a series may be a little longer than the mean, too.
void ScatteredLight::limitFlux() {
    if (m_kept != Kept::meanAndFlux) return;
    parallelFor(m_grid->storedBlocks().size(), [&](std::size_t block) {
        for (std::size_t i = 0; i < 3 * kPaddedCells; ++i) {
            double mean = 0, length2 = 0;
            for (std::size_t k = 0; k < m_classes; ++k) {  // classes that scatter once lack what has not scattered
                double sum = 0;
                for (std::size_t f = k; f < m_fields.size(); f += m_classes)
                    sum += double(m_fields[f]->block(block)[i]);
                mean = std::max(mean, sum);
            }
            for (const auto& flux : m_flux) length2 += std::pow(double(flux->block(block)[i]), 2);
            if (length2 <= mean * mean) continue;
            const double factor = mean / std::sqrt(length2);
            for (const auto& flux : m_flux) flux->block(block)[i] *= static_cast<Real>(factor);
        }
    });
}

std::vector<CellLight> ScatteredLight::lights() const {
    std::vector<CellLight> all;
    for (std::size_t t = 0; t < m_targets.size(); ++t) {
        const auto add = [&](bool again, const std::vector<std::shared_ptr<CellField>>& fields) {
            CellLight& light = all.emplace_back(CellLight{m_targets[t].output, again, {}});
            std::vector<std::shared_ptr<const VolumeLight>> ofClass;
            for (std::size_t k = 0; k < m_classes; ++k)
                ofClass.push_back(std::make_shared<const VolumeLight>(VolumeLight{fields[t * m_classes + k], {}}));
            for (const int cls : m_classOf) light.ofVolume.push_back(cls < 0 ? nullptr : ofClass[std::size_t(cls)]);
        };
        add(true, m_fields);
        if (m_classes > 0 && m_unscattered[t * m_classes]) add(false, m_unscattered);
    }
    return all;
}

// The error of cells falls with their edge: to a half if light and density vary together within a cell, to a quarter if
// fields are smooth. Measured against path tracers on fractal and on smooth smoke: subtracting a half of the additional
// error of cells twice as large leaves less than half of the error in both cases (L. F. Richardson, 1911). The rate
// cannot be measured with even larger cells, which do not resolve the fields and always suggest first order. Surfaces
// are of first order: in a brain with cells of 1.2 voxels, 2.7 % were left with a half, and 1.3 % with all. Walls that
// send light back stand elsewhere on larger cells, which says nothing about the cells' error: in a room 20 cells wide
// it grew from 3.4 to 4.5 %, in one of 40 cells from 0.1 to 2
// %. There is no extrapolation then.
std::size_t ScatteredLight::extrapolate(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                                        const std::function<void()>& checkpoint) {
    const auto part = Real(scattersInSurfaces(scene) ? 1 : 0.5);
    TransportPlan larger = plan;
    larger.coarse = true;
    larger.edge = 2 * plan.edge;
    const ScatteredLight twice(scene, larger, m_kept == Kept::towardsEye ? m_kept : Kept::mean, simd, checkpoint);
    m_solved += twice.m_solved;
    const auto improve = [&](CellField& field, const CellField& coarse) {
        parallelFor(m_grid->storedBlocks().size(), [&](std::size_t block) {
            const Int3 first = m_grid->storedBlocks()[block] * kCellEdge - 1;
            const bool walls = m_grid->walled(block) >= 0;
            Real* to = field.block(block);
            for (std::size_t i = 0; i < kPaddedCells; ++i, to += 3) {
                const auto n = static_cast<int>(i);
                const Int3 place =
                    first + Int3(n % kPaddedEdge, n / kPaddedEdge % kPaddedEdge, n / (kPaddedEdge * kPaddedEdge));
                const Vec3 ws = walls ? m_grid->wsInside(place) : m_grid->wsFromCs(Vec3(place) + 0.5);
                Real two[3];
                coarse.sample(ws, two);
                for (int c = 0; c < 3; ++c) to[c] = std::clamp(to[c] + part * (to[c] - two[c]), to[c] / 2, 2 * to[c]);
            }
        });
    };
    for (std::size_t f = 0; f < m_fields.size(); ++f) improve(*m_fields[f], *twice.m_fields[f]);
    for (std::size_t f = 0; f < m_unscattered.size(); ++f)
        if (m_unscattered[f]) improve(*m_unscattered[f], *twice.m_unscattered[f]);
    return twice.m_bytes;
}

void ScatteredLight::separate() {
    for (std::size_t f = 0; f < m_unscattered.size(); ++f)
        for (std::size_t block = 0; m_unscattered[f] && block < m_grid->storedBlocks().size(); ++block) {
            Real *all = m_fields[f]->block(block), *unscattered = m_unscattered[f]->block(block);
            for (std::size_t i = 0; i < kPaddedCells * m_fields[f]->colours(); ++i) {
                unscattered[i] = std::min(unscattered[i], all[i]);
                all[i] -= unscattered[i];
            }
        }
}

}  // namespace

bool scattersInSurfaces(const ViewScene& scene) {
    constexpr double kDense = 1;
    return std::ranges::any_of(scene.volumes, [&](const ViewVolume& v) {
        return v.classified && scattersFully(v) && std::ranges::any_of(v.classified->transfer, [&](const auto& point) {
                   return point.extinction * v.classified->densityScale * voxelUnit(scene) > kDense;
               });
    });
}

std::size_t solvesOf(const ViewScene& scene, const TransportPlan& plan) {
    std::size_t solves = 0;
    for (const ScatterTarget& target : plan.targets) solves += partsOf(scene, plan, target).size();
    return solves;
}

std::vector<CellLight> scatteredLight(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                                      const std::function<void()>& checkpoint, Solved& solved, std::size_t& bytes) {
    const ScatteredLight light(scene, plan, Kept::towardsEye, simd, checkpoint);
    solved += light.solved();
    bytes += light.bytes();
    return light.lights();
}

std::pair<std::vector<CellLight>, std::array<std::shared_ptr<CellField>, 3>> scatteredMoments(
    const ViewScene& scene, const TransportPlan& plan, bool flux, Simd simd, const std::function<void()>& checkpoint,
    Solved& solved) {
    const ScatteredLight light(scene, plan, flux ? Kept::meanAndFlux : Kept::mean, simd, checkpoint);
    solved += light.solved();
    return {light.lights(), light.flux()};
}

}  // namespace scrim
