// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/transport_plan.h>

#include <scrim/base/error.h>
#include <scrim/scene/picture_cells.h>
#include <scrim/engine/plan/culling.h>
#include <scrim/engine/plan/light_groups.h>
#include <scrim/engine/lamps/area_shine.h>
#include <scrim/engine/lamps/lamp.h>
#include <scrim/engine/light/backdrop.h>
#include <scrim/engine/cells/cell_levels.h>
#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/passes/light_jobs.h>
#include <scrim/engine/solve/cell_sweep.h>
#include <scrim/engine/solve/last_sweep.h>
#include <scrim/engine/solve/first_light.h>
#include <scrim/engine/solve/scatter_domains.h>
#include <scrim/scene/optics.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

bool black(const Rgb& v) {
    return v == Rgb(0);
}

// All sources of light, by the layer that they belong to.
std::vector<ScatterTarget> targetsOf(const ViewScene& scene) {
    std::vector<ScatterTarget> targets;
    ScatterTarget beauty;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        if (black(scene.lights[i].intensity)) continue;
        if (!wants(scene, Layer::light)) {
            beauty.lights.push_back(static_cast<int>(i));
            continue;
        }
        const Output output{Layer::light, lightOfLayer(scene, static_cast<int>(i))};
        const auto known = std::find_if(targets.begin(), targets.end(),
                                        [&](const ScatterTarget& target) { return target.output == output; });
        if (known == targets.end())
            targets.push_back({output, {static_cast<int>(i)}});
        else
            known->lights.push_back(static_cast<int>(i));
    }
    if (!black(scene.ambient)) {
        if (wants(scene, Layer::ambient))
            targets.push_back({Output{Layer::ambient}, {}, true});
        else
            beauty.ambient = true;
    }
    if (anyEmits(scene)) {
        if (wants(scene, Layer::emission))
            targets.push_back({Output{Layer::emission}, {}, false, true});
        else
            beauty.emission = true;
    }
    if (!beauty.lights.empty() || beauty.ambient || beauty.emission) targets.push_back(beauty);
    return targets;
}

// True if all light and all scattering have the same colour.
bool oneColour(const ViewScene& scene) {
    if (!greyScattering(scene)) return false;
    Rgb colour(0);  // colour of the first light
    const auto same = [&](const Rgb& light) {
        if (black(colour)) colour = light;
        return sameColour(colour, light);
    };
    for (const Light& light : scene.lights)
        if (light.slide || !same(light.intensity)) return false;
    for (const ViewVolume& v : scene.volumes)
        for (const ViewEmission& e : v.emission)
            if (!same(e.color)) return false;
    return greySolids(scene) && same(scene.ambient);
}

// True if solids send scattered light back into the volumes.
bool wallsSendBack(const ViewScene& scene) {
    return scene.solids && scene.solids->anySendsBack();
}

// The number of ordinates, by the narrowest phase function. The largest differences to 1,024
// ordinates, of a cloud lit from the eye's side, from aside and from behind: for g = 0.75, 1.6, 1.2
// and 0.9 % with 64, 128 and 256 ordinates; for g = 0.9, 8.9, 4.1 and 2.3 %.
int ordinatesFor(const ViewScene& scene) {
    double narrowest = 0;
    for (const ViewVolume& v : scene.volumes) {
        if (!scattersFully(v) || v.medium.phase.type == PhaseType::rayleigh) continue;
        narrowest = std::max(narrowest, std::abs(v.medium.phase.g));
        if (v.medium.phase.type == PhaseType::twoLobe) narrowest = std::max(narrowest, std::abs(v.medium.phase.g2));
    }
    // A spot of light on a wall is small. In a room of haze with a window, and walls of albedo 0.8,
    // the error is 1.8 % with 64 and 0.7 % with 128 or 256; with black walls 0.4 and 0.2 %.
    return narrowest <= 0.7 && !wallsSendBack(scene) ? 64 : narrowest <= 0.8 ? 128 : 256;
}

// For each light of the scene whether any of its sub-lights lights something that is seen.
std::vector<bool> lightsInView(const ViewScene& scene) {
    const SubLights all = subLights(scene);
    const std::vector<std::string> reasons = culledLights(scene, all);
    std::vector<bool> seen(scene.lights.size(), false);
    for (std::size_t i = 0; i < reasons.size(); ++i)
        if (reasons[i].empty()) seen[std::size_t(all.owners[i])] = true;
    return seen;
}

