// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/solve/domain_light.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/model/served_lights.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/solve/first_light.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

// True if light of the target comes in from outside of the cells.
bool comesIn(const ViewScene& scene, const ScatterTarget& target) {
    return target.ambient || std::any_of(target.lights.begin(), target.lights.end(),
                                         [&](int light) { return entersAtBorder(scene, std::size_t(light)); });
}

}  // namespace

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

std::size_t DomainBorder::bytes() const {
    std::size_t values = 0;
    const auto add = [&](const Inflow& inflow) {
        for (const std::vector<Real>& side : inflow.byNode) values += side.size();
    };
    for (const PassInflow& pass : passes) {
        add(pass.ofSolve);
        for (const Inflow& part : pass.ofParts) add(part);
    }
    return values * sizeof(Real) + (around ? around->media.bytes() + around->split.bytes() : 0);
}

DomainLight::DomainLight(const Settings& settings, const CellMedia& media, const DomainBorder* border,
                         const std::vector<DomainBorder*>& inner)
    : m_kept(settings.kept),
      m_grid(std::make_shared<const CellGrid>(media.grid)),
      m_classes(settings.classes.size()),
      m_rings(std::max(1, static_cast<int>(std::ceil(reachOfWideKernels(settings.scene) / media.grid.edge())))) {
    const bool apart = wants(settings.scene, Layer::indirect);
    for (const ScatterTarget& target : settings.plan.targets)
        for (std::size_t k = 0; k < m_classes; ++k) {
            m_fields.push_back(std::make_shared<CellField>(m_grid, 3));
            auto& unscattered = m_unscattered.emplace_back();
            if (apart && comesIn(settings.scene, target)) unscattered = std::make_shared<CellField>(m_grid, 3);
        }
    for (auto& flux : m_flux)
        if (m_kept == KeptLight::meanAndFlux) flux = std::make_shared<CellField>(m_grid, 3);
    if (m_grid->cells() > 0) solve(settings, media, border, inner);
}

std::size_t DomainLight::bytes() const {
    std::size_t bytes = 0;
    for (const auto* fields : {&m_fields, &m_unscattered})
        for (const auto& field : *fields) bytes += field ? field->bytes() : 0;
    for (const auto& field : m_flux) bytes += field ? field->bytes() : 0;
    return bytes;
}

// The solver of a domain, and its passes one after the other.
struct DomainLight::Passes {
    Passes(const Settings& settings, const CellMedia& media, const DomainBorder* of,
           const std::vector<DomainBorder*>& within)
        : scene(settings.scene),
          border(of),
          inner(within),
          eye(settings.kept == KeptLight::towardsEye),
          flux(settings.kept == KeptLight::meanAndFlux),
          directions(ordinates(solvedOrdinates(settings.plan.ordinates))),
          solver(media, settings.classes,
                 {directions, scene.dials.scatterError, 60, settings.simd, settings.checkpoint, flux}),
          last(scene, media, settings.classes, settings.plan.ordinates, {eye ? &scene.camera : nullptr, flux}, solver,
               settings.simd) {}

    FirstLight::Cells cells(const CellMedia& media) const {
        return {media, last.media(), last.classes(), !eye, border ? border->around.get() : nullptr};
    }
    // What enters in the next pass: of larger cells, or of the target's skies.
    PassInflow next(const ScatterTarget& target, int colour, bool skies) {
        if (border) return border->passes[nextPass++];
        PassInflow out;
        if (!skies) return out;
        out.ofSolve.even = inflowOf(scene, target, directions, colour);
        out.ofParts = last.divided(inflowOf(scene, target, last.ordinates(), colour));
        return out;
    }
    // The last sweep (LastSweep::pass), whose light also enters the domains inside. `glows`: emission is part of it.
    std::vector<std::vector<Real>> sweep(std::size_t colour, const PassInflow& enters, bool solved, bool glows,
                                         const LastSweep::Source& source) {
        std::vector<std::vector<Inflow>> into(inner.size());
        const auto send = [&](const Ordinates& along, const Inflow& inflow, const std::vector<Real>& sent) {
            for (std::size_t i = 0; i < inner.size(); ++i)
                into[i].push_back(inflowFrom({last.media(), inner[i]->around->last(), colour, solver.rowOfCell(),
                                              solver.valuesPerRow(), sent, glows, inflow},
                                             inner[i]->grid, along));
        };
        auto seen = last.pass(colour, enters, solved, source, inner.empty() ? LastSweep::Send() : send);
        for (std::size_t i = 0; i < inner.size(); ++i) {
            const std::ptrdiff_t parts = into[i].size() > 1 ? 1 : 0;
            inner[i]->passes.push_back({into[i].front(), {into[i].begin() + parts, into[i].end()}});
        }
        return seen;
    }

