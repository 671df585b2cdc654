// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/solve/scatter_domains.h>

#include <scrim/engine/cells/cell_levels.h>
#include <scrim/engine/solve/border_light.h>
#include <scrim/scene/optics.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <glm/common.hpp>

namespace scrim {
namespace {

// Voxels that are less than so many times larger than the finest of a level belong to it. In ten plumes of 0.5 to 1.2
// times the size the solve took 40 s with 3, which made it one of all, and 10 s with 2.
constexpr double kAlike = 2;
// Volumes of a level share a domain if the box around them is no larger than this, relative to both.
constexpr double kTogether = 1.2;
// Larger voxels that lie between the blocks of smaller ones are part of their domain from this
// optical depth over the domain on, unless its box has this many times the cells of the blocks.
// Without them, in haze of a depth of 0.7 over smoke, 0.05 % of the light under a sun was lost and
// 0.3 % under a sky; with them, the cells take up to four times as long.
constexpr double kHaze = 0.25, kMostFilled = 8;

double sizeOf(const Bounds& box) {
    const Vec3 size = box.size();
    return size.x * size.y * size.z;
}

// Volumes of a level that lie together.
struct Cluster {
    Bounds box;
    std::vector<bool> volumes;
};

std::vector<Cluster> clusters(const std::vector<std::size_t>& level, const std::vector<Bounds>& boxes) {
    std::vector<Cluster> all;
    for (const std::size_t v : level) {
        Cluster& own = all.emplace_back(Cluster{boxes[v], std::vector<bool>(boxes.size(), false)});
        own.volumes[v] = true;
        for (std::size_t i = 0; i + 1 < all.size();) {
            Bounds both = all.back().box;
            both.include(all[i].box);
            if (sizeOf(both) > kTogether * (sizeOf(all.back().box) + sizeOf(all[i].box))) {
                ++i;
                continue;
            }
            all.back().box = both;
            for (std::size_t k = 0; k < boxes.size(); ++k)
                all.back().volumes[k] = all.back().volumes[k] || all[i].volumes[k];
            all.erase(all.begin() + std::ptrdiff_t(i));
            i = 0;
        }
    }
    return all;
}

// Takes `part` out of `media`, on the same grid, in the cells that `box` meets.
void takeOut(const CellMedia& part, const Bounds& box, CellMedia& media) {
    constexpr Real kRest = Real(1e-5);  // less is what rounding leaves
    const CellGrid& grid = media.grid;
    const auto rows = [&](std::vector<std::vector<Real>>& from, const std::vector<std::vector<Real>>& less,
                          std::size_t cell) {
        for (std::size_t c = 0; c < std::min(from.size(), less.size()); ++c) {
            const Real left = from[c][cell] - less[c][cell];
            from[c][cell] = left > kRest * from[c][cell] ? left : Real(0);
        }
    };
    for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
        const Vec3 lower = grid.wsFromCs(Vec3(grid.place(cell)));
        if (!overlap({lower, lower + grid.edge()}, box)) continue;
        rows(media.extinction, part.extinction, cell);
        rows(media.straight, part.straight, cell);
        rows(media.emission, part.emission, cell);
        for (std::size_t k = 0; k < media.scattering.size(); ++k) rows(media.scattering[k], part.scattering[k], cell);
    }
}

Bounds boxOf(const ViewScene& scene, const ScatterDomain& domain, double margin) {
    Bounds box;
    for (const Bounds& own : cellBoxes(withVoxelsOf(scene, domain.volumes), margin)) box.include(own);
    return box;
}

bool any(const std::vector<bool>& volumes) {
    return std::ranges::find(volumes, true) != volumes.end();
}

}  // namespace

std::vector<ScatterDomain> wholeScene(const ViewScene& scene, double cell) {
    const std::vector<bool> all(scene.volumes.size(), true), none(all.size(), false);
    return {{all, all, none, cell * voxelUnit(scene), -1, false}};
}