// The number of sets of volumes and solids that cast shadows in these lights; with `media`, of
// those that cells need media for: all volumes, and each set of them that holds light back.
std::size_t castingSets(const ViewScene& scene, const std::vector<int>& lights, bool media) {
    std::set<std::pair<std::vector<bool>, bool>> sets;
    for (const int i : lights)
        if (!media || isHeldBack(scene, std::size_t(i)))
            sets.emplace(castersIn(scene, std::size_t(i)), !media && isBlocked(scene, std::size_t(i)));
    if (media) sets.emplace(withVoxels(scene), false);
    return sets.size();
}

constexpr double kDepth = 0.3;        // optical depth of a cell that is as good as a thin one
constexpr double kFinestCell = 0.25;  // edge, voxels

// True if a light is so close to the volumes, or among them, that one view cannot hold them.
bool isAmong(const Light& light, const std::vector<Vec3>& wsCorners) {
    std::vector<Vec3> directions;
    return coneToCorners(light.wsPosition, wsCorners, directions).cosAngle <= std::cos(kWidestView);
}

// The error of wide light that surfaces keep on cells of this edge (voxels), relative to their light, at the most. By
// their densest voxels: an optical depth of 0.5, 1.5 and 4 left 0.36, 0.6 and 1.6 % of smooth balls with cells of half
// a voxel, and 0.2, 0.4 and 0.8 % with a third. A scan whose values differ from voxel to voxel has more: of the teddy
// bear, 2.8 a voxel, 2.5, 1.3 and 0.8 % with a half, a third and a quarter.
double errorOfSurfaces(const ViewScene& scene, double edge) {
    double depth = 0;
    for (const ViewVolume& v : scene.volumes)
        if (v.classified && !v.field->empty()) depth = std::max(depth, mostDepth(v, voxelUnit(scene)));
    return 0.009 * depth * std::pow(2 * edge, 1.8);
}

// The same scene without its media.
ViewScene surfacesOf(const ViewScene& scene) {
    std::vector<bool> volumes;
    for (const ViewVolume& v : scene.volumes) volumes.push_back(v.classified != nullptr);
    return withVoxelsOf(scene, volumes);
}

// True if that is within what sub-lights may have, and the rest of light.
bool surfacesFit(const ViewScene& scene, double edge) {
    constexpr double kOfLight = 1.6;  // of light_error
    return errorOfSurfaces(scene, edge) <= kOfLight * scene.dials.lightError;
}

// The edge of cells for surfaces, voxels: the largest that fits, else the smallest.
double surfaceCell(const ViewScene& scene) {
    for (const double edge : {0.5, 1.0 / 3})
        if (surfacesFit(scene, edge)) return edge;
    return kFinestCell;
}

// The least number of sub-lights that cells are better for. A light of few points or directions has shadows that are
// sharper than cells. Measured on solid shapes, a hypertexture, a ball of noise and a cloud of 0.4 to 2.5 per voxel,
// beside spheres, disks and rectangles of 4 to 26 sub-lights: 0.3 to 0.7 % on cells, 0.1 to 0.4 % in buffers, which
// took from a third (4 sub-lights, few voxels, 256 x 256 pixels) to 15 times the time of cells (15, a large cloud, 960
// x 540). Buffers take as long as the picture is large, cells do not. Cells are too large for the rims of what is
// opaque: 1.5 and 3.8 % of shapes of 5 and 20 per voxel.
int leastForCells(const ViewScene& scene, const Light& light, const std::vector<Vec3>& wsCorners) {
    constexpr int kMany = 4, kManyAtEdges = 16, kManyBesideSolid = 64;
    // Points among surfaces need windows of directions, each with a sweep: 12 of a sphere in a scan had 300 buffers.
    if (hasSurfaces(scene)) return isAmong(light, wsCorners) ? kMany : kManyAtEdges;
    constexpr double kSolid = 3, kMostRays = 1e6;  // optical depth of a voxel; pixels times sub-lights
    double depth = 0;                              // of one volume: what overlaps has no sharper edges
    for (const ViewVolume& v : scene.volumes)
        if (!v.field->empty()) depth = std::max(depth, mostDepth(v, voxelUnit(v)));
    if (depth <= kDepth) return kMany;
    const double pixels = double(scene.camera.resolution.x) * scene.camera.resolution.y;
    if (depth <= kSolid) return std::max(kMany, static_cast<int>(std::min(kMostRays / pixels, 1.0 * kManyAtEdges)));
    const bool beside = light.area() && !isLampOnCells(scene, light) && !isAmong(light, wsCorners);
    return beside ? kManyBesideSolid : kManyAtEdges;
}

