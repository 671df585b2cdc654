// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/solve/solver.h>

#include <scrim/base/anderson.h>
#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <glm/common.hpp>

namespace scrim {
namespace {

constexpr std::size_t kMostLevels = 6;
// Coarser cells reduce a residual to this part. More precision is pointless, since they only approximate finer ones.
constexpr double kCoarseTolerance = 0.2;
// Sweeps of coarser cells for each sweep of finer ones (few, since every level calls the next), and of the coarsest.
constexpr int kCoarseSweeps = 3, kCoarsestSweeps = 40;
// Consecutive sweeps that reduce the residual to no less than kIdle of what it was; then further ones are useless.
constexpr int kIdleSweeps = 6;
constexpr double kIdle = 0.95;
constexpr double kFall = 0.3;  // initial estimate of the residual's ratio from sweep to sweep of the finest cells

}  // namespace

// The cells of one size, with what a solve keeps for them.
struct TransportSolver::Level {
    CellMedia media;  // on all levels but the first, whose media are the caller's
    const CellMedia* own = nullptr;
    std::vector<std::int32_t> rows;  // for each cell
    std::vector<std::size_t> cellOf;
    std::size_t rowCount = 0;
    std::vector<Real> extinction, scattering;  // of the current colour: one value per cell, one per row
    // Share of each class in `scattering`, one value per row; empty: one class.
    std::vector<std::vector<Real>> shares;
    // The albedo of each side of walls that send light back, in units of `scattering`: a face of a
    // cell emits a quarter of what the cell would.
    std::vector<Real> sides;
    std::vector<Real> x, next, source;  // the rows' values, then one for each side

    const CellMedia& cells() const { return own ? *own : media; }
};

std::vector<std::uint8_t> openBorder(const CellGrid& grid, const Ordinates& ordinates) {
    const Int3 size = grid.blocks() * kCellEdge;
    const auto count = std::size_t(ordinates.count());
    std::vector<std::uint8_t> open;
    if (!grid.hasWalls()) return open;
    constexpr double kFar = 1e9;  // edges
    for (int axis = 0; axis < 3; ++axis) {
        const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
        const std::size_t first = open.size(), faces = std::size_t(size[u]) * std::size_t(size[v]);
        open.resize(first + faces * count);
        parallelFor(faces, [&](std::size_t i) {
            Int3 cell(0);
            cell[u] = static_cast<int>(i) % size[u];
            cell[v] = static_cast<int>(i) / size[u];
            for (std::size_t m = 0; m < count; ++m) {
                cell[axis] = ordinates.directions[m][axis] < 0 ? size[axis] - 1 : 0;
                const Vec3 ws = grid.wsInside(cell);
                open[first + i * count + m] = grid.sees(ws, ws - kFar * grid.edge() * ordinates.directions[m]) ? 1 : 0;
            }
        });
    }
    return open;
}

TransportSolver::TransportSolver(const CellMedia& media, const std::vector<ScatterClass>& classes, Settings settings)
    : m_classes(classes), m_settings(std::move(settings)) {
    m_full = std::size_t(std::count_if(classes.begin(), classes.end(), [](const ScatterClass& c) { return !c.once; }));
    m_isotropic =
        !m_settings.directional && std::ranges::all_of(classes, [](const auto& c) { return c.phase.isotropic(); });
    if (!m_isotropic)
        for (std::size_t k = 0; k < m_full; ++k)
            m_matrices.push_back(
                scatteringMatrix(m_settings.ordinates, m_settings.ordinates, classes[k].split.spread()));
    m_ones.assign(valuesPerRow(), Real(1));
    m_sphere = m_isotropic ? 1 : 4 * std::numbers::pi;
    m_levels.emplace_back().own = &media;
    while (!media.grid.hasWalls() && m_levels.size() < kMostLevels &&
           m_levels.back().cells().grid.cells() > kFewestCells) {
        CellMedia next = coarser(m_levels.back().cells());
        // Few blocks may be as many in cells twice as large, which then cost as much.
        if (2 * next.grid.cells() > m_levels.back().cells().grid.cells()) break;
        m_levels.emplace_back().media = std::move(next);
    }
    for (Level& level : m_levels) numberRows(level);
}

TransportSolver::~TransportSolver() = default;

const std::vector<std::int32_t>& TransportSolver::rowOfCell() const {
    return m_levels.front().rows;
}
const std::vector<std::size_t>& TransportSolver::cellOfRow() const {
    return m_levels.front().cellOf;
}
const std::vector<Real>& TransportSolver::radiance() const {
    return m_levels.front().next;
}

// Numbers the rows. If one number represents all directions, every cell has a row. Otherwise only
// cells that send light have one: rows of the cells around them, between which and them light is
// interpolated, were 31 % of all rows, and changed pictures by 0.02 to 0.05 %.
void TransportSolver::numberRows(Level& level) const {
    const CellGrid& grid = level.cells().grid;
    level.rows.assign(grid.cells(), m_isotropic ? 0 : -1);
    for (std::size_t cell = 0; !m_isotropic && cell < grid.cells(); ++cell)
        if (level.cells().sends(cell)) level.rows[cell] = 0;
    for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
        if (level.rows[cell] < 0) continue;
        level.rows[cell] = static_cast<std::int32_t>(level.rowCount++);
        level.cellOf.push_back(cell);
    }
    const std::size_t values = level.rowCount * valuesPerRow() + grid.sides();
    for (std::vector<Real>* row : {&level.x, &level.next, &level.source}) row->assign(values, Real(0));
    level.scattering.resize(level.rowCount);
}

