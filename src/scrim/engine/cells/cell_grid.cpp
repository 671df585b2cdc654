// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/cells/cell_grid.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/solid/cubes_at.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kMostBlocks = 1 << 24;  // of the box; their numbers take 64 MB
// The largest distance from the world's origin, in blocks, so that cells can be counted with an int.
constexpr double kFarthestBlock = 1 << 26;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Ways from one cell to the next one, beside the straight one, lead over these places of their cross-sections.
constexpr int kWays = 4;
constexpr double aside(int way) {
    return (way + 0.5) / kWays - 0.5;
}
static_assert(kWays * kWays == kAllOpen);

Int3 along(int axis) {
    return {axis == 0, axis == 1, axis == 2};
}
Vec3 across(int axis, int i, int j) {
    Vec3 out(0);
    out[(axis + 1) % 3] = aside(i);
    out[(axis + 2) % 3] = aside(j);
    return out;
}
Int3 cornerOf(int bits) {
    return {bits & 1, bits >> 1 & 1, bits >> 2};
}
// The surface of the stairs that stand for a wall, relative to the wall's.
double stairs(const Vec3& normal) {
    return std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z);
}

// A side while its walls are measured: its number, and in faces what is closed and the surface of the wall there.
struct FoundSide {
    std::size_t number;
    Rgb albedo;
    double closed, faces;
};

}  // namespace

CellGrid::CellGrid(double edge, const std::vector<Bounds>& wsBoxes, const Vec3& wsCorner)
    : m_edge(edge), m_corner(wsCorner) {
    Bounds all;
    for (const Bounds& box : wsBoxes) all.include(box);
    if (wsBoxes.empty()) return;
    all.lower -= wsCorner;
    all.upper -= wsCorner;
    const double blockEdge = edge * kCellEdge;
    const Vec3 first = glm::floor(all.lower / blockEdge), last = glm::floor(all.upper / blockEdge);
    const Vec3 size = last - first + 1.0;
    const Vec3 farthest = glm::max(glm::abs(first), glm::abs(last));
    if (!(size.x * size.y * size.z <= kMostBlocks) || largest(farthest) > kFarthestBlock)
        throw Error(ErrorKind::memory, fmt::format("cells of {:.4g} world units for scattered light make {:.3g} x "
                                                   "{:.3g} x {:.3g} blocks, which is too many; raise scatter_cell",
                                                   edge, size.x, size.y, size.z));
    const Int3 origin(first);
    m_origin = origin * kCellEdge;
    m_blocks = Int3(size);
    std::vector<bool> wanted(numberInBox(m_blocks - 1) + 1, false);
    for (const Bounds& box : wsBoxes) {
        const Int3 from = Int3(glm::floor((box.lower - wsCorner) / blockEdge)) - origin;
        const Int3 to = Int3(glm::floor((box.upper - wsCorner) / blockEdge)) - origin;
        for (int z = from.z; z <= to.z; ++z)
            for (int y = from.y; y <= to.y; ++y)
                for (int x = from.x; x <= to.x; ++x) wanted[numberInBox({x, y, z})] = true;
    }
    number(std::move(wanted));
}

CellGrid CellGrid::coarser(const CellGrid& fine) {
    CellGrid out;
    out.m_edge = 2 * fine.m_edge;
    out.m_corner = fine.m_corner;
    if (fine.m_places.empty()) return out;
    const Int3 fineOrigin = fine.m_origin / kCellEdge;  // exact, since both are multiples of 8
    const Int3 first = fineOrigin >> 1, last = (fineOrigin + fine.m_blocks - 1) >> 1;
    out.m_origin = first * kCellEdge;
    out.m_blocks = last - first + 1;
    std::vector<bool> wanted(out.numberInBox(out.m_blocks - 1) + 1, false);
    for (const Int3& place : fine.m_places) wanted[out.numberInBox(((fineOrigin + place) >> 1) - first)] = true;
    out.number(std::move(wanted));
    return out;
}