    const ViewScene& scene;
    const DomainBorder* border;
    const std::vector<DomainBorder*>& inner;
    bool eye, flux;
    Ordinates directions;
    TransportSolver solver;
    LastSweep last;
    std::size_t nextPass = 0;
    std::size_t beside = 0;  // the most bytes of the light beside the solver
};

void DomainLight::solve(const Settings& settings, const CellMedia& media, const DomainBorder* border,
                        const std::vector<DomainBorder*>& inner) {
    Passes passes(settings, media, border, inner);
    const std::vector<ScatterTarget>& targets = settings.plan.targets;
    for (std::size_t t = 0; t < targets.size(); ++t) {
        std::optional<FirstLight> first;
        const ScatterTarget* lastTarget = nullptr;
        const auto parts = partsOf(settings.scene, settings.plan, targets[t]);
        for (const auto& [target, colours] : parts) {
            const int colour = axisOfLargest(colours);
            const bool alike =
                lastTarget && lastTarget->lights == target.lights && lastTarget->emission == target.emission;
            if (!alike || !first->turnTo(colour, media, passes.last.media()))
                first.emplace(settings.scene, target, colour, passes.cells(media), passes.solver);
            solvePart(settings, media, passes, *first, t, target, colours);
            lastTarget = &target;
        }
        for (std::size_t f = t * m_classes; f < (t + 1) * m_classes; ++f)
            for (const auto& field : {m_fields[f], m_unscattered[f]})
                if (field) fillBorders(passes.solver, *field);
    }
    for (const auto& field : m_flux)
        if (field) fillBorders(passes.solver, *field);
    m_solved.cellDirections += passes.last.cellDirections();
    m_peak = media.bytes() + passes.solver.bytes() + passes.last.bytes() + passes.beside;
}

