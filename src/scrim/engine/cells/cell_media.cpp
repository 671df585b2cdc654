// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/cells/cell_media.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/cells/cell_levels.h>
#include <scrim/scene/optics.h>
#include <scrim/volume/field_sampler.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/cells/cell_media.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/cells/cell_media-inl.h>

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(spreadBlock);

namespace {

// Distributes a box of space over the cells that it meets.
class BoxDeposit {
  public:
    BoxDeposit(const CellGrid& grid, const Deposit& deposit) : m_grid(grid), m_deposit(deposit) {
        const Mat3 m(deposit.wsFromIs);
        m_voxelVolume = std::abs(glm::dot(m[0], glm::cross(m[1], m[2])));
        if (deposit.between() || (deposit.classified && !deposit.classified->classified->gradientRamp.empty()))
            m_optics.emplace(*deposit.classified, Kernel::linear, m_samplers);
    }

    // The voxels of a block of a field whose axes are those of the world.
    void addBlock(std::size_t block, const Vec3& wsHalf, Simd simd) const {
        const SparseField& field = *m_deposit.field;
        const Vec3 first = m_grid.csFromWs(transformPoint(m_deposit.wsFromIs, Vec3(field.blockOrigins[block])));
        const Vec3 half = wsHalf / m_grid.edge();
        const auto along = [&](int a) {
            return EdgeParts(first[a], m_deposit.wsFromIs[a][a] / m_grid.edge(), half[a], m_deposit.tents);
        };
        const std::array<EdgeParts, 3> parts{along(0), along(1), along(2)};
        std::vector<Real> cells;
        SCRIM_ON_TARGET(simd, spreadBlock)(field.block(block), parts, cells);
        const double edge = m_grid.edge(), voxel = m_voxelVolume / (edge * edge * edge);
        forCells(m_grid, parts, cells, [&](std::size_t cell, Real sum) {
            for (const Deposit::Share& share : m_deposit.shares)
                (*share.row)[cell] += static_cast<Real>(share.factor * voxel * double(sum));
        });
    }

    // `voxels`: the volume of the box, in voxels.
    void add(const Vec3& wsCenter, const Vec3& wsHalf, double voxels, double value) const {
        ClassifiedValue own{Rgb(1), value};
        if (m_deposit.classified) own = classified(wsCenter, wsHalf, value);
        if (own.extinction == 0) return;
        const Vec3 center = m_grid.csFromWs(wsCenter), half = wsHalf / m_grid.edge();
        const std::array<CellParts, 3> spans{CellParts(center.x, half.x, m_deposit.tents),
                                             {center.y, half.y, m_deposit.tents},
                                             {center.z, half.z, m_deposit.tents}};
        const double edge = m_grid.edge();
        const double amount = own.extinction * voxels * m_voxelVolume / (edge * edge * edge);
        for (int z = 0; z < spans[2].count; ++z)
            for (int y = 0; y < spans[1].count; ++y)
                for (int x = 0; x < spans[0].count; ++x) {
                    const std::ptrdiff_t cell =
                        m_grid.index({spans[0].first + x, spans[1].first + y, spans[2].first + z});
                    if (cell < 0) continue;
                    const double part = amount * spans[0].part(x) * spans[1].part(y) * spans[2].part(z);
                    for (const auto& [row, factor, colour] : m_deposit.shares)
                        (*row)[std::size_t(cell)] += Real(factor * part * (colour < 0 ? 1 : own.color[colour]));
                }
    }

  private:
    // The colour and the mean extinction of the box, of which the volume's clip may leave a part.
    ClassifiedValue classified(const Vec3& wsCenter, const Vec3& wsHalf, double value) const {
        const ViewVolume& volume = *m_deposit.classified;
        const Vec3 e = 2.0 * wsHalf;
        ClassifiedValue own = classify(*volume.classified, m_deposit.between() ? m_optics->density(wsCenter) : value);
        if (own.extinction > 0 && !volume.classified->gradientRamp.empty())
            own.extinction *= gradientFactor(*volume.classified, glm::length(m_optics->gradient(wsCenter)));
        own.extinction *= partIn(volume.wsClip, wsCenter, {e.x, 0, 0, 0, e.y, 0, 0, 0, e.z});
        return own;
    }