void TransportSolver::chooseColour(Level& level, std::size_t colour) const {
    const CellMedia& media = level.cells();
    level.extinction = media.extinctionOf(colour);
    level.sides.clear();
    for (std::size_t side = 0; side < media.grid.sides(); ++side)
        level.sides.push_back(static_cast<Real>(media.grid.albedoOfSide(side)[int(colour)] / (4 * media.grid.edge())));
    level.shares.assign(m_full > 1 ? m_full : 0, std::vector<Real>(level.rowCount));
    for (std::size_t row = 0; row < level.rowCount; ++row) {
        const std::size_t cell = level.cellOf[row];
        Real sum = 0;
        for (std::size_t k = 0; k < m_full; ++k) sum += media.scatteringOf(k, colour)[cell];
        level.scattering[row] = sum;
        for (std::size_t k = 0; k < level.shares.size(); ++k)
            level.shares[k][row] =
                sum > 0 ? media.scatteringOf(k, colour)[cell] / sum : Real(1) / static_cast<Real>(m_full);
    }
}

std::vector<Real>& TransportSolver::source() {
    return m_levels.front().source;
}
std::vector<Real>& TransportSolver::clearedSource() {
    std::fill(source().begin(), source().end(), Real(0));
    return source();
}

// next = G(x): sweeps what cells emit, and scatters the result. The last time it is not scattered,
// and negative values are removed.
void TransportSolver::sweep(Level& level, const Inflow* inflow, bool last) {
    if (m_settings.checkpoint) m_settings.checkpoint();
    const std::size_t values = valuesPerRow();
    parallelChunks(level.rowCount, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row)
            for (std::size_t i = row * values; i < (row + 1) * values; ++i) {
                const Real sent = level.scattering[row] * level.x[i] + level.source[i];
                level.next[i] = last ? std::max(sent, Real(0)) : sent;
            }
    });
    CellSweep cells{&level.cells().grid, &m_settings.ordinates, level.extinction.data(), inflow, last, m_settings.simd};
    cells.border = &m_border;
    const std::size_t first = level.rowCount * values;
    const auto perAlbedo = static_cast<Real>(4 * level.cells().grid.edge());
    m_back.assign(level.source.begin() + std::ptrdiff_t(first), level.source.end());
    for (std::size_t i = 0; i < m_back.size(); ++i) m_back[i] += perAlbedo * level.sides[i] * level.x[first + i];
    if (!m_back.empty()) cells.back = m_back.data(), cells.caught = &m_caught;
    if (m_isotropic) {
        sweepIsotropic(cells, level.next, m_mean, m_scratch);
        level.next.swap(m_mean);
    } else {
        sweepDirectional(cells, level.rows, level.next);
        if (!last) scatter(level);
    }
    level.next.resize(first);
    if (!m_back.empty()) level.next.insert(level.next.end(), m_caught.begin(), m_caught.end());
    m_solved.cellDirections += level.cells().grid.cells() * std::size_t(m_settings.ordinates.count());
    if (&level == &m_levels.front()) ++m_solved.sweeps;
}

