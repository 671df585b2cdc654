// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/cells/cell_levels.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>
#include <utility>

#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>

namespace scrim {
namespace {

// Adds the volumes of one list to another.
void add(const std::vector<bool>& some, std::vector<bool>& to) {
    for (std::size_t v = 0; v < to.size(); ++v) to[v] = to[v] || some[v];
}

// True if cells of the edge `small` for all of these cost far more than those of `large` for what they are for.
bool costsMoreTogether(const ViewScene& scene, const std::vector<bool>& ofLarge, double large,
                       const std::vector<bool>& ofSmall, double small) {
    constexpr double kMore = 4;
    const double coarse = occupied(withVoxelsOf(scene, ofLarge), 0),
                 fine = occupied(withVoxelsOf(scene, ofSmall), 0) / std::pow(small, 3);
    return coarse / std::pow(small, 3) + fine > kMore * (coarse / std::pow(large, 3) + fine);
}

}  // namespace

std::vector<std::vector<bool>> cellLevels(const ViewScene& scene,
                                          const std::function<double(const ViewScene&)>& edgeFor) {
    // Cells that are up to so many times smaller than need be may cost less than a level of their own: in ten plumes of
    // 0.5 to 1.5 times the size, of which some need cells twice as small, two levels take 1.1 times as long as one. But
    // haze around a plume, whose cells may be 2.9 times as large, took 10 times as long.
    constexpr double kAlike = 3;
    std::map<std::pair<bool, int>, std::vector<bool>> byVoxel;  // surfaces or not, octave
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        const ViewVolume& volume = scene.volumes[v];
        if (volume.field->empty()) continue;
        const int octave = static_cast<int>(std::floor(std::log2(voxelUnit(volume) / voxelUnit(scene)) + 1e-9));
        std::vector<bool>& level = byVoxel[{volume.classified != nullptr, octave}];
        level.resize(scene.volumes.size(), false);
        level[v] = true;
    }
    std::map<std::tuple<bool, double, int>, std::vector<bool>> byEdge;  // ascending with smaller cells
    for (auto& [kind, volumes] : byVoxel) {
        const double edge = byVoxel.size() > 1 ? edgeFor(withVoxelsOf(scene, volumes)) : 0;
        byEdge[{kind.first, -edge, kind.second}] = std::move(volumes);
    }
    std::vector<std::vector<bool>> levels;
    std::tuple<bool, double, int> first;
    for (const auto& [kind, volumes] : byEdge) {
        if (levels.empty() || std::get<bool>(kind) != std::get<bool>(first) ||
            std::get<double>(first) < kAlike * std::get<double>(kind) ||
            costsMoreTogether(scene, levels.back(), -std::get<double>(first), volumes, -std::get<double>(kind))) {
            levels.push_back(volumes);
            first = kind;
        } else {
            add(volumes, levels.back());
        }
    }
    return levels;
}

namespace {

Bounds wsBoxOf(const ViewScene& scene, std::size_t volume) {
    Bounds ws;
    for (const Vec3& corner : wsCorners(scene.volumes[volume], scene.dials.kernel)) ws.include(corner);
    return ws;
}

double widthOf(const Bounds& box) {
    return glm::length(box.size());
}

double between(const Bounds& a, const Bounds& b) {
    return glm::length(glm::max(glm::max(a.lower - b.upper, b.lower - a.upper), Vec3(0)));
}

}  // namespace

std::vector<std::vector<bool>> farApart(const ViewScene& scene, const std::vector<bool>& volumes, double sizes) {
    constexpr std::size_t kMost = 64;
    struct Group {
        Bounds box;
        std::vector<bool> volumes;
    };
    std::vector<Group> groups;
    for (std::size_t v = 0; v < volumes.size(); ++v) {
        if (!volumes[v]) continue;
        if (groups.size() == kMost) return {volumes};
        Group& own = groups.emplace_back(Group{wsBoxOf(scene, v), std::vector<bool>(volumes.size(), false)});
        own.volumes[v] = true;
    }
    const auto near = [&](const Group& a, const Group& b) {
        return between(a.box, b.box) < sizes * std::max(widthOf(a.box), widthOf(b.box));
    };
    for (std::size_t i = 0; i < groups.size();) {
        const auto other = std::find_if(groups.begin() + std::ptrdiff_t(i) + 1, groups.end(),
                                        [&](const Group& g) { return near(groups[i], g); });
        if (other == groups.end()) {
            ++i;
            continue;
        }
        groups[i].box.include(other->box);
        add(other->volumes, groups[i].volumes);
        groups.erase(other);
        i = 0;  // it has grown, and may have come near to one before it
    }
    std::vector<std::vector<bool>> out;
    for (Group& group : groups) out.push_back(std::move(group.volumes));
    return out;
}