    const CellGrid& m_grid;
    const Deposit& m_deposit;
    double m_voxelVolume;
    FieldSamplers m_samplers;
    std::optional<VolumeOptics> m_optics;  // only for gradients, and for values between voxels
};

void depositBlock(const BoxDeposit& into, const Deposit& deposit, std::size_t block, const Vec3& half) {
    const SparseField& field = *deposit.field;
    const float* values = field.block(block);
    for (int x = 0; x < kBlockEdge; ++x)
        for (int y = 0; y < kBlockEdge; ++y)
            for (int z = 0; z < kBlockEdge; ++z)
                if (const float value = values[blockOffset(x, y, z)]; value > 0 || deposit.between())
                    forParts(deposit, field.blockOrigins[block] + Int3(x, y, z), half,
                             [&](const Vec3& ws, const Vec3& own, double part) { into.add(ws, own, part, value); });
}

// Deposits a tile in cubes that are about as large as a cell and that divide the tile's edge.
void depositTile(const CellGrid& grid, const BoxDeposit& into, const Deposit& deposit, const ConstantTile& tile,
                 const Vec3& half) {
    int edge = 1;
    while (edge < kBlockEdge && 4 * edge * largest(half) <= grid.edge()) edge *= 2;
    for (int x = 0; x < tile.edge; x += edge)
        for (int y = 0; y < tile.edge; y += edge)
            for (int z = 0; z < tile.edge; z += edge)
                into.add(transformPoint(deposit.wsFromIs, Vec3(tile.origin + Int3(x, y, z)) + 0.5 * (edge - 1)),
                         double(edge) * half, double(edge) * edge * edge, tile.value);
}

constexpr double kLarge = 1.01;  // voxels, in cells, that are interpolated

// The least distance of two parallel faces of a voxel, which in a sheared volume is less than any edge.
double leastHeight(const Mat4& wsFromIs) {
    const Mat3 m(wsFromIs);
    const double volume = std::abs(glm::dot(m[0], glm::cross(m[1], m[2])));
    double least = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis)
        least = std::min(least, volume / glm::length(glm::cross(m[(axis + 1) % 3], m[(axis + 2) % 3])));
    return least;
}

// Where a volume is turned or sheared, its voxels are no boxes along the cells. What lies in a cell is then the mean of
// the interpolated field (light in a dense ball, turned: 6.6 % off with the boxes around its voxels, and now 0.8) at
// this many places along each edge; 0: voxels are deposited all the same.
int gatheredPlaces(const CellGrid& grid, const Deposit& deposit) {
    constexpr double kMost = 4;
    const double places = std::ceil(grid.edge() / leastHeight(deposit.wsFromIs));
    return places <= kMost ? static_cast<int>(places) : 0;
}