// Converts the radiance along each ordinate to what a unit of scattering coefficient emits along each.
void TransportSolver::scatter(Level& level) const {
    parallelChunks(level.rowCount, [&](std::size_t begin, std::size_t end) {
        mixOrdinates(m_matrices, level.shares, begin, end, valuesPerRow(), level.next.data(), m_settings.simd);
    });
}

// The sum over directions of the product of two rows.
double TransportSolver::dot(const Real* a, const Real* b) const {
    return double(m_isotropic ? *a * *b : gathered(m_settings.ordinates, a, b, m_settings.simd));
}

// The inner product of two vectors like x, weighted by what cells and sides scatter.
double TransportSolver::product(const Level& level, const std::vector<Real>& a, const std::vector<Real>& b) const {
    const std::size_t each = valuesPerRow();
    double all = parallelSum(level.rowCount, [&](std::size_t row) {
        return dot(&a[row * each], &b[row * each]) * double(level.scattering[row]);
    });
    for (std::size_t i = 0, at = level.rowCount * each; i < level.sides.size(); ++i, ++at)
        all += m_sphere * double(a[at]) * double(b[at]) * double(level.sides[i]);
    return all;
}

// The light that `values` are, or their difference to `minus`: a sum over cells, each of which has no sign.
double TransportSolver::lightOf(const Level& level, const std::vector<Real>& values,
                                const std::vector<Real>* minus) const {
    const std::size_t each = valuesPerRow();
    double all = parallelSum(level.rowCount, [&](std::size_t row) {
        const double light = dot(m_ones.data(), &values[row * each]);
        return std::abs(minus ? light - dot(m_ones.data(), &(*minus)[row * each]) : light) *
               double(level.scattering[row]);
    });
    for (std::size_t i = 0, at = level.rowCount * each; i < level.sides.size(); ++i, ++at)
        all +=
            m_sphere * double(level.sides[i]) * std::abs(double(values[at]) - double(minus ? (*minus)[at] : Real(0)));
    return all;
}

// Light relative to what the last sweep scattered.
double TransportSolver::relative(const Level& level, double light) const {
    const double all = lightOf(level, level.next);
    return all > 0 ? light / all : 0;
}