// Whether a light is better kept on cells, or is told to be. `surfacesFit`: cells are exact enough for all surfaces.
bool fitsCells(const ViewScene& scene, const Light& light, const std::vector<Vec3>& wsCorners, bool surfacesFit) {
    if (black(light.intensity) || light.shadow == ShadowMethod::buffers) return false;
    // Each direction of an unshadowed sky would need a sweep along an axis of its own.
    if (!light.shadows && !light.dome() && !isLampOnCells(scene, light)) return false;
    if (comesByBorder(scene, std::size_t(&light - scene.lights.data()))) return false;
    const bool forced = light.shadow == ShadowMethod::cells;
    if (!surfacesFit && !forced) return false;
    if (shinesInBeams(scene, light)) return false;
    // Among volumes cells do not resolve narrow beams, which shadow buffers see along the eye's path: in haze a square
    // of 1.2 voxels with a spread of 20 degrees was 94 % off on cells, 3 % by buffers.
    constexpr double kNarrowSpread = 60;
    if (light.area() && light.area()->spread <= kNarrowSpread && !forced && isAmong(light, wsCorners)) return false;
    if (light.area() || light.dome())
        return forced || subLightCount(scene, light) >= leastForCells(scene, light, wsCorners);
    if (light.distant()) return forced && light.extended();
    // A lamp in the smoke would need windows of directions with a sweep each, even one that casts no shadows.
    if (light.spot() || light.slide) return false;
    if (light.luminaire && !forced && beamOf(light).angle <= kWidestView) return false;
    return forced || isAmong(light, wsCorners);
}

constexpr double kMostAlong = 256, kMostWithEmpty = 1024;  // cells, see lightCell
constexpr double kFeatures = 1.0 / 120;                    // of what is occupied: the size of what is there

// The length of what is occupied, voxels, or a part of that of the box around it.
double longestOf(const ViewScene& scene) {
    const double all = largest(wsBounds(scene).size()), own = largest(wsOccupiedSize(scene));
    return std::max(own, all * kMostAlong / kMostWithEmpty) / voxelUnit(scene);
}

// The edge of cells in voxels: as large as a cell is thin, and as features are large, for which the size of the volumes
// stands, or for parts that are far apart the sum of their sizes; but no more than kMostAlong cells along them, and
// kMostWithEmpty along the box around all, which passes must cross. Only whole parts of a voxel have cells where the
// field's values are. Measured with cells of 1, 0.7, 0.5 and 0.25 voxels: on shapes of 64 voxels with an optical depth
// of 0.78 per voxel under a dome, 2.0, 4.2, 1.3 and 1.1 %; on a cloud of 58 voxels and 0.33 per voxel, 1.0, 2.1, 0.7
// and 0.6 %; on a slab of 24 voxels and 0.33 per voxel, with a soft box and a lamp in it, 2.5, 2.0, 0.8 and 0.6 %. On a
// plume of 366 voxels and 0.11 per voxel, with cells of 1, 1.4, 2 and 3 voxels: 0.7, 0.7, 0.8 and 1.1 % for a dome,
// 0.7, 0.8, 1.1 and 1.4 % for a soft box. A cloud of 0.29 per voxel has sharp rims: with a soft box and a lamp in it,
// cells of 1 and 0.5 voxels leave 2.5 and 0.6 %.
// `longest`: of longestOf.
double lightCell(const ViewScene& scene, const Light& light, double longest) {
    if (hasSurfaces(scene)) return surfaceCell(scene);
    constexpr double kFine = 0.004, kRims = 0.2;
    // The few points of a sphere are not to be told apart.
    const double features = std::max(kFeatures * longest, isLampOnCells(scene, light) ? 1 : 0.0);
    const double depth = depthOfVoxel(scene), thin = kDepth / depth * std::min(1.0, kRims / depth);
    const double wanted = std::max(std::min(thin, features), longest / kMostAlong);
    double edge = kFinestCell;
    for (const double step : {1.0 / 3, 0.5, 1.0, 2.0, 3.0, 4.0})
        if (step <= wanted) edge = step;
    if (scene.dials.lightError < kFine) edge = std::max(0.5 * edge, longest / (2 * kMostAlong));
    return edge * (light.area() && !isLampOnCells(scene, light) && edge > 1 ? 0.7 : 1);
}

}  // namespace