void gather(const CellGrid& grid, const Deposit& deposit, int places) {
    constexpr int kPart = kCellEdge / 2;  // cells along an edge whose voxels are looked up together
    const SparseField& field = *deposit.field;
    const FieldSampler sampler(field);
    const Mat4 isFromWs = glm::inverse(deposit.wsFromIs);
    const Bounds reached{field.isBounds().lower - 0.5, field.isBounds().upper + 0.5};
    const double step = 1.0 / places, weight = step * step * step;
    const auto isFromCs = [&](const Vec3& cs) { return transformPoint(isFromWs, grid.wsFromCs(cs)); };
    const auto boxOf = [&](const Int3& first, int edge) {
        return transformed(isFromWs, {grid.wsFromCs(Vec3(first)), grid.wsFromCs(Vec3(first + edge))});
    };
    const auto meets = [&](const Bounds& box) {
        return overlap(box, reached) && sampler.index().anyIn({box.lower - 1.0, box.upper + 1.0});
    };
    const auto addPart = [&](std::size_t block, const Int3& part) {
        const Int3 first = grid.storedBlocks()[block] * kCellEdge + kPart * part;
        const Bounds box = boxOf(first, kPart);
        if (!meets(box)) return;
        thread_local FieldBrick brick;
        const bool inBrick = brick.fill(sampler, box);
        for (int i = 0; i < kPart * kPart * kPart; ++i) {
            const Int3 own(i % kPart, i / kPart % kPart, i / kPart / kPart), inside = kPart * part + own;
            double sum = 0;
            for (int k = 0; k < places * places * places; ++k) {
                const Vec3 within = (Vec3(k % places, k / places % places, k / places / places) + 0.5) * step;
                const Vec3 is = isFromCs(Vec3(first + own) + within);
                sum += std::max(inBrick ? brick.value(is) : sampler.value(is), 0.0);
            }
            if (sum == 0) continue;
            const std::size_t cell = block * kBlockCells + std::size_t(cellOffset(inside.x, inside.y, inside.z));
            for (const Deposit::Share& to : deposit.shares)
                (*to.row)[cell] += static_cast<Real>(to.factor * weight * sum);
        }
    };
    parallelFor(grid.storedBlocks().size(), [&](std::size_t block) {
        if (!meets(boxOf(grid.storedBlocks()[block] * kCellEdge, kCellEdge))) return;
        for (int i = 0; i < 8; ++i) addPart(block, {i & 1, i >> 1 & 1, i >> 2});
    });
}

// The blocks of a field as tasks in eight rounds: cubes of 2^shift blocks an edge. Between two
// cubes of a round lies at least one other.
std::array<std::vector<std::vector<std::size_t>>, 8> roundsOf(const SparseField& field, int shift) {
    std::vector<std::pair<std::array<int, 3>, std::size_t>> byCube;  // z, y and x of the cube, and a block
    for (std::size_t b = 0; b < field.blockCount(); ++b) {
        const Int3 at = field.blockOrigins[b] / kBlockEdge;
        byCube.push_back({{at.z >> shift, at.y >> shift, at.x >> shift}, b});
    }
    if (shift > 0) std::ranges::sort(byCube);
    std::array<std::vector<std::vector<std::size_t>>, 8> rounds;
    for (std::size_t i = 0; i < byCube.size(); ++i) {
        const auto& [cube, block] = byCube[i];
        auto& round = rounds[std::size_t((cube[2] & 1) + 2 * (cube[1] & 1) + 4 * (cube[0] & 1))];
        if (i == 0 || cube != byCube[i - 1].first) round.emplace_back();
        round.back().push_back(block);
    }
    return rounds;
}

// Deposits a field. Every block contributes to the cells around it. Cubes of blocks that are not
// neighbours share no cells if they are large enough, so every other cube can be processed in
// parallel, in eight rounds. The sums do not depend on the thread that adds them. Turned volumes,
// and with a `margin` (see cellMedia) those of large voxels, are gathered cell by cell instead.
void add(const CellGrid& grid, const Deposit& deposit, double margin, Simd simd) {
    const Mat3 axes(deposit.wsFromIs);
    const bool straight = !deposit.classified && axes == Mat3(axes[0].x, 0, 0, 0, axes[1].y, 0, 0, 0, axes[2].z);
    // Boxes that are larger than cells would show their edges.
    const bool large = margin > 0 && !deposit.tents && 2 * largest(halfVoxel(deposit.wsFromIs)) > kLarge * grid.edge();
    if (!deposit.classified && (!straight || large))
        if (const int places = gatheredPlaces(grid, deposit); places > 0) return gather(grid, deposit, places);
    constexpr int kMostShift = 24;  // one cube on each side of the origin
    const SparseField& field = *deposit.field;
    const Vec3 half = halfVoxel(deposit.wsFromIs);
    const BoxDeposit into(grid, deposit);
    // Between the outermost voxels of two cubes of a round there are at least those of one cube. What each adds to
    // reaches half a voxel's box beyond its centre, twice that as a tent, and to the corners of cells.
    const double reach = glm::length(half) * (deposit.tents ? 2 : 1) + std::sqrt(3.0) * grid.edge();
    const double height = leastHeight(deposit.wsFromIs);
    int shift = 0;
    while (shift < kMostShift && height * ((kBlockEdge << shift) + 1) <= 2 * reach) ++shift;
    const auto addBlock = [&](std::size_t block) {
        straight ? into.addBlock(block, half, simd) : depositBlock(into, deposit, block, half);
    };
    for (const auto& round : roundsOf(field, shift))
        parallelFor(round.size(), [&](std::size_t i) { std::ranges::for_each(round[i], addBlock); });
    for (const ConstantTile& tile : field.tiles) depositTile(grid, into, deposit, tile, half);
}