// Sets the source of the coarser cells: that of the finer ones, or the residual of a sweep of these.
void TransportSolver::restrict(const Level& fine, Level& coarse, bool residual) const {
    const std::size_t values = valuesPerRow();
    const CellGrid &grid = fine.cells().grid, &to = coarse.cells().grid;
    std::fill(coarse.source.begin(), coarse.source.end(), Real(0));
    // A block of the coarser grid contains whole blocks of the finer one, and no other task writes to it.
    const Int3 shift(glm::round(to.csFromWs(grid.wsFromCs(Vec3(0)))));
    std::vector<std::vector<std::size_t>> inside(to.storedBlocks().size());
    for (std::size_t b = 0; b < grid.storedBlocks().size(); ++b)
        inside[std::size_t(to.index(shift + grid.storedBlocks()[b] * (kCellEdge / 2))) / kBlockCells].push_back(b);
    parallelFor(inside.size(), [&](std::size_t task) {
        for (const std::size_t block : inside[task])
            for (std::size_t cell = block * kBlockCells; cell < (block + 1) * kBlockCells; ++cell) {
                const std::int32_t row = fine.rows[cell];
                if (row < 0) continue;
                const Int3 place = grid.place(cell);
                const std::ptrdiff_t at = to.index(shift + Int3(place.x >> 1, place.y >> 1, place.z >> 1));
                const std::int32_t into = coarse.rows[std::size_t(at)];
                if (into < 0) continue;
                const std::size_t from = std::size_t(row) * values;
                const Real *source = &fine.source[from], *next = &fine.next[from], *x = &fine.x[from];
                Real* sum = coarse.source.data() + std::size_t(into) * values;
                const Real part = residual ? fine.scattering[std::size_t(row)] / 8 : Real(1) / 8;
                if (part == 0) continue;
                for (std::size_t m = 0; m < values; ++m) sum[m] += part * (residual ? next[m] - x[m] : source[m]);
            }
    });
}

// fine.x = (add ? fine.next : 0) + the values of the coarser cells there.
void TransportSolver::prolong(const Level& coarse, Level& fine, bool add) const {
    if (add)
        fine.x = fine.next;
    else
        std::fill(fine.x.begin(), fine.x.end(), Real(0));
    addInterpolated(coarse.cells().grid, coarse.rows, coarse.x, fine.cells().grid, fine.rows, valuesPerRow(), fine.x);
}

// Finds an initial x with the coarser cells.
void TransportSolver::start(std::size_t level, const Inflow* inflow) {
    Level& here = m_levels[level];
    if (level + 1 == m_levels.size()) return std::fill(here.x.begin(), here.x.end(), Real(0));
    Level& coarse = m_levels[level + 1];
    restrict(here, coarse, false);
    start(level + 1, inflow);
    reduce(level + 1, inflow, 2 * kCoarseSweeps);
    prolong(coarse, here, false);
}

// Improves x after a sweep whose r = G(x) - x is `residual` of light; returns by how much light, relative to that.
double TransportSolver::improve(std::size_t level, double residual, AndersonMixing& anderson) {
    Level& here = m_levels[level];
    const auto mix = [&](std::size_t beside) {
        const double length = anderson.step(here.x, here.next);
        m_mixed = std::max(m_mixed, anderson.bytes() + beside);
        return length;
    };
    if (level + 1 == m_levels.size()) return mix(0);
    // The error of x is r + K r + ..., K being a sweep without sources: r itself, and its
    // scattering, which coarser cells compute.
    Level& coarse = m_levels[level + 1];
    restrict(here, coarse, true);
    std::fill(coarse.x.begin(), coarse.x.end(), Real(0));
    reduce(level + 1, nullptr, kCoarseSweeps);
    constexpr double kVolume = 8;  // of a coarser cell
    const double gain = level == 0 ? 1 + kVolume * lightOf(coarse, coarse.x) / residual : 1;
    // In cells in which light scatters many times, sweeps smooth little, and corrections are too small or too large.
    // Mixing them takes half the sweeps; with a value for each ordinate it would double the memory.
    if (level > 0 || !m_isotropic) {
        prolong(coarse, here, true);
        return gain;
    }
    std::vector<Real> before = here.x;
    prolong(coarse, here, true);
    here.next.swap(here.x);
    here.x.swap(before);
    mix(before.size() * sizeof(Real));
    return gain;
}

AndersonMixing TransportSolver::mixing(std::size_t level) const {
    const Level& here = m_levels[level];
    const std::size_t history = here.cells().grid.hasWalls() && !m_isotropic ? kShortHistory : kHistory;
    return {history, [this, &here](const auto& a, const auto& b) { return product(here, a, b); }};
}

