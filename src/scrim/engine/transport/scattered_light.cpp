// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/scattered_light.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/transport/light_sources.h>
#include <scrim/engine/transport/mix_ordinates.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr std::size_t kFour = 4;  // values per cell, the last of which is unused

// The colour of the target's light, if all of it has the same colour.
Rgb colourOf(const ViewScene& scene, const ScatterTarget& target) {
    for (const int light : target.lights) return scene.lights[std::size_t(light)].intensity;
    if (target.ambient) return scene.ambient;
    for (const ViewVolume& volume : scene.volumes)
        for (const ViewEmission& emission : volume.emission)
            if (emission.color != Rgb(0)) return emission.color;
    return Rgb(1);
}

}  // namespace

ScatteredLight::ScatteredLight(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                               const std::function<void()>& checkpoint)
    : m_targets(plan.targets) {
    const std::vector<ScatterClass> classes = scatterClasses(scene, plan.ordinates);
    m_classes = classes.size();
    m_classOf.assign(scene.volumes.size(), -1);
    for (std::size_t k = 0; k < classes.size(); ++k)
        for (const int volume : classes[k].volumes) m_classOf[std::size_t(volume)] = static_cast<int>(k);
    const CellMedia media = cellMedia(scene, classes, plan.edge);
    m_grid = media.grid;
    m_fields.assign(m_targets.size() * m_classes, Field(m_grid.storedBlocks().size() * kPaddedCells * kFour, Real(0)));
    if (m_grid.cells() > 0) solve(scene, media, classes, plan, simd, checkpoint);
    for (const Field& field : m_fields) m_bytes += field.size() * sizeof(Real);
    m_bytes += media.bytes();
    if (m_grid.cells() > 0 && !plan.coarse) extrapolate(scene, plan, simd, checkpoint);
}

void ScatteredLight::solve(const ViewScene& scene, const CellMedia& media, const std::vector<ScatterClass>& classes,
                           const TransportPlan& plan, Simd simd, const std::function<void()>& checkpoint) {
    const Ordinates directions = ordinates(plan.ordinates);
    TransportSolver solver(media, classes, {directions, scene.dials.scatterError, 60, true, simd, checkpoint});
    m_bytes += solver.bytes();
    for (std::size_t t = 0; t < m_targets.size(); ++t) {
        const Rgb shared = colourOf(scene, m_targets[t]);
        const int brightest = shared.x >= shared.y && shared.x >= shared.z ? 0 : shared.y >= shared.z ? 1 : 2;
        for (int c = 0; c < plan.colours; ++c) {
            const int colour = plan.colours == 1 ? brightest : c;
            const StraightLight straight =
                fillSource(scene, media, classes, m_targets[t], colour, directions, simd, solver);
            m_solved += solver.solve(std::size_t(colour), inflowOf(scene, m_targets[t], directions, colour));
            Rgb colours(0);
            colours[colour] = 1;
            if (plan.colours == 1) colours = shared / shared[brightest];
            for (std::size_t k = 0; k < m_classes; ++k)
                keep(scene, solver, classes[k].phase, straight.empty() ? nullptr : straight[k].data(), directions, simd,
                     colours, m_fields[t * m_classes + k]);
        }
        for (std::size_t k = 0; k < m_classes; ++k) fillBorders(solver, m_fields[t * m_classes + k]);
    }
}

// The index of a block's cell among the cells of all blocks with borders.
std::size_t ScatteredLight::paddedOf(std::size_t cell) {
    const std::size_t i = cell % kBlockCells, block = cell / kBlockCells;
    const std::size_t x = i % kCellEdge + 1, y = i / kCellEdge % kCellEdge + 1, z = i / (kCellEdge * kCellEdge) + 1;
    return block * kPaddedCells + (z * kPadded + y) * kPadded + x;
}