// `coloured`: they are parts of the extinction times the transfer function's colour.
void addShares(std::vector<std::vector<Real>>& rows, const Rgb& factor, Deposit& deposit, bool coloured = false) {
    for (std::size_t c = 0; c < rows.size(); ++c)
        if (factor[int(c)] != 0) deposit.shares.push_back({&rows[c], factor[int(c)], coloured ? int(c) : -1});
}

// Adds a volume's extinction, and its scattering to `scattering` if it scatters. `margin`: as in cellMedia.
void addVolume(CellMedia& media, const ViewVolume& volume, std::vector<std::vector<Real>>* scattering, double margin,
               Simd simd) {
    if (volume.field->empty()) return;
    const Medium& medium = volume.medium;
    const Classified* look = volume.classified.get();
    Deposit density{volume.field.get(), volume.wsFromIs, look ? &volume : nullptr, {}};
    const Rgb extinction = look ? Rgb(1) : medium.densityScale * medium.extinctionTint;
    const Vec3 voxel = 2.0 * halfVoxel(volume.wsFromIs);
    const double least = std::min({voxel.x, voxel.y, voxel.z});
    density.tents = least > kLarge * media.grid.edge() && largest(voxel) <= margin && !look;
    density.eighths = least > 0.6 * media.grid.edge();
    addShares(media.extinction, extinction, density);
    if (scattering && volume.scatter.empty())
        addShares(*scattering, look ? look->albedo : extinction * medium.albedo, density, look != nullptr);
    add(media.grid, density, margin, simd);
    for (std::size_t c = 0; scattering && c < volume.scatter.size(); ++c) {
        const ViewField& field = volume.scatter[c];
        if (field.field->empty()) continue;
        add(media.grid, {field.field.get(), field.wsFromIs, nullptr, {{&(*scattering)[c], extinction[int(c)]}}}, margin,
            simd);
    }
}

}  // namespace

void goStraight(CellMedia& media, const std::vector<ScatterClass>& classes) {
    if (std::all_of(classes.begin(), classes.end(), [](const ScatterClass& c) { return c.straight() == 0; })) return;
    for (std::size_t c = 0; c < std::max(media.extinction.size(), media.scattering.front().size()); ++c) {
        std::vector<Real>& straight = media.straight.emplace_back(media.grid.cells(), Real(0));
        for (std::size_t k = 0; k < classes.size(); ++k) {
            const auto part = static_cast<Real>(classes[k].straight());
            const std::vector<Real>& scattering = media.scatteringOf(k, c);
            for (std::size_t cell = 0; cell < straight.size(); ++cell) straight[cell] += part * scattering[cell];
        }
    }
    media.extinction.resize(media.straight.size(), media.extinction.front());
    for (std::size_t c = 0; c < media.straight.size(); ++c)
        for (std::size_t cell = 0; cell < media.grid.cells(); ++cell)
            media.extinction[c][cell] = std::max(media.extinction[c][cell] - media.straight[c][cell], Real(0));
    for (std::size_t k = 0; k < classes.size(); ++k)
        for (std::vector<Real>& row : media.scattering[k])
            for (Real& value : row) value *= static_cast<Real>(1 - classes[k].straight());
}