double depthOfVoxel(const ViewScene& scene) {
    const double voxel = voxelUnit(scene);
    std::vector<std::pair<Bounds, double>> parts;
    for (const ViewVolume& v : scene.volumes)
        if (!v.field->empty()) parts.emplace_back(transformed(v.wsFromIs, v.field->isBounds()), mostDepth(v, voxel));
    double most = 1e-9;
    for (const auto& [box, depth] : parts) {
        double sum = 0;
        for (const auto& [other, more] : parts) sum += overlap(box, other) ? more : 0;
        most = std::max(most, sum);
    }
    return most;
}

void nameLightsOnCells(const ViewScene& scene, const CellLightPlan& cells, const std::vector<ServedLight>& served,
                       std::vector<std::string>& reasons) {
    for (std::size_t i = 0; i < reasons.size(); ++i) {
        const Light& light = scene.lights[i];
        if (black(light.intensity)) continue;
        if (cells.has(i))
            reasons[i].clear();
        else if (!served[i].inSweeps && !reasons[i].empty())
            reasons[i] = "no sweep, because its light enters at the border of the cells that scatter it";
    }
}

namespace {

// Gives cells the edges that dials state, and all lights the same. Haze around smoke that may have
// larger cells may have had the largest that it should have.
void setByDials(const ViewScene& scene, CellLightPlan& plan) {
    const Dials& dials = scene.dials;
    const CellLevel& finest = plan.levels[finestLevel(plan)];
    const double planned = finest.smallest(), voxel = voxelUnit(withVoxelsOf(scene, finest.volumes));
    const double edge = dials.lightCell ? *dials.lightCell * voxel : planned;
    const double others = dials.lightCellOthers.value_or(std::min(edge / planned, 1.0));
    for (CellLevel& level : plan.levels)
        std::ranges::fill(level.edges, &level == &finest ? edge : std::max(others * level.smallest(), edge));
}

// Memory of the cells of the plan's lights on a level, which `scene` has alone.
double cellBytes(const ViewScene& scene, const CellLightPlan& plan, const CellLevel& level) {
    const double least = level.smallest();
    const Vec3 cells = wsBounds(scene).size() / least + 2.0 * kCellEdge;
    const double colours = oneColour(scene) ? 1 : 3;
    // Lights share fields unless layers, or what casts shadows in them, part them; lamps also have
    // fields of their own, and where solids block them another one.
    const double stored = 2 * occupied(scene, 0.5 * least) / (least * least * least);
    int octaves = 1;
    for (const ViewVolume& volume : scene.volumes) octaves = std::max(octaves, volume.medium.octaves.count);
    // Cells of further octaves may be larger (octaveCells); a lamp has two fields for them.
    const bool alike = solidsBlock(scene) || hasSurfaces(scene) || kLargerCells * least > level.features;
    const double further = octaves == 1 ? 0 : alike ? 1 : std::pow(kLargerCells, -3);
    double lamps = 0, near = 0;
    std::vector<int> apart;
    for (const int i : plan.lights) {
        const Light& light = scene.lights[std::size_t(i)];
        if (!isLampOnCells(scene, light)) {
            apart.push_back(i);
            continue;
        }
        lamps += 1 + 2 * further;
        near += (1 + 2 * further) * std::min(std::pow(2 * nearestFar(light, least) / least + kCellEdge, 3), stored);
    }
    // Parts of the light that have fields of their own.
    const double parts = further < 1 || wants(scene, Layer::indirect) ? 1 + further : 1;
    // What comes from points waits in fields of its own until it has come along all axes.
    const auto waiting =
        double(std::ranges::count_if(apart, [&](int i) { return scene.lights[std::size_t(i)].area() != nullptr; }));
    const double others = parts * (waiting + (wants(scene, Layer::light) ? double(apart.size())
                                                                         : double(castingSets(scene, apart, false))));
    const double media = double(castingSets(scene, plan.lights, true));
    const bool shared = lampsShareCells(scene);
    const double blocked = solidsBlock(scene) ? lamps : 0;
    const double fields = 2 * (colours * ((shared ? std::min(lamps, parts) : lamps) + others) + blocked);
    // Slices keep the used part of each row of the box, and where it begins.
    const double rows = std::max({cells.x * cells.y, cells.y * cells.z, cells.z * cells.x}), kept = 20 * rows;
    const double slices = std::min(cells.x * cells.y * cells.z, stored) * (1 + colours) + kept;
    // Values, and normals and a second part of what is reflected where the eye sees surfaces.
    const double surfaces = hasSurfaces(scene) ? 1.2 : 1;
    return surfaces * sizeof(Real) * (slices + stored * (fields + media) + (shared ? 2 * colours * near : 0));
}

// Small voxels in a large volume, and large scans, ask for cells that no memory holds. Larger ones blur shadows, and
// reflect less exactly (errorOfLargeCells); hundreds of shadow buffers would take hours. Of media, whose cells take
// time, too, a part of the memory is taken. `bytes`: those of each level, which `plan.bytes` becomes the sum of. If no
// memory holds the cells, the plan becomes one without lights.
void growCells(const ViewScene& scene, CellLightPlan& plan, std::vector<double>& bytes) {
    constexpr double kMostBytes = 4e9, kStep = 1.25992105, kOfMedia = 0.25, kMostOfMedia = 8, kMostOfSurfaces = 2;
    const double most = scene.memoryLimit > 0 ? 0.5 * double(scene.memoryLimit) : kMostBytes;
    const auto sum = [&] { return std::accumulate(bytes.begin(), bytes.end(), 0.0); };
    const double wanted = sum();
    for (bool grows = !scene.dials.lightCell && wanted > most; grows;) {
        const auto l = std::size_t(std::ranges::max_element(bytes) - bytes.begin());
        CellLevel& level = plan.levels[l];
        const ViewScene own = withVoxelsOf(scene, level.volumes);
        const bool surfaces = hasSurfaces(own);
        // A scene of like media has no small ones that much larger ones ask to blur.
        const double limit = surfaces ? kMostOfSurfaces : plan.levels.size() > 1 ? kMostOfMedia : 1;
        const double part = surfaces || level.coarser == 1 ? 1 : kOfMedia;
        grows = level.coarser < limit && sum() > part * most;
        if (!grows) break;
        level.coarser *= kStep;
        for (double& edge : level.edges) edge *= kStep;
        bytes[l] = cellBytes(own, plan, level);
    }
    plan.bytes = static_cast<std::size_t>(std::min(sum(), 1e18));
    if (sum() <= most) return;
    CellLightPlan none;
    none.unfit = fmt::format("the cells of all volumes would take {}", bytesText(std::size_t(std::min(wanted, 1e18))));
    plan = std::move(none);
}

// True if look-ups show a light's place: a lamp, or a surface among the volumes.
bool isSharpOnCells(const ViewScene& scene, const Light& light, const std::vector<Vec3>& wsCorners) {
    return isLampOnCells(scene, light) || (AreaShine::serves(light) && isAmong(light, wsCorners));
}

// Divides levels whose volumes are so far apart that they hide next to nothing of each other's skies: 4e-4 of an even
// one, and a 25th of that of a picture, which may be brighter there. Not where another kind of light is kept, whose
// shadows may be long.
void divideLevels(const ViewScene& scene, CellLightPlan& plan) {
    constexpr double kSizes = 12, kSizesUnderPicture = 60;
    double sizes = kSizes;
    std::vector<Vec3> lamps;
    for (const int i : plan.lights) {
        const Light& light = scene.lights[std::size_t(i)];
        const bool lamp = isLampOnCells(scene, light);
        if (!lamp && !light.dome()) return;
        if (lamp) lamps.push_back(light.wsPosition);
        if (light.slide) sizes = kSizesUnderPicture;
    }
    std::vector<CellLevel> levels;
    for (const CellLevel& level : plan.levels)
        for (std::vector<bool>& group : farApart(scene, level.volumes, sizes))
            levels.emplace_back().volumes = std::move(group);
    const std::vector<bool> all = withVoxels(scene);
    bool apart = false;
    for (CellLevel& level : levels) {
        level.around = around(scene, level.volumes, sizes, lamps);
        apart = apart || level.around != all;
    }
    if (apart) plan.levels = std::move(levels);
}

}  // namespace