// Adds what the eye sees of a solve to a field, for the cells inside of blocks.
void ScatteredLight::keep(const ViewScene& scene, const TransportSolver& solver, const Phase& phase,
                          const Real* straight, const Ordinates& directions, Simd simd, const Rgb& colours,
                          Field& field) const {
    const std::size_t values = solver.valuesPerRow();
    parallelFor(m_grid.storedBlocks().size(), [&](std::size_t block) {
        std::vector<Real> row(values);
        for (std::size_t i = 0; i < kBlockCells; ++i) {
            const std::size_t cell = block * kBlockCells + i;
            const std::int32_t at = solver.rowOf(cell);
            if (at < 0) continue;
            const Real* radiance = solver.radiance().data() + std::size_t(at) * values;
            double seen = double(*radiance);
            if (!solver.isotropic()) {
                scatteringRow(directions, phase, travelToEye(scene.camera, m_grid.wsCenter(cell)), row.data(), simd);
                seen = double(gathered(directions, row.data(), radiance, simd));
            }
            if (straight) seen = std::max(seen + double(straight[at]), 0.0);
            Real* to = field.data() + paddedOf(cell) * kFour;
            for (int c = 0; c < 3; ++c) to[c] += static_cast<Real>(colours[c] * seen);
        }
    });
}

// Fills the cells around each block from its neighbours. Cells without a row of their own get the mean of neighbours
// that have one, because kernels reach a little further than voxels.
void ScatteredLight::fillBorders(const TransportSolver& solver, Field& field) const {
    const auto known = [&](const Int3& place) -> const Real* {
        const std::ptrdiff_t cell = m_grid.index(place);
        if (cell < 0 || solver.rowOf(std::size_t(cell)) < 0) return nullptr;
        return field.data() + paddedOf(std::size_t(cell)) * kFour;
    };
    parallelFor(m_grid.storedBlocks().size(), [&](std::size_t block) {
        const Int3 first = m_grid.storedBlocks()[block] * kCellEdge - 1;
        Real* to = field.data() + block * kPaddedCells * kFour;
        for (int z = 0; z < kPadded; ++z)
            for (int y = 0; y < kPadded; ++y)
                for (int x = 0; x < kPadded; ++x, to += kFour) {
                    const Int3 place = first + Int3(x, y, z);
                    if (const Real* own = known(place)) {
                        if (own != to) std::copy_n(own, kFour, to);
                        continue;
                    }
                    int count = 0;
                    Real sum[3] = {0, 0, 0};
                    for (int i = 0; i < 27; ++i)
                        if (const Real* near = known(place + Int3(i % 3, i / 3 % 3, i / 9) - 1)) {
                            ++count;
                            for (int c = 0; c < 3; ++c) sum[c] += near[c];
                        }
                    for (int c = 0; c < 3; ++c) to[c] = count > 0 ? sum[c] / static_cast<Real>(count) : Real(0);
                }
    });
}

int ScatteredLight::fieldOf(int volume, std::size_t target) const {
    const int cls = m_classOf[std::size_t(volume)];
    return cls < 0 ? -1 : static_cast<int>(target * m_classes) + cls;
}