// Reduces the residual of coarser cells to a part of what it is at first. (Its ratio to x says
// little: x may grow long.)
void TransportSolver::reduce(std::size_t level, const Inflow* inflow, int mostSweeps) {
    Level& here = m_levels[level];
    AndersonMixing anderson = mixing(level);
    if (level + 1 == m_levels.size()) mostSweeps = std::max(mostSweeps, kCoarsestSweeps);
    double first = 0, least = HUGE_VAL;
    for (int i = 0, idle = 0; i < mostSweeps && idle < kIdleSweeps; ++i) {
        sweep(here, inflow, false);
        const double residual = lightOf(here, here.next, &here.x);
        if (i == 0) first = residual;
        if (residual <= kCoarseTolerance * first) return here.x.swap(here.next);
        idle = residual < kIdle * least ? 0 : idle + 1;
        least = std::min(least, residual);
        improve(level, residual, anderson);
    }
}

// Iterates on the finest cells until the error of x is estimated to be at most the tolerance;
// returns that estimate. `ahead`: if given, iteration ends when the next sweep is expected to show
// that, and it becomes false if iteration ended for another reason.
double TransportSolver::iterate(const Inflow* inflow, bool* ahead) {
    Level& here = m_levels.front();
    AndersonMixing anderson = mixing(0);
    double error = 0, before = 0, least = HUGE_VAL;
    for (int i = 0, idle = 0; i < m_settings.mostSweeps && idle < kIdleSweeps; ++i) {
        sweep(here, inflow, false);
        const double changed = lightOf(here, here.next, &here.x), residual = relative(here, changed);
        const double fall = i > 0 ? residual / before : kFall;
        // Steps without coarser cells are small if the residual falls slowly.
        if (m_levels.size() == 1 && i > 0 && fall < 1) m_gain = std::max(m_gain, 1 / (1 - fall));
        error = m_gain * residual;
        if (residual == 0 || (i > 0 && error <= m_settings.tolerance)) {
            here.x = here.next;
            break;
        }
        idle = residual < kIdle * least ? 0 : idle + 1;
        least = std::min(least, before = residual);
        m_gain = std::max(m_gain, improve(0, changed, anderson));
        // The residual's ratio from one sweep to the next is about constant.
        if (ahead && (i > 0 || m_levels.size() > 1) && 2 * m_gain * residual * fall <= m_settings.tolerance)
            return error;
    }
    if (ahead) *ahead = false;
    return error;
}

Solved TransportSolver::solve(std::size_t colour, const Inflow& inflow) {
    m_solved = {};
    m_gain = 1;
    for (Level& level : m_levels) chooseColour(level, colour);
    const Inflow* from = inflow.any() ? &inflow : nullptr;
    if (from && m_border.empty()) m_border = openBorder(m_levels.front().cells().grid, m_settings.ordinates);
    start(0, from);
    // The sweep whose result is visible also shows what remained to be done, unless much of it is below zero.
    Level& finest = m_levels.front();
    bool ahead = true;
    m_solved.error = iterate(from, &ahead);
    sweep(finest, from, true);
    if (ahead) m_solved.error = m_gain * relative(finest, lightOf(finest, finest.next, &finest.x));
    if (ahead && m_solved.error > m_settings.tolerance) {
        m_solved.error = iterate(from, nullptr);
        sweep(finest, from, true);
    }
    m_solved.converged = m_solved.error <= m_settings.tolerance;
    return m_solved;
}

std::size_t TransportSolver::bytes() const {
    std::size_t bytes = (m_mean.capacity() + m_scratch.capacity()) * sizeof(Real) + m_mixed;
    for (const Level& level : m_levels) {
        bytes += (level.x.size() + level.next.size() + level.source.size() + level.extinction.size() +
                  level.scattering.size() * (1 + level.shares.size())) *
                     sizeof(Real) +
                 level.rows.size() * sizeof(std::int32_t) + level.cellOf.size() * sizeof(std::size_t);
        if (!level.own) bytes += level.media.bytes();
    }
    return bytes;
}

}  // namespace scrim