CellLightPlan planCellLights(const ViewScene& scene) {
    CellLightPlan plan;
    const std::vector<Vec3> corners = wsCorners(scene);
    if (corners.empty()) return plan;
    const ViewScene surfaces = surfacesOf(scene);
    const bool exact = !hasSurfaces(scene) || surfacesFit(surfaces, surfaceCell(surfaces));
    std::vector<bool> inView;  // empty until it is needed, because it takes time where there are many lights
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        if (!fitsCells(scene, light, corners, exact)) continue;
        if (inView.empty()) inView = lightsInView(scene);
        if (!inView[i]) continue;
        plan.lights.push_back(static_cast<int>(i));
        if (plan.lamp.empty() && isSharpOnCells(scene, light, corners)) plan.lamp = light.name;
    }
    if (plan.lights.empty()) return plan;
    const auto edgesFor = [&](const ViewScene& own) {
        const double longest = longestOf(own);
        std::vector<double> edges;
        for (const int i : plan.lights)
            edges.push_back(lightCell(own, scene.lights[std::size_t(i)], longest) * voxelUnit(own));
        return edges;
    };
    for (std::vector<bool>& volumes :
         cellLevels(scene, [&](const ViewScene& own) { return std::ranges::min(edgesFor(own)); }))
        plan.levels.emplace_back().volumes = std::move(volumes);
    divideLevels(scene, plan);
    const auto ownOf = [&](const CellLevel& level) {
        return plan.levels.size() > 1 ? withVoxelsOf(scene, level.volumes) : scene;
    };
    for (CellLevel& level : plan.levels) level.edges = edgesFor(ownOf(level));
    if (scene.dials.lightCell || scene.dials.lightCellOthers) setByDials(scene, plan);
    std::vector<double> bytes;
    for (CellLevel& level : plan.levels) {
        const ViewScene own = ownOf(level);
        level.features = kFeatures * longestOf(own) * voxelUnit(own);
        bytes.push_back(cellBytes(own, plan, level));
    }
    growCells(scene, plan, bytes);
    return plan;
}