std::vector<std::vector<int>> alikeVolumes(const ViewScene& scene,
                                           const std::function<bool(const ViewVolume&)>& wanted) {
    std::vector<std::vector<int>> classes;
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        const ViewVolume& volume = scene.volumes[v];
        if (!wanted(volume)) continue;
        const auto same = std::find_if(classes.begin(), classes.end(), [&](const std::vector<int>& cls) {
            const ViewVolume& first = scene.volumes[std::size_t(cls.front())];
            return first.medium.phase == volume.medium.phase && first.medium.octaves == volume.medium.octaves &&
                   first.lights == volume.lights;
        });
        (same != classes.end() ? *same : classes.emplace_back()).push_back(static_cast<int>(v));
    }
    return classes;
}

std::vector<ScatterClass> scatterClasses(const ViewScene& scene, int ordinates) {
    std::vector<ScatterClass> classes;
    const auto add = [&](bool once, const std::function<bool(const ViewVolume&)>& wanted) {
        for (std::vector<int>& volumes : alikeVolumes(scene, wanted)) {
            const ViewVolume& first = scene.volumes[std::size_t(volumes.front())];
            const Phase& phase = first.medium.phase;
            classes.push_back({phase, once, {phase, resolvedMoments(ordinates)}, first.lights, std::move(volumes)});
        }
    };
    add(false, scattersFully);
    if (!classes.empty()) add(true, scattersOnce);
    return classes;
}

std::size_t CellMedia::bytes() const {
    std::size_t rows = extinction.size() + straight.size() + emission.size();
    for (const auto& cls : scattering) rows += cls.size();
    return grid.bytes() + rows * grid.cells() * sizeof(Real);
}

std::vector<Bounds> cellBoxes(const ViewScene& scene, double margin) {
    std::vector<Bounds> boxes;
    for (const ViewVolume& volume : scene.volumes)
        for (const ViewField& field : fieldsOf(volume)) {
            const Vec3 half = halfVoxel(field.wsFromIs);  // as far as the interpolated field reaches
            const auto include = [&](const Int3& origin, int edge) {
                Bounds box = transformed(field.wsFromIs, {Vec3(origin) - 0.5, Vec3(origin + edge) - 0.5});
                const Vec3 beyond = glm::max(Vec3(margin), half);
                box.lower -= beyond;
                box.upper += beyond;
                boxes.push_back(box);
            };
            for (const Int3& origin : field.field->blockOrigins) include(origin, kBlockEdge);
            for (const ConstantTile& tile : field.field->tiles) include(tile.origin, tile.edge);
        }
    return boxes;
}

double reachOfWideKernels(const ViewScene& scene) {
    double reach = 0;
    for (const ViewVolume& volume : scene.volumes)
        for (const ViewField& field : fieldsOf(volume)) {
            const double radius = kernelRadius(field.kernel.value_or(scene.dials.kernel));
            if (radius > kernelRadius(Kernel::linear)) reach = std::max(reach, (radius - 0.5) * voxelUnit(volume));
        }
    return reach;
}

CellGrid cellGrid(const ViewScene& scene, double edge, const CellPlaces& places) {
    const double margin = std::max(edge, places.margin);
    std::vector<Bounds> boxes =
        places.covered.empty() ? cellBoxes(scene, margin) : cellBoxes(withVoxelsOf(scene, places.covered), margin);
    boxes.insert(boxes.end(), places.more.begin(), places.more.end());
    const bool walls = places.walls && !boxes.empty() && solidsBlock(scene);
    if (walls) {
        Bounds all;
        for (const Bounds& box : boxes) all.include(box);
        const double reach = 0.5 * largest(all.size());
        const std::vector<Bounds> more =
            CellGrid::boxesOfWalls(*scene.solids, edge, all, {all.lower - reach, all.upper + reach});
        boxes.insert(boxes.end(), more.begin(), more.end());
    }
    CellGrid grid(edge, boxes, places.wsCorner);
    if (walls) grid.raiseWalls(scene.solids);
    return grid;
}

