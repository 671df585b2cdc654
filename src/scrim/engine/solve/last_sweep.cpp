// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/solve/last_sweep.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/solve/cell_sweep.h>

#include <algorithm>

namespace scrim {
CellMedia splitAgain(const CellMedia& media, const std::vector<ScatterClass>& from,
                     const std::vector<ScatterClass>& to) {
    CellMedia out = media;
    for (std::size_t c = 0; c < out.straight.size(); ++c)
        for (std::size_t cell = 0; cell < out.grid.cells(); ++cell) out.extinction[c][cell] += out.straight[c][cell];
    for (std::size_t k = 0; k < from.size(); ++k)
        for (std::vector<Real>& row : out.scattering[k])
            for (Real& value : row) value /= static_cast<Real>(1 - from[k].straight());
    out.straight.clear();
    goStraight(out, to);
    return out;
}

int solvedOrdinates(int ordinates) {
    return std::max(kOrdinateCounts[0], ordinates / 2);
}

LastSweep::LastSweep(const ViewScene& scene, const CellMedia& media, const std::vector<ScatterClass>& classes,
                     int count, const Keeps& keeps, TransportSolver& solver, Simd simd)
    : m_solved(media),
      m_eye(keeps.eye),
      m_flux(keeps.flux),
      m_solver(solver),
      m_simd(simd),
      m_ordinates(scrim::ordinates(count)),
      m_ofSolve(scrim::ordinates(solvedOrdinates(count))),
      m_parts(scrim::divided(m_ordinates, count / m_ofSolve.count())),
      m_classes(m_parts.size() == 1 ? classes : scatterClasses(scene, count)) {
    m_borders.resize(m_parts.size());
    if (!std::ranges::equal(classes, m_classes, {}, &ScatterClass::straight, &ScatterClass::straight))
        m_split = splitAgain(media, classes, m_classes);
}

void LastSweep::addScattered(bool once, std::size_t colour, const std::vector<Real>& radiance, const Ordinates& along,
                             std::vector<Real>& source) const {
    const std::size_t values = m_solver.valuesPerRow();
    for (std::size_t k = 0; k < m_classes.size(); ++k) {
        if (m_classes[k].once != once) continue;
        std::vector<std::vector<Real>> matrix;
        if (!m_solver.isotropic()) {
            std::vector<double> moments = once ? m_classes[k].split.whole() : m_classes[k].split.spread();
            moments.resize(std::size_t(resolvedMoments(m_ofSolve.count())));
            matrix.push_back(scatteringMatrix(m_ofSolve, along, moments));
        }
        const std::vector<Real>& scattering = media().scatteringOf(k, colour);
        parallelChunks(m_solver.rows(), [&](std::size_t begin, std::size_t end) {
            constexpr std::size_t kAtOnce = 4 * kRowsTogether;
            std::vector<Real> rows(kAtOnce * values);
            for (std::size_t first = begin; first < end; first += kAtOnce) {
                const std::size_t count = std::min(kAtOnce, end - first);
                std::copy_n(&radiance[first * values], count * values, rows.data());
                if (!matrix.empty()) mixOrdinates(matrix, {}, 0, count, values, rows.data(), m_simd);
                for (std::size_t r = 0; r < count; ++r) {
                    const Real factor = scattering[m_solver.cellOfRow()[first + r]];
                    const Real* row = rows.data() + r * values;
                    Real* to = source.data() + (first + r) * values;
                    for (std::size_t m = 0; factor > 0 && m < values; ++m) to[m] += factor * row[m];
                }
            }
        });
    }
    // Walls send on what arrives at them.
    const CellGrid& grid = m_solved.grid;
    for (std::size_t side = 0; !once && side < grid.sides(); ++side)
        source[m_solver.rows() * values + side] +=
            static_cast<Real>(grid.albedoOfSide(side)[int(colour)]) * radiance[m_solver.rows() * values + side];
}

// Turns a source into the radiance along the ordinates of a part.
void LastSweep::sweep(std::size_t part, std::size_t colour, const Inflow* inflow, std::vector<Real>& rows) {
    // Series may go below zero, and light does not.
    parallelChunks(rows.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) rows[i] = std::max(rows[i], Real(0));
    });
    const CellGrid& grid = m_solved.grid;
    if (inflow && m_borders[part].empty()) m_borders[part] = openBorder(grid, m_parts[part]);
    CellSweep cells{&grid, &m_parts[part], media().extinctionOf(colour).data(), inflow, true, m_simd};
    cells.border = &m_borders[part];
    m_cellDirections += grid.cells() * std::size_t(m_parts[part].count());
    std::vector<Real> caught;
    const std::vector<Real> back(rows.begin() + std::ptrdiff_t(m_solver.rows() * m_solver.valuesPerRow()), rows.end());
    if (!back.empty()) cells.back = back.data(), cells.caught = &caught;
    if (!m_solver.isotropic()) return sweepDirectional(cells, m_solver.rowOfCell(), rows);
    sweepIsotropic(cells, rows, m_mean, m_scratch);
    std::copy(m_mean.begin(), m_mean.end(), rows.begin());
}