std::vector<bool> around(const ViewScene& scene, const std::vector<bool>& group, double sizes,
                         const std::vector<Vec3>& lamps) {
    Bounds own;
    for (std::size_t v = 0; v < group.size(); ++v)
        if (group[v]) own.include(wsBoxOf(scene, v));
    std::vector<bool> out(group.size(), false);
    for (std::size_t v = 0; v < group.size(); ++v) {
        if (scene.volumes[v].field->empty()) continue;
        const Bounds box = wsBoxOf(scene, v);
        out[v] = between(own, box) < sizes * widthOf(box);
        for (const Vec3& lamp : lamps) {
            Bounds way = own;
            way.include(lamp);
            out[v] = out[v] || overlap(way, box);
        }
    }
    return out;
}

std::vector<bool> both(std::vector<bool> a, const std::vector<bool>& b) {
    for (std::size_t v = 0; v < a.size(); ++v) a[v] = a[v] && b[v];
    return a;
}

bool overlap(const Bounds& a, const Bounds& b) {
    return glm::all(glm::lessThanEqual(a.lower, b.upper)) && glm::all(glm::lessThanEqual(b.lower, a.upper));
}

bool hasSurfaces(const ViewScene& scene) {
    return std::ranges::any_of(scene.volumes, [](const ViewVolume& v) { return v.classified && !v.field->empty(); });
}

ViewScene withVoxelsOf(const ViewScene& scene, const std::vector<bool>& volumes) {
    static const auto kEmpty = std::make_shared<const SparseField>();
    ViewScene out = scene;
    for (std::size_t v = 0; v < out.volumes.size(); ++v) {
        if (volumes[v]) continue;
        out.volumes[v].field = kEmpty;
        out.volumes[v].emission.clear();
        out.volumes[v].scatter.clear();
    }
    return out;
}

double occupied(const ViewScene& scene, double margin) {
    double sum = 0;
    for (const ViewVolume& volume : scene.volumes) {
        const SparseField& field = *volume.field;
        const double edge = std::cbrt(std::abs(glm::determinant(Mat3(volume.wsFromIs))));
        const auto ofCube = [&](double voxels) { return std::pow(voxels * edge + 2 * margin, 3); };
        sum += double(field.blockCount()) * ofCube(kBlockEdge);
        for (const ConstantTile& tile : field.tiles) sum += ofCube(tile.edge);
    }
    return sum;
}

LevelScene::LevelScene(const ViewScene& scene, const CellLightPlan& plan, std::size_t level) : LevelScene(scene) {
    features = plan.levels[level].features;
    if (plan.levels.size() == 1) return;
    const std::vector<bool>& near = plan.levels[level].around;
    const auto around = [&](const std::vector<bool>& volumes) { return near.empty() ? volumes : both(volumes, near); };
    own = withVoxelsOf(scene, plan.levels[level].volumes);
    std::vector<bool> finer(scene.volumes.size(), false);
    for (std::size_t l = level; l < plan.levels.size(); ++l) add(plan.levels[l].volumes, finer);
    holding = withVoxelsOf(scene, around(finer));
    for (std::size_t l = 0; l < level; ++l) {
        const std::vector<bool> volumes = around(plan.levels[l].volumes);
        if (std::ranges::find(volumes, true) == volumes.end()) continue;
        coarser.push_back(
            {withVoxelsOf(scene, volumes), std::max(plan.levels[l].smallest(), plan.levels[level].smallest())});
    }
}

}  // namespace scrim