CellMedia cellMedia(const ViewScene& scene, const std::vector<ScatterClass>& classes, double edge, Simd simd,
                    const CellPlaces& places) {
    CellMedia media;
    media.grid = cellGrid(scene, edge, places);
    const auto rows = [&](bool one) {
        return std::vector<std::vector<Real>>(one ? 1 : 3, std::vector<Real>(media.grid.cells(), Real(0)));
    };
    media.extinction = rows(greyExtinction(scene));
    for (std::size_t k = 0; k < classes.size(); ++k) media.scattering.push_back(rows(greyScattering(scene)));
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        if (!places.dense.empty() && !places.dense[v]) continue;
        std::vector<std::vector<Real>>* scattering = nullptr;
        for (std::size_t k = 0; k < classes.size(); ++k)
            if (std::count(classes[k].volumes.begin(), classes[k].volumes.end(), static_cast<int>(v)))
                scattering = &media.scattering[k];
        addVolume(media, scene.volumes[v], scattering, places.margin, simd);
        for (const ViewEmission& emission : scene.volumes[v].emission) {
            if (media.emission.empty()) media.emission = rows(false);
            if (emission.field.field->empty()) continue;
            Deposit glow{emission.field.field.get(), emission.field.wsFromIs, nullptr, {}};
            addShares(media.emission, emission.color, glow);
            add(media.grid, glow, places.margin, simd);
        }
    }
    goStraight(media, classes);
    return media;
}

void addLarger(CellMedia& media, const CellMedia& larger) {
    if (media.emission.empty() && !larger.emission.empty())
        media.emission.assign(3, std::vector<Real>(media.grid.cells(), Real(0)));
    parallelFor(media.grid.storedBlocks().size(), [&](std::size_t block) {
        for (std::size_t cell = block * kBlockCells; cell < (block + 1) * kBlockCells; ++cell) {
            const Vec3 at = larger.grid.csFromWs(media.grid.wsCenter(cell)) - 0.5;
            const Int3 low(glm::floor(at));
            const Vec3 part = at - Vec3(low);
            std::array<std::pair<std::size_t, Real>, 8> near;
            std::size_t count = 0;
            for (int corner = 0; corner < 8; ++corner) {
                const Int3 up(corner & 1, corner >> 1 & 1, corner >> 2);
                const std::ptrdiff_t index = larger.grid.index(low + up);
                const Vec3 weight = glm::mix(1.0 - part, part, Vec3(up));
                if (index >= 0) near[count++] = {std::size_t(index), static_cast<Real>(weight.x * weight.y * weight.z)};
            }
            const auto add = [&](std::vector<std::vector<Real>>& to, const std::vector<std::vector<Real>>& from) {
                for (std::size_t c = 0; c < from.size(); ++c)
                    for (std::size_t i = 0; i < count; ++i) to[c][cell] += near[i].second * from[c][near[i].first];
            };
            add(media.extinction, larger.extinction);
            add(media.straight, larger.straight);
            add(media.emission, larger.emission);
            for (std::size_t k = 0; k < larger.scattering.size(); ++k) add(media.scattering[k], larger.scattering[k]);
        }
    });
}