std::size_t finestLevel(const CellLightPlan& cells) {
    return std::size_t(std::ranges::min_element(cells.levels, {}, &CellLevel::smallest) - cells.levels.begin());
}

double smallestCell(const ViewScene& scene, const CellLightPlan& cells) {
    const CellLevel& finest = cells.levels[finestLevel(cells)];
    return finest.smallest() / voxelUnit(withVoxelsOf(scene, finest.volumes));
}

double errorOfLargeCells(const ViewScene& scene, const CellLightPlan& cells) {
    double error = 0;
    for (const CellLevel& level : cells.levels) {
        const ViewScene own = withVoxelsOf(scene, level.volumes);
        if (level.coarser > 1 && hasSurfaces(own))
            error = std::max(error, errorOfSurfaces(own, *std::ranges::max_element(level.edges) / voxelUnit(own)));
    }
    return error;
}

std::string setsText(const ViewScene& scene, const CellLightPlan& cells) {
    const std::size_t sets = castingSets(scene, cells.lights, true);
    return sets < 2 ? "" : fmt::format("; {} sets of media, since some volumes cast shadows in some lights only", sets);
}

std::string blurredSkies(const ViewScene& scene, const TransportPlan& plan) {
    constexpr double kLittle = 0.01;  // of its light
    std::string skies;
    for (const int i : plan.lights()) {
        const Light& light = scene.lights[std::size_t(i)];
        const double share = entersAtBorder(scene, std::size_t(i)) ? lightInSpots(light, plan.ordinates) : 0;
        if (share < kLittle) continue;
        skies += fmt::format(
            "{}'{}': {:.0f} % of its light comes from spots smaller than one of the {} directions, "
            "and is blurred",
            skies.empty() ? "" : ", ", light.name, 100 * share, plan.ordinates);
    }
    return skies;
}