void CellGrid::number(std::vector<bool>&& wanted) {
    m_stored.assign(wanted.size(), -1);
    std::size_t i = 0;
    for (int z = 0; z < m_blocks.z; ++z)
        for (int y = 0; y < m_blocks.y; ++y)
            for (int x = 0; x < m_blocks.x; ++x, ++i) {
                if (!wanted[i]) continue;
                m_stored[i] = static_cast<std::int32_t>(m_places.size());
                m_places.emplace_back(x, y, z);
            }
}

Int3 CellGrid::place(std::size_t index) const {
    const auto inBlock = static_cast<int>(index % kBlockCells);
    return m_places[index / kBlockCells] * kCellEdge +
           Int3(inBlock % kCellEdge, inBlock / kCellEdge % kCellEdge, inBlock / (kCellEdge * kCellEdge));
}

std::vector<Bounds> CellGrid::boxesOfWalls(const Solids& solids, double edge, const Bounds& wsNear,
                                           const Bounds& wsFar) {
    const double blockEdge = edge * kCellEdge;
    std::set<std::array<int, 3>> blocks;
    const auto range = [&](const Solid& solid) {
        const Bounds& box = solid.sendsBack() ? wsFar : wsNear;
        return std::pair(Int3(glm::floor(box.lower / blockEdge)), Int3(glm::floor(box.upper / blockEdge)));
    };
    forCubesAt(solids, blockEdge, Vec3(0), 1.1 * edge, range, [&](const Int3& at) {
        blocks.insert({at.x, at.y, at.z});
    });
    std::vector<Bounds> boxes;
    for (const auto& at : blocks) {
        const Vec3 middle = (Vec3(at[0], at[1], at[2]) + 0.5) * blockEdge;
        boxes.push_back({middle, middle});
    }
    return boxes;
}

// For each cell whether a wall may pass through it, or just beside it.
std::vector<bool> CellGrid::nearWalls() const {
    std::vector<bool> near(cells(), false);
    const auto everywhere = [&](const Solid&) { return std::pair(Int3(0), m_blocks * kCellEdge - 1); };
    forCubesAt(*m_solids, m_edge, wsFromCs(Vec3(0)), 0.03 * m_edge, everywhere, [&](const Int3& at) {
        if (const std::ptrdiff_t cell = index(at); cell >= 0) near[std::size_t(cell)] = true;
    });
    return near;
}

bool CellGrid::sees(const Vec3& wsFrom, const Vec3& wsTo) const {
    return wsFrom == wsTo || m_solids->firstHit(SolidRole::shadow, wsFrom, wsTo - wsFrom, 0, 1) == kInfinity;
}

// The part of the ways from one cell to the next that no wall crosses. Only ways that begin on the one cell's side of
// all walls, and end on the other's, count. Thus nothing leaks through a wall without edges, and a wall beside two
// cells closes nothing between them, although it cuts through both.
std::uint8_t CellGrid::openFace(const Int3& upper, int axis) const {
    const Vec3 from = wsInside(upper - along(axis)), to = wsInside(upper);
    int count = 0, all = 0;
    const auto add = [&](const Vec3& beside) {
        if (!sees(from, from + beside) || !sees(to, to + beside)) return;
        ++all;
        count += sees(from + beside, to + beside) ? 1 : 0;
    };
    constexpr int kLast = kWays - 1;
    add(Vec3(0));
    for (const auto& [i, j] : {std::pair(0, 0), {kLast, 0}, {0, kLast}, {kLast, kLast}})
        add(m_edge * across(axis, i, j));
    if (count == 0 || count == all) return count == 0 ? 0 : kAllOpen;
    count = all = 0;
    for (int way = 0; way < kAllOpen; ++way) add(m_edge * across(axis, way % kWays, way / kWays));
    return static_cast<std::uint8_t>(std::lround(double(kAllOpen * count) / std::max(all, 1)));
}