namespace {

// Coarser cells along an edge of a finer block, including one around it on each side.
constexpr int kAround = kCellEdge / 2 + 2;
constexpr std::size_t kNear = std::size_t(kAround) * kAround * kAround;
// The weights of two neighbours along an axis.
constexpr Real kNearer = Real(0.75), kFarther = Real(0.25);

// The indices of the two coarser cells beside cell i of an edge: the nearer one, and the other.
constexpr auto nearer = [](int i) { return i / 2 + 1; };
constexpr auto farther = [](int i) { return nearer(i) + ((i & 1) != 0 ? 1 : -1); };

using Rows = std::array<const Real*, kNear>;

// Interpolates one value per row, along one axis after the other: sums of values, and how many cells they have.
void addOne(const Rows& near, const std::int32_t* rows, Real* to) {
    constexpr int kE = kCellEdge, kA = kAround;
    using Pair = std::array<Real, 2>;  // value, weight
    const auto mix = [](const Pair& a, const Pair& b) {
        return Pair{kNearer * a[0] + kFarther * b[0], kNearer * a[1] + kFarther * b[1]};
    };
    std::array<Pair, kNear> cells;
    for (std::size_t i = 0; i < kNear; ++i) cells[i] = near[i] ? Pair{*near[i], 1} : Pair{0, 0};
    std::array<Pair, std::size_t(kE) * kA * kA> alongX;
    for (int i = 0; i < kA * kA; ++i)
        for (int x = 0; x < kE; ++x)
            alongX[std::size_t(i * kE + x)] =
                mix(cells[std::size_t(i * kA + nearer(x))], cells[std::size_t(i * kA + farther(x))]);
    std::array<Pair, std::size_t(kE) * kE * kA> alongY;
    for (int z = 0; z < kA; ++z)
        for (int y = 0; y < kE; ++y)
            for (int x = 0; x < kE; ++x)
                alongY[std::size_t((z * kE + y) * kE + x)] = mix(alongX[std::size_t((z * kA + nearer(y)) * kE + x)],
                                                                 alongX[std::size_t((z * kA + farther(y)) * kE + x)]);
    for (int z = 0; z < kE; ++z)
        for (int i = 0; i < kE * kE; ++i) {
            const std::int32_t row = rows[z * kE * kE + i];
            const Pair sum =
                mix(alongY[std::size_t(nearer(z) * kE * kE + i)], alongY[std::size_t(farther(z) * kE * kE + i)]);
            if (row >= 0 && sum[1] > 0) to[row] += sum[0] / sum[1];
        }
}

void addMany(const Rows& near, const Int3& cell, std::size_t values, Real* to) {
    std::array<std::pair<const Real*, Real>, 8> parts;
    std::size_t count = 0;
    Real sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        Int3 at;
        Real weight = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const bool other = (corner >> axis & 1) != 0;
            at[axis] = other ? farther(cell[axis]) : nearer(cell[axis]);
            weight *= other ? kFarther : kNearer;
        }
        const Real* row = near[std::size_t((at.z * kAround + at.y) * kAround + at.x)];
        if (!row) continue;
        sum += weight;
        parts[count++] = {row, weight};
    }
    for (std::size_t i = 0; i < count; ++i) {
        const Real weight = parts[i].second / sum;
        for (std::size_t m = 0; m < values; ++m) to[m] += weight * parts[i].first[m];
    }
}

}  // namespace

CellMedia coarser(const CellMedia& fine) {
    CellMedia out;
    out.grid = CellGrid::coarser(fine.grid);
    const auto rows = [&](const std::vector<std::vector<Real>>& from) {
        std::vector<std::vector<Real>> to;
        for (const std::vector<Real>& row : from) to.push_back(fine.grid.means(row, out.grid));
        return to;
    };
    out.extinction = rows(fine.extinction);
    for (const auto& cls : fine.scattering) out.scattering.push_back(rows(cls));
    return out;
}

void addInterpolated(const CellGrid& coarse, const std::vector<std::int32_t>& coarseRows, const std::vector<Real>& from,
                     const CellGrid& fine, const std::vector<std::int32_t>& fineRows, std::size_t values,
                     std::vector<Real>& to) {
    const Int3 shift(glm::round(coarse.csFromWs(fine.wsFromCs(Vec3(0)))));
    parallelFor(fine.storedBlocks().size(), [&](std::size_t block) {
        Rows near;
        const Int3 first = shift + fine.storedBlocks()[block] * (kCellEdge / 2) - 1;
        for (std::size_t i = 0; i < near.size(); ++i) {
            const auto n = static_cast<int>(i);
            const std::ptrdiff_t cell =
                coarse.index(first + Int3(n % kAround, n / kAround % kAround, n / (kAround * kAround)));
            const std::int32_t row = cell < 0 ? -1 : coarseRows[std::size_t(cell)];
            near[i] = row < 0 ? nullptr : from.data() + std::size_t(row) * values;
        }
        const std::int32_t* rows = fineRows.data() + block * kBlockCells;
        if (values == 1) return addOne(near, rows, to.data());
        for (int i = 0; i < kBlockCells; ++i)
            if (rows[i] >= 0)
                addMany(near, {i % kCellEdge, i / kCellEdge % kCellEdge, i / (kCellEdge * kCellEdge)}, values,
                        to.data() + std::size_t(rows[i]) * values);
    });
}

}  // namespace scrim
#endif