std::vector<ScatterDomain> scatterDomains(const ViewScene& scene, double cell) {
    const std::size_t count = scene.volumes.size();
    std::vector<double> voxels;
    std::vector<Bounds> boxes;  // with the blocks' margin of a cell
    std::vector<std::size_t> order;
    for (std::size_t v = 0; v < count; ++v) {
        voxels.push_back(voxelUnit(scene.volumes[v]));
        Bounds& box = boxes.emplace_back();
        for (const ViewField& field : fieldsOf(scene.volumes[v]))
            if (!field.field->empty()) box.include(transformed(field.wsFromIs, field.field->isBounds()));
        if (box.empty()) continue;
        box.lower -= 0.5 * voxels[v] + cell * voxels[v];
        box.upper += 0.5 * voxels[v] + cell * voxels[v];
        order.push_back(v);
    }
    std::ranges::stable_sort(order, std::greater(), [&](std::size_t v) { return voxels[v]; });
    // Levels by voxels, from the finest on, so that the scene's finest voxel is as fine as without levels.
    std::vector<std::vector<std::size_t>> levels;
    for (auto v = order.rbegin(); v != order.rend(); ++v) {
        if (levels.empty() || voxels[*v] >= kAlike * voxels[levels.back().front()]) levels.emplace_back();
        levels.back().push_back(*v);
    }
    std::ranges::reverse(levels);
    const std::vector<bool> all(count, true), none(count, false);
    if (levels.size() < 2 || solidsBlock(scene)) return wholeScene(scene, cell);
    std::vector<ScatterDomain> domains{{none, all, none, cell * voxels[levels.front().front()], -1, false}};
    for (const std::size_t v : levels.front()) domains.front().volumes[v] = true;
    std::vector<Bounds> domainBoxes{{}};
    std::vector<bool> coarser = domains.front().volumes;
    for (std::size_t l = 1; l < levels.size(); ++l) {
        const std::size_t before = domains.size();
        for (Cluster& cluster : clusters(levels[l], boxes)) {
            double finest = std::numeric_limits<double>::infinity();
            ScatterDomain domain{cluster.volumes, none, none, 0, 0, false};
            double blocks = 0, depth = 0;
            for (std::size_t v = 0; v < count; ++v) {
                if (cluster.volumes[v]) finest = std::min(finest, voxels[v]);
                if (boxes[v].empty() || !overlap(boxes[v], cluster.box)) continue;
                (coarser[v] ? domain.larger : domain.held)[v] = true;
                if (coarser[v])
                    depth += mostDepth(scene.volumes[v], largest(cluster.box.size()));
                else if (cluster.volumes[v])
                    for (const ViewField& field : fieldsOf(scene.volumes[v]))
                        blocks += double(field.field->blockCount()) * std::pow(kBlockEdge * voxels[v], 3);
            }
            domain.edge = cell * finest;
            domain.filled = depth > kHaze && sizeOf(cluster.box) < kMostFilled * std::max(blocks, 1e-300);
            for (std::size_t d = 1; d < before; ++d)
                if (domainBoxes[d].contains(cluster.box.lower) && domainBoxes[d].contains(cluster.box.upper))
                    domain.parent = static_cast<int>(d);
            domains.push_back(std::move(domain));
            domainBoxes.push_back(cluster.box);
        }
        for (const std::size_t v : levels[l]) coarser[v] = true;
    }
    return domains;
}

DomainMedia::DomainMedia(const ViewScene& scene, const std::vector<ScatterDomain>& domains,
                         const std::vector<ScatterClass>& classes, Simd simd)
    : m_scene(scene), m_domains(domains), m_classes(classes), m_simd(simd) {}

CellMedia DomainMedia::of(std::size_t d, double larger) const {
    return of(d, larger, std::vector<bool>(m_scene.volumes.size(), true));
}

CellPlaces DomainMedia::placesOf(std::size_t d, double edge) const {
    const ScatterDomain& domain = m_domains[d];
    CellPlaces places{.walls = true};
    // Light is looked up between cells, as far as kernels reach.
    const double reach = reachOfWideKernels(domain.parent < 0 ? m_scene : withVoxelsOf(m_scene, domain.volumes));
    if (reach > 0) places.margin = reach + edge;
    if (domain.parent < 0) return places;
    places.covered = domain.volumes;
    if (domain.filled) places.more = {boxOf(m_scene, domain, edge)};
    return places;
}

CellGrid DomainMedia::gridOf(std::size_t d, double larger) const {
    const double edge = larger * m_domains[d].edge;
    return cellGrid(m_scene, edge, placesOf(d, edge));
}

CellMedia DomainMedia::of(std::size_t d, double larger, const std::vector<bool>& volumes) const {
    const ScatterDomain& domain = m_domains[d];
    const double edge = larger * domain.edge;
    CellPlaces places = placesOf(d, edge);
    places.dense = both(domain.held, volumes);
    CellMedia media = cellMedia(m_scene, m_classes, edge, m_simd, places);
    if (const std::vector<bool> coarser = both(domain.larger, volumes); any(coarser))
        addLarger(media, of(std::size_t(domain.parent), 1, coarser));
    return media;
}

CellMedia DomainMedia::around(std::size_t d, const CellMedia& around) const {
    const ScatterDomain& domain = m_domains[d];
    CellMedia out = around;
    takeOut(of(std::size_t(domain.parent), 1, domain.held), boxOf(m_scene, domain, domain.edge), out);
    return out;
}

}  // namespace scrim