void CellGrid::raiseWalls(std::shared_ptr<const Solids> solids) {
    m_solids = std::move(solids);
    const std::vector<bool> near = nearWalls();
    const auto isNear = [&](const Int3& place) {
        const std::ptrdiff_t cell = index(place);
        return cell >= 0 && near[std::size_t(cell)];
    };
    std::vector<std::vector<std::uint8_t>> open(m_places.size());
    parallelFor(m_places.size(), [&](std::size_t b) {
        std::vector<std::uint8_t> ofBlock(3 * kPaddedCells, kAllOpen);
        bool walled = false;
        for (std::size_t i = 0; i < ofBlock.size(); ++i) {
            const int axis = static_cast<int>(i / kPaddedCells), n = static_cast<int>(i % kPaddedCells);
            const Int3 padded = paddedCell(n);
            const Int3 place = m_places[b] * kCellEdge - 1 + padded;
            if (padded[axis] == 0 || (!isNear(place) && !isNear(place - along(axis)))) continue;
            ofBlock[i] = openFace(place, axis);
            walled = walled || ofBlock[i] < kAllOpen;
        }
        if (walled) open[b] = std::move(ofBlock);
    });
    m_walled.assign(m_places.size(), -1);
    m_open.clear();
    for (std::size_t b = 0; b < open.size(); ++b) {
        if (open[b].empty()) continue;
        m_walled[b] = static_cast<std::int32_t>(m_open.size() / (3 * kPaddedCells));
        m_open.insert(m_open.end(), open[b].begin(), open[b].end());
    }
    findSides();
}

// Where ways from a cell through one of its faces meet solids, with normals towards the cell.
std::vector<std::pair<Vec3, SolidHit>> CellGrid::hitsOfFace(const Int3& cell, int face) const {
    const int axis = face / 2;
    const Vec3 from = wsInside(cell), way = m_edge * Vec3(along(axis)) * (face % 2 == 1 ? 1.0 : -1.0);
    std::vector<std::pair<Vec3, SolidHit>> hits;
    const auto add = [&](const Vec3& begin) {
        SolidHit hit = m_solids->trace(SolidRole::shadow, begin, way, 0, 1);
        if (hit.t == kInfinity) return;
        hit.wsNormal = glm::normalize(hit.wsNormal);
        if (glm::dot(hit.wsNormal, way) > 0) hit.wsNormal = -hit.wsNormal;
        hits.emplace_back(begin + hit.t * way, hit);
    };
    for (int i = 0; i < kAllOpen; ++i) {
        const Vec3 begin = from + m_edge * across(axis, i % kWays, i / kWays);
        if (sees(from, begin)) add(begin);
    }
    if (hits.empty()) add(from);
    return hits;
}