// Adds what is kept of a part's rows. `lobes`: for each class, two values for each row: what the
// eye sees of light that continues straight on, and the sum by which it is to be divided.
void LastSweep::keep(const Ordinates& along, const std::vector<Real>& rows, std::vector<std::vector<Real>>& kept,
                     std::vector<std::vector<Real>>& lobes) const {
    const std::size_t values = m_solver.valuesPerRow();
    const std::vector<Real> ones(values, Real(1));
    std::vector<std::vector<Real>> fixed(kept.size(), std::vector<Real>(values));  // rows that serve all cells
    for (std::size_t i = 0; !m_eye && !m_solver.isotropic() && i < kept.size(); ++i) {
        // Cosines are the series of the second moment alone.
        Vec3 axis(0);
        axis[i < m_classes.size() ? 0 : int(i - m_classes.size())] = 1;
        const std::vector<double> moments = i < m_classes.size() ? std::vector{1.0} : std::vector{0, 1.0 / 3};
        scatteringRow(along, moments, axis, fixed[i].data(), m_simd);
    }
    parallelChunks(m_solver.rows(), [&](std::size_t begin, std::size_t end) {
        std::vector<Real> row(values);
        for (std::size_t at = begin; at < end; ++at) {
            const Real* radiance = &rows[at * values];
            const Vec3 travel = m_eye ? travelToEye(*m_eye, m_solved.grid.wsCenter(m_solver.cellOfRow()[at])) : Vec3(0);
            for (std::size_t i = 0; i < kept.size(); ++i) {
                if (m_solver.isotropic() || !m_eye) {
                    kept[i][at] +=
                        m_solver.isotropic() ? *radiance : gathered(along, fixed[i].data(), radiance, m_simd);
                    continue;
                }
                const SplitPhase& phase = m_classes[i].split;
                scatteringRow(along, phase.spread(), travel, row.data(), m_simd, 1 - phase.straight());
                kept[i][at] += gathered(along, row.data(), radiance, m_simd);
                if (lobes[i].empty()) continue;
                lobeRow(along, phase.spread().size(), travel, row.data(), m_simd);
                lobes[i][2 * at] += gathered(along, row.data(), radiance, m_simd);
                lobes[i][2 * at + 1] += gathered(along, row.data(), ones.data(), m_simd);
            }
        }
    });
}

std::vector<Inflow> LastSweep::divided(const std::vector<Real>& inflow) const {
    std::vector<Inflow> parts(inflow.empty() ? 0 : m_parts.size());
    for (std::size_t part = 0; part < parts.size(); ++part)
        for (std::size_t m = part; m < inflow.size(); m += m_parts.size()) parts[part].even.push_back(inflow[m]);
    return parts;
}

std::vector<std::vector<Real>> LastSweep::pass(std::size_t colour, const PassInflow& inflow, bool solved,
                                               const Source& addSource, const Send& send) {
    std::vector<std::vector<Real>> kept(m_classes.size() + (m_flux ? 3 : 0), std::vector<Real>(m_solver.rows(), 0));
    std::vector<std::vector<Real>> lobes(m_classes.size());
    for (std::size_t k = 0; k < m_classes.size(); ++k)
        if (m_eye && m_classes[k].split.straight() > 0) lobes[k].assign(2 * m_solver.rows(), 0);
    std::size_t values = 0;
    for (const auto* rows : {&kept, &lobes})
        for (const std::vector<Real>& row : *rows) values += row.size();
    m_kept = std::max(m_kept, values * sizeof(Real));
    const auto fill = [&](const Ordinates& along) -> std::vector<Real>& {
        std::vector<Real>& rows = m_solver.clearedSource();
        if (addSource) addSource(along, rows);
        if (solved) addScattered(false, colour, m_solver.radiance(), along, rows);
        return rows;
    };
    if (send && m_parts.size() > 1) send(m_ofSolve, inflow.ofSolve, fill(m_ofSolve));
    // Without further ordinates the solve's own last sweep is this one.
    const bool swept = solved && m_parts.size() == 1;
    if (swept) keep(m_ordinates, m_solver.radiance(), kept, lobes);
    for (std::size_t part = 0; (!swept || send) && part < m_parts.size(); ++part) {
        const Inflow* enters = part < inflow.ofParts.size() ? &inflow.ofParts[part] : nullptr;
        std::vector<Real>& rows = fill(m_parts[part]);
        if (send) send(m_parts[part], enters ? *enters : Inflow(), rows);
        if (swept) continue;
        sweep(part, colour, enters, rows);
        keep(m_parts[part], rows, kept, lobes);
    }
    for (std::size_t k = 0; k < lobes.size(); ++k)
        for (std::size_t row = 0; 2 * row < lobes[k].size(); ++row)
            kept[k][row] +=
                static_cast<Real>(m_classes[k].split.straight()) * lobes[k][2 * row] / lobes[k][2 * row + 1];
    return kept;
}

}  // namespace scrim