namespace {

// The approximate number of a domain's cells.
double cellsOf(const ViewScene& scene, const ScatterDomain& domain, bool alone) {
    const ViewScene own = domain.parent < 0 ? scene : withVoxelsOf(scene, domain.volumes);
    // Blocks of cells at the border are only partly covered by voxels' blocks, which about doubles their number.
    const double blocks = 2 * occupied(own, 0.5 * domain.edge), cell = std::pow(domain.edge, 3);
    if (alone) return blocks / cell;
    const Vec3 box = wsBounds(own).size() + domain.edge * kCellEdge;
    const double all = box.x * box.y * box.z;
    return (domain.filled ? all : std::min(blocks, all)) / cell;
}

// Memory for multiply scattered light: what a solve, its last sweep and its light keep of each cell.
double bytesFor(const ViewScene& scene, const TransportPlan& plan, bool flux) {
    const auto ordinates = std::size_t(solvedOrdinates(plan.ordinates));
    const bool further = plan.ordinates > int(ordinates);  // the last sweep has more than the solve
    const std::vector<ScatterClass> all = scatterClasses(scene, int(ordinates));
    const bool someOnce = std::ranges::any_of(all, &ScatterClass::once);
    const std::size_t classes = all.size(), bundles = bundlesOf(Simd(scene.dials.simd), int(ordinates));
    std::size_t points = 0;
    for (const ScatterTarget& target : plan.targets) points = std::max(points, FirstLight::points(scene, target));

    // The solver: x, next and source, the steps that are mixed, and x before a correction.
    const bool walls = solidsBlock(scene), coarsest = walls || plan.cells <= double(TransportSolver::kFewestCells);
    const std::size_t values = plan.isotropic ? 1 : ordinates;
    std::size_t rows = 3 + (plan.isotropic ? 1 : 0);
    if (plan.isotropic || coarsest)
        rows += AndersonMixing::vectors(walls && !plan.isotropic ? TransportSolver::kShortHistory
                                                                 : TransportSolver::kHistory);
    // Beside them scattering, shares of classes and the place of a row; extinction and the number of a cell's row.
    double perRow = double(values * rows + 1 + classes + 2), perCell = 2;
    if (plan.isotropic) perCell += double((1 + bundles) * (further ? 2 : 1));  // of sweeps
    perRow += double(someOnce ? 2 * points + values : points);
    const std::size_t straight = plan.isotropic ? 0 : std::max<std::size_t>(classes, 4);
    perRow += double(3 * classes + straight + (flux ? 3 : 0));  // see LastSweep::pass
    const double colours = greyScattering(scene) ? 1 : 3;
    const double media = colours * double(2 + classes) + (anyEmits(scene) ? 3 : 0);
    perCell += further && !plan.isotropic ? 2 * media : media;
    // Fields have borders around their blocks, which about doubles them.
    perCell +=
        3 * 2 * (double(plan.targets.size() * classes) * (wants(scene, Layer::indirect) ? 2 : 1) + (flux ? 3 : 0));
    const double known = plan.isotropic ? 1 : 0.6;  // of the cells: those where nothing is have no row
    // The factor accounts for coarser levels, and for cells twice as large for extrapolation.
    return 1.3 * plan.cells * sizeof(Real) * (known * perRow + perCell);
}

}  // namespace

TransportPlan planForBackdrop(const ViewScene& scene) {
    return backdropIsLitByVolumes(scene) ? planTransport(withScatteredApart(scene)) : TransportPlan();
}

TransportPlan planTransport(const ViewScene& scene, bool flux) {
    TransportPlan plan;
    if (!anyScattersFully(scene)) return plan;
    plan.targets = targetsOf(scene);
    const double cell = scene.dials.scatterCell.value_or(kScatterCell);
    plan.domains = flux ? wholeScene(scene, cell) : scatterDomains(scene, cell);
    plan.ordinates = scene.dials.scatterDirections.value_or(ordinatesFor(scene));
    plan.isotropic = !flux && std::ranges::all_of(scene.volumes, [](const ViewVolume& v) {
        return v.classified || v.medium.phase.isotropic();
    });
    for (const ScatterDomain& domain : plan.domains) plan.cells += cellsOf(scene, domain, plan.domains.size() == 1);
    const double bytes = bytesFor(scene, plan, flux);
    plan.bytes = static_cast<std::size_t>(std::min(bytes, 1e18));
    if (scene.memoryLimit > 0 && plan.bytes > scene.memoryLimit)
        throw Error(ErrorKind::memory,
                    fmt::format("multiple scattering needs about {} with cells of {:.4g} voxels, more than the memory "
                                "limit of {}; raise scatter_cell",
                                bytesText(plan.bytes), cell, bytesText(scene.memoryLimit)));
    return plan;
}

}  // namespace scrim