void CellGrid::findSides() {
    m_sides.clear();
    m_albedos.clear();
    m_firsts.clear();
    m_sideAt.clear();
    if (!m_solids->anySendsBack()) return;
    m_sideAt.assign(m_open.size() / (3 * kPaddedCells) * 6 * kBlockCells, -1);
    std::vector<std::vector<FoundSide>> found(m_places.size());
    parallelFor(m_places.size(), [&](std::size_t b) {
        if (m_walled[b] < 0) return;
        for (std::size_t i = 0; i < 6 * kBlockCells; ++i) {
            const std::size_t cell = b * kBlockCells + i / 6;
            const auto face = static_cast<int>(i % 6);
            const Int3 at = place(cell), upper = at - m_places[b] * kCellEdge + 1 + along(face / 2) * (face % 2);
            const int isOpen = open(m_walled[b], face / 2)[paddedOffset(upper.x, upper.y, upper.z)];
            if (isOpen == kAllOpen) continue;
            FoundSide side{6 * cell + i % 6, Rgb(0), 1 - double(isOpen) / kAllOpen, 0};
            const auto hits = hitsOfFace(at, face);
            for (const auto& [ws, hit] : hits) {
                const Rgb own = hit.solid->albedo;
                const double k = stairs(hit.wsNormal);
                side.albedo += own * k / (1.0 + own * (k - 1)) / double(hits.size());
                side.faces += side.closed / (k * double(hits.size()));
            }
            if (side.albedo != Rgb(0)) found[b].push_back(side);
        }
    });
    std::vector<FoundSide> sides;
    for (const auto& ofBlock : found)
        for (const FoundSide& side : ofBlock) {
            const std::size_t cell = side.number / 6;
            m_sideAt[(std::size_t(m_walled[cell / kBlockCells]) * 6 + side.number % 6) * kBlockCells +
                     cell % kBlockCells] = static_cast<std::int32_t>(m_sides.size());
            m_sides.push_back(sides.emplace_back(side).number);
        }
    const std::vector<double> areas = areasOfSides();
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const double ratio = areas[i] / std::max(sides[i].faces, 1e-3);
        m_firsts.push_back(sides[i].closed * ratio * sides[i].albedo);
        m_albedos.push_back(sides[i].closed * glm::max(1.0 - ratio * (1.0 - sides[i].albedo), Rgb(0)));
    }
}

// The side that stands for a wall just behind a point; -1: none is near.
std::int32_t CellGrid::sideFor(const Vec3& ws) const {
    const Vec3 cs = csFromWs(ws);
    std::vector<std::tuple<double, std::int32_t, Int3>> all;
    for (int i = 0; i < 27; ++i) {
        const Int3 at = Int3(glm::floor(cs)) + Int3(i % 3, i / 3 % 3, i / 9) - 1;
        const std::ptrdiff_t cell = index(at);
        const std::int32_t block = cell < 0 ? -1 : m_walled[std::size_t(cell) / kBlockCells];
        for (int face = 0; block >= 0 && face < 6; ++face)
            if (const std::int32_t side = sidesAt(block, face)[std::size_t(cell) % kBlockCells]; side >= 0) {
                const Vec3 centre = Vec3(at) + 0.5 + (face % 2 == 1 ? 0.5 : -0.5) * Vec3(along(face / 2));
                all.emplace_back(glm::distance(cs, centre), side, at);
            }
    }
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return get<0>(a) < get<0>(b); });
    for (const auto& [distance, side, at] : all)
        if (sees(ws, wsInside(at))) return side;
    return -1;
}

// The surface, in faces, of the walls that each side stands for: every piece of a wall counts for the nearest side that
// sees it. Lines along the axes meet the pieces, each of them those that face its axis most.
std::vector<double> CellGrid::areasOfSides() const {
    constexpr int kLines = 4;  // through a cell along each axis
    const std::vector<bool> near = nearWalls();
    std::vector<std::vector<std::pair<std::int32_t, double>>> found(m_places.size());
    parallelFor(m_places.size(), [&](std::size_t b) {
        for (int i = 0; i < 3 * kLines * kBlockCells; ++i) {
            const std::size_t cell = b * kBlockCells + std::size_t(i / (3 * kLines));
            const int axis = i / kLines % 3;
            if (!near[cell]) continue;
            const Vec3 way = m_edge * Vec3(along(axis));
            const Vec3 from =  // a quarter of an edge from the middle
                wsInside(place(cell)) + 2 * m_edge * across(axis, 1 + i % 2, 1 + i / 2 % 2) - 0.5 * way;
            for (double t = 0; t < 1; t += 1e-4) {
                const SolidHit hit = m_solids->trace(SolidRole::shadow, from, way, t, 1);
                t = hit.t;
                if (t > 1) break;
                const Vec3 normal = glm::normalize(hit.wsNormal), facing = glm::abs(normal);
                // At 45 degrees two axes face the wall alike; one of them counts it.
                if (axisOfLargest(facing) != axis) continue;
                for (const double beside : {0.01, -0.01})
                    if (const std::int32_t side = sideFor(from + t * way + beside * m_edge * normal); side >= 0)
                        found[b].emplace_back(side, 1 / (kLines * facing[axis]));
            }
        }
    });
    std::vector<double> areas(m_sides.size(), 0.0);
    for (const auto& ofBlock : found)
        for (const auto& [side, area] : ofBlock) areas[std::size_t(side)] += area;
    return areas;
}

