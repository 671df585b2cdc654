// SPDX-License-Identifier: Apache-2.0
// Which volumes have their light kept on cells of like size. One size for all would have cells as
// small as the smallest voxels need all over the largest volume. So volumes that can do with much
// larger cells have these, and surfaces have cells apart from those of media.
//
// Light that reaches the cells of a level has passed the volumes of all levels. Those of finer ones are averaged into
// the level's own cells. Those of coarser ones are on cells of their edge, through which each source of light passes
// first; what they leave of it is interpolated, and is a factor.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/geometry/bounds.h>
#include <scrim/scene/view_scene.h>

#include <cstddef>
#include <functional>
#include <vector>

namespace scrim {

/// For each level, for each of ViewScene::volumes, whether its cells are for that volume: media before surfaces, those
/// with larger cells first. Volumes without voxels are in none, all others in one. `edgeFor`: the edge of the smallest
/// cells that a scene needs, world units; it is asked for volumes of like voxels, unless all are.
std::vector<std::vector<bool>> cellLevels(const ViewScene& scene,
                                          const std::function<double(const ViewScene&)>& edgeFor);

/// The volumes of a level in groups with empty space between them, each for cells of its own, since cells between them
/// would be many: groups are `sizes` times as far from each other as the larger one is wide. One group where volumes
/// are nearer, or many.
std::vector<std::vector<bool>> farApart(const ViewScene& scene, const std::vector<bool>& volumes, double sizes);

/// Those of all volumes that may hold back light which `group` gets: the others are as far away as that, so hide next
/// to nothing of a sky, and are not between the group and any of the `lamps`, world space.
std::vector<bool> around(const ViewScene& scene, const std::vector<bool>& group, double sizes,
                         const std::vector<Vec3>& lamps);

/// Those volumes that are in both lists: for each volume of a scene.
std::vector<bool> both(std::vector<bool> a, const std::vector<bool>& b);

/// True if the boxes have a point in common.
bool overlap(const Bounds& a, const Bounds& b);

/// True if a classified volume has voxels.
bool hasSurfaces(const ViewScene& scene);

/// The scene without the voxels of all other volumes.
ViewScene withVoxelsOf(const ViewScene& scene, const std::vector<bool>& volumes);

/// World volume of all blocks of fields, each with `margin` world units around it; where several overlap, each counts.
double occupied(const ViewScene& scene, double margin);

/// The scene as the cells of one level see it.
struct LevelScene {
    struct Coarser {
        ViewScene scene;  ///< the volumes of one of the coarser levels
        double edge = 0;  ///< of the cells that these are on, world units
    };
    ViewScene all;
    ViewScene own;      ///< the volumes whose light the cells keep
    ViewScene holding;  ///< these, and all of finer levels
    std::vector<Coarser> coarser;
    double features = 0;  ///< CellLevel::features

    /// All volumes are on one level.
    LevelScene(const ViewScene& scene) : all(scene), own(scene), holding(scene) {}
    LevelScene(const ViewScene& scene, const CellLightPlan& plan, std::size_t level);
};

}  // namespace scrim