// A path of light runs from a light to the eye by way of volumes that scatter fully, which scatter it any number of
// times, and of volumes that scatter once: at most one of them scatters it, and only once. So there are two solves.
// The first is of paths that only volumes that scatter fully have scattered so far; all volumes show its light. The
// second begins with the light that volumes that scatter once send on, from lights and from the first solve; only
// volumes that scatter fully show it.
void DomainLight::solvePart(const Settings& settings, const CellMedia& media, Passes& passes, const FirstLight& first,
                            std::size_t t, const ScatterTarget& target, const Rgb& colours) {
    const auto& [scene, plan, classes, kept, simd, checkpoint] = settings;
    TransportSolver& solver = passes.solver;
    LastSweep& last = passes.last;
    const Ordinates& directions = passes.directions;
    const auto colour = std::size_t(axisOfLargest(colours));
    const bool someOnce = std::ranges::any_of(classes, &ScatterClass::once);
    const auto keepIn = [&](const std::vector<std::shared_ptr<CellField>>& fields, int which, const auto& own,
                            const auto& straight, double factor) {
        keep(last.classes(), solver, own, straight, which, factor * colours, &fields[t * m_classes]);
    };
    const std::vector<std::vector<Real>> none;
    const bool skies = !inflowOf(scene, target, directions, int(colour)).empty();
    first.addTo(directions, classes, media, simd, solver.clearedSource());
    const PassInflow enters = passes.next(target, int(colour), true);
    m_solved += solver.solve(colour, enters.ofSolve);
    const std::vector<Real> before = someOnce ? solver.radiance() : std::vector<Real>();
    const auto seen =
        passes.sweep(colour, enters, true, target.emission, [&](const Ordinates& along, std::vector<Real>& source) {
            first.addTo(along, last.classes(), last.media(), simd, source);
        });
    keepIn(m_fields, full | once, seen, first.straight(), 1);
    keepFlux(solver, seen, first.straight(), colours);
    passes.beside = std::max(passes.beside, (someOnce ? 2 : 1) * first.bytes() + before.size() * sizeof(Real));
    const bool apart = skies && m_classes > 0 && m_unscattered[t * m_classes];
    if (apart || (skies && someOnce)) {
        const auto unscattered = passes.sweep(colour, passes.next(target, int(colour), true), false, false, {});
        if (apart) keepIn(m_unscattered, full, unscattered, none, 1);
        if (apart) keepFlux(solver, unscattered, none, -colours);
        keepIn(m_fields, once, unscattered, none, -1);  // they see it as a medium that scatters once does
    }
    if (!someOnce) return;
    const FirstLight again = first.ofOnce();
    again.addTo(directions, classes, media, simd, solver.clearedSource());
    last.addScattered(true, colour, before, directions, solver.source());
    const PassInflow further = passes.next(target, int(colour), false);
    m_solved += solver.solve(colour, further.ofSolve);
    const auto second = passes.sweep(colour, further, true, false, [&](const Ordinates& along, auto& source) {
        again.addTo(along, last.classes(), last.media(), simd, source);
        last.addScattered(true, colour, before, along, source);
    });
    keepIn(m_fields, full, second, none, 1);
    keepFlux(solver, second, none, colours);
}

// Adds what is kept of a pass to a target's fields, for the cells inside of blocks. `which`: full, once or both.
void DomainLight::keep(const std::vector<ScatterClass>& classes, const TransportSolver& solver,
                       const std::vector<std::vector<Real>>& kept, const std::vector<std::vector<Real>>& straight,
                       int which, const Rgb& colours, const std::shared_ptr<CellField>* fields) const {
    for (std::size_t k = 0; k < classes.size(); ++k) {
        if ((which & (classes[k].once ? once : full)) == 0) continue;
        const bool beams = !straight.empty() && !classes[k].once;
        const std::size_t own = m_kept == KeptLight::towardsEye ? k : 0;
        parallelFor(solver.rows(), [&](std::size_t row) {
            // Series and differences may go below zero.
            const Real light = std::max(kept[k][row] + (beams ? straight[own][row] : Real(0)), Real(0));
            Real* to = fields[k]->cell(solver.cellOfRow()[row]);
            for (int c = 0; c < 3; ++c) to[c] = std::max(to[c] + static_cast<Real>(colours[c]) * light, Real(0));
        });
    }
}

// Adds the flux of a pass.
void DomainLight::keepFlux(const TransportSolver& solver, const std::vector<std::vector<Real>>& kept,
                           const std::vector<std::vector<Real>>& straight, const Rgb& colours) {
    for (std::size_t axis = 0; m_kept == KeptLight::meanAndFlux && axis < 3; ++axis)
        parallelFor(solver.rows(), [&](std::size_t row) {
            const Real flux = kept[m_classes + axis][row] + (straight.empty() ? Real(0) : straight[1 + axis][row]);
            Real* to = m_flux[axis]->cell(solver.cellOfRow()[row]);
            for (int c = 0; c < 3; ++c) to[c] += static_cast<Real>(colours[c]) * flux;
        });
}

namespace {

// The mean of the known cells around a place that it sees; false if there is none. known(place): their values, or null.
template <class Known>
bool meanAround(const CellGrid& grid, const Int3& place, bool walls, const Known& known, Real* mean) {
    int count = 0;
    Real sum[3] = {0, 0, 0};
    for (int i = 0; i < 27; ++i) {
        const Int3 beside = place + Int3(i % 3, i / 3 % 3, i / 9) - 1;
        const Real* near = known(beside);
        if (near && (!walls || grid.sees(grid.wsInside(place), grid.wsInside(beside)))) {
            ++count;
            for (int c = 0; c < 3; ++c) sum[c] += near[c];
        }
    }
    for (int c = 0; c < 3; ++c) mean[c] = count > 0 ? sum[c] / static_cast<Real>(count) : Real(0);
    return count > 0;
}

}  // namespace