std::vector<std::pair<Vec3, Vec3>> CellGrid::pointsOfSide(std::size_t side) const {
    std::vector<std::pair<Vec3, Vec3>> points;
    const auto hits = hitsOfFace(place(m_sides[side] / 6), static_cast<int>(m_sides[side] % 6));
    for (const auto& [ws, hit] : hits)
        points.emplace_back(ws, hit.wsNormal / (stairs(hit.wsNormal) * double(hits.size())));
    return points;
}

unsigned CellGrid::onSideOf(const Vec3& ws, std::size_t block, const Int3& low) const {
    const std::int32_t walled = m_walled[block];
    if (walled < 0) return kAllSides;
    std::array<unsigned, 8> beside{};
    bool all = true;
    for (int axis = 0; axis < 3; ++axis)
        for (int corner = 0; corner < 8; ++corner) {
            if ((corner >> axis & 1) != 0) continue;
            const int other = corner | 1 << axis;
            const Int3 upper = low + cornerOf(other);
            if (open(walled, axis)[paddedOffset(upper.x, upper.y, upper.z)] == 0) {
                all = false;
                continue;
            }
            beside[std::size_t(corner)] |= 1U << other;
            beside[std::size_t(other)] |= 1U << corner;
        }
    if (all) return kAllSides;
    // The closest cell that is seen from there, and those that light reaches from it.
    const Int3 first = m_places[block] * kCellEdge - 1 + low;
    std::array<std::pair<double, int>, 8> order;
    for (int corner = 0; corner < 8; ++corner)
        order[std::size_t(corner)] = {glm::distance(ws, wsInside(first + cornerOf(corner))), corner};
    std::sort(order.begin(), order.end());
    for (const auto& [distance, corner] : order) {
        if (!sees(ws, wsInside(first + cornerOf(corner)))) continue;
        unsigned reached = 1U << corner;
        for (unsigned before = 0; before != reached;) {
            before = reached;
            for (std::size_t c = 0; c < 8; ++c)
                if ((reached >> c & 1) != 0) reached |= beside[c];
        }
        return reached;
    }
    return kAllSides;
}

std::vector<Real> CellGrid::means(const std::vector<Real>& row, const CellGrid& coarse) const {
    std::vector<Real> out(coarse.cells(), Real(0));
    // A block of the finer grid is an octant of a block of the coarser one.
    const Int3 shift(glm::round(coarse.csFromWs(wsFromCs(Vec3(0)))));
    for (std::size_t b = 0; b < storedBlocks().size(); ++b) {
        const Int3 first = shift + storedBlocks()[b] * (kCellEdge / 2);
        const auto base = std::size_t(coarse.index(first));
        for (int i = 0; i < kBlockCells; ++i) {
            const int x = i % kCellEdge, y = i / kCellEdge % kCellEdge, z = i / (kCellEdge * kCellEdge);
            out[base + std::size_t(cellOffset(x / 2, y / 2, z / 2))] += row[b * kBlockCells + std::size_t(i)] / 8;
        }
    }
    return out;
}

std::size_t CellGrid::bytes() const {
    return m_stored.size() * sizeof(std::int32_t) + m_places.size() * sizeof(Int3) +
           (m_walled.size() + m_sideAt.size()) * sizeof(std::int32_t) + m_open.size() +
           m_sides.size() * (sizeof(std::size_t) + 2 * sizeof(Rgb));
}

}  // namespace scrim