// Linear interpolation between the centres of cells; `at` is relative to the centre of the first cell.
void ScatteredLight::sample(const Field& field, const Vec3& at, Real (&rgb)[3]) const {
    const Vec3 low = glm::floor(at);
    const Int3 cell(glm::clamp(low, Vec3(-1e9), Vec3(1e9)));
    const Int3 block(cell.x >> 3, cell.y >> 3, cell.z >> 3);
    std::int32_t stored = m_grid.stored(block);
    Int3 inside = cell - block * kCellEdge + 1;
    // If the cell's own block is not stored, the centres of border cells may lie in the border of a stored neighbour.
    for (int side = 1; side < 8 && stored < 0; ++side) {
        const Int3 step(side & 1, side >> 1 & 1, side >> 2);
        const Int3 beside((cell.x + step.x) >> 3, (cell.y + step.y) >> 3, (cell.z + step.z) >> 3);
        inside = cell - beside * kCellEdge + 1;
        if (glm::all(glm::greaterThanEqual(inside, Int3(0)))) stored = m_grid.stored(beside);
    }
    if (stored < 0) {
        for (Real& c : rgb) c = 0;
        return;
    }
    const Vec3 fraction = at - low;
    const Real fx = static_cast<Real>(fraction.x), fy = static_cast<Real>(fraction.y),
               fz = static_cast<Real>(fraction.z);
    const Real* corner = field.data() + (std::size_t(stored) * kPaddedCells +
                                         std::size_t((inside.z * kPadded + inside.y) * kPadded + inside.x)) *
                                            kFour;
    constexpr std::size_t kX = kFour, kY = kPadded * kFour, kZ = std::size_t(kPadded) * kPadded * kFour;
    for (std::size_t c = 0; c < 3; ++c) {
        const Real* p = corner + c;
        const auto mix = [](Real a, Real b, Real t) { return a + t * (b - a); };
        const Real near = mix(mix(p[0], p[kX], fx), mix(p[kY], p[kY + kX], fx), fy);
        const Real far = mix(mix(p[kZ], p[kZ + kX], fx), mix(p[kZ + kY], p[kZ + kY + kX], fx), fy);
        rgb[c] = mix(near, far, fz);
    }
}

void ScatteredLight::lookUp(int field, const SamplePlane& plane, const Real* u, const Real* v,
                            Real* const rgb[3]) const {
    const Field& values = m_fields[std::size_t(field)];
    const Vec3 origin = m_grid.csFromWs(plane.wsOrigin) - 0.5;
    const Vec3 perU = plane.wsPerU / m_grid.edge(), perV = plane.wsPerV / m_grid.edge();
    for (int k = 0; k < kTileSize; ++k) {
        Real found[3];
        sample(values, origin + double(u[k]) * perU + double(v[k]) * perV, found);
        for (int c = 0; c < 3; ++c) rgb[c][k] = found[c];
    }
}

// The error of cells falls with their edge: to a half if light and density vary together within a cell, to a quarter if
// fields are smooth. Measured against path tracers on fractal and on smooth smoke: subtracting kLeft of the additional
// error of cells twice as large leaves less than half of the error in both cases (L. F. Richardson, 1911). The rate
// cannot be measured with even larger cells, which do not resolve the fields and always suggest first order.
void ScatteredLight::extrapolate(const ViewScene& scene, const TransportPlan& plan, Simd simd,
                                 const std::function<void()>& checkpoint) {
    constexpr Real kLeft = Real(0.5);
    TransportPlan larger = plan;
    larger.coarse = true;
    larger.edge = 2 * plan.edge;
    const ScatteredLight twice(scene, larger, simd, checkpoint);
    m_solved += twice.m_solved;
    for (std::size_t f = 0; f < m_fields.size(); ++f)
        parallelFor(m_grid.storedBlocks().size(), [&](std::size_t block) {
            const Int3 first = m_grid.storedBlocks()[block] * kCellEdge - 1;
            Real* to = m_fields[f].data() + block * kPaddedCells * kFour;
            for (std::size_t i = 0; i < kPaddedCells; ++i, to += kFour) {
                const auto n = static_cast<int>(i);
                const Int3 place = first + Int3(n % kPadded, n / kPadded % kPadded, n / (kPadded * kPadded));
                const Vec3 ws = m_grid.wsFromCs(Vec3(place) + 0.5);
                Real two[3];
                twice.sample(twice.m_fields[f], twice.m_grid.csFromWs(ws) - 0.5, two);
                for (int c = 0; c < 3; ++c) to[c] = std::clamp(to[c] + kLeft * (to[c] - two[c]), to[c] / 2, 2 * to[c]);
            }
        });
}

}  // namespace scrim