// Cells without a row of their own get the mean of neighbours that are known, ring by ring, because kernels reach
// further than voxels; fillBorders adds the last ring. Returns for each cell whether it is known then; empty if
// there is but the last ring, so that rows tell.
std::vector<std::uint8_t> DomainLight::fillAround(const TransportSolver& solver, CellField& field) const {
    if (m_rings == 1) return {};
    std::vector<std::uint8_t> known(m_grid->cells());
    for (std::size_t cell = 0; cell < known.size(); ++cell) known[cell] = solver.rowOfCell()[cell] >= 0;
    for (int ring = 1; ring < m_rings; ++ring) {
        const std::vector<std::uint8_t> before = known;
        const auto at = [&](const Int3& place) -> const Real* {
            const std::ptrdiff_t cell = m_grid->index(place);
            return cell < 0 || before[std::size_t(cell)] == 0 ? nullptr : field.cell(std::size_t(cell));
        };
        parallelFor(m_grid->storedBlocks().size(), [&](std::size_t block) {
            const bool walls = m_grid->walled(block) >= 0;
            for (std::size_t cell = block * kBlockCells; cell < (block + 1) * kBlockCells; ++cell)
                if (before[cell] == 0)
                    known[cell] = meanAround(*m_grid, m_grid->place(cell), walls, at, field.cell(cell));
        });
    }
    return known;
}

// Fills the cells around each block from its neighbours, and those around known ones.
void DomainLight::fillBorders(const TransportSolver& solver, CellField& field) const {
    const std::vector<std::uint8_t> all = fillAround(solver, field);
    const auto known = [&](const Int3& place) -> const Real* {
        const std::ptrdiff_t cell = m_grid->index(place);
        if (cell < 0) return nullptr;
        const auto at = static_cast<std::size_t>(cell);
        return (all.empty() ? solver.rowOfCell()[at] >= 0 : all[at] != 0) ? field.cell(at) : nullptr;
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
                    meanAround(*m_grid, place, walls, known, to);
                }
    });
}

// The mean is extrapolated, and the flux is not; a series may be a little longer than the mean, too.
void DomainLight::limitFlux() {
    if (m_kept != KeptLight::meanAndFlux) return;
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

// The error of cells falls with their edge: to a half if light and density vary together within a cell, to a quarter if
// fields are smooth. Measured against path tracers on fractal and on smooth smoke: subtracting a half of the additional
// error of cells twice as large leaves less than half of the error in both cases (L. F. Richardson, 1911). The rate
// cannot be measured with even larger cells, which do not resolve the fields and always suggest first order. Surfaces
// are of first order: in a brain with cells of 1.2 voxels, 2.7 % were left with a half, and 1.3 % with all. Walls that
// send light back stand elsewhere on larger cells, which says nothing about the cells' error: in a room 20 cells wide
// it grew from 3.4 to 4.5 %, in one of 40 cells from 0.1 to 2
// %. There is no extrapolation then.
void DomainLight::improveBy(const DomainLight& twice, bool surfaces) {
    const auto part = Real(surfaces ? 1 : 0.5);
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
}

void DomainLight::separate() {
    for (std::size_t f = 0; f < m_unscattered.size(); ++f)
        for (std::size_t block = 0; m_unscattered[f] && block < m_grid->storedBlocks().size(); ++block) {
            Real *all = m_fields[f]->block(block), *unscattered = m_unscattered[f]->block(block);
            for (std::size_t i = 0; i < kPaddedCells * m_fields[f]->colours(); ++i) {
                unscattered[i] = std::min(unscattered[i], all[i]);
                all[i] -= unscattered[i];
            }
        }
}

}  // namespace scrim
