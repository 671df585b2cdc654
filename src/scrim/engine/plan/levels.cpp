// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/levels.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

// The octave of a volume's voxels, counted from the finest one of the scene.
std::optional<int> octaveOf(const ViewScene& scene, std::size_t volume) {
    const double voxel = voxelUnit(scene.volumes[volume]);
    if (!std::isfinite(voxel)) return std::nullopt;
    return static_cast<int>(std::floor(std::log2(voxel / voxelUnit(scene)) + 1e-9));
}

}  // namespace

std::vector<VolumeLevel> oneLevel(const ViewScene& scene) {
    const std::vector<bool> all(scene.volumes.size(), true);
    return {{voxelUnit(scene), all, all}};
}

std::vector<VolumeLevel> volumeLevels(const ViewScene& scene) {
    constexpr int kOctaves = 1;  // of voxels that share sheets
    // Pixels that walk the sheets of one level instead of a sheet of the one before walk at most so
    // many. Levels without volumes come between others where there would be more.
    constexpr double kMostStep = 8;
    const double finest = voxelUnit(scene);
    if (scene.dials.splat == SplatMode::perView) return oneLevel(scene);
    // Surfaces are in the finest level: they are found along rays from sheet to sheet.
    int surfaces = 0;
    for (std::size_t v = 0; v < scene.volumes.size(); ++v)
        if (const auto octave = octaveOf(scene, v); octave && scene.volumes[v].classified)
            surfaces = std::max(surfaces, *octave);
    std::map<int, std::vector<std::size_t>> byOctave;
    for (std::size_t v = 0; v < scene.volumes.size(); ++v)
        if (const auto octave = octaveOf(scene, v)) byOctave[*octave <= surfaces ? 0 : *octave].push_back(v);
    std::vector<VolumeLevel> levels;
    int first = 0;
    for (const auto& [octave, volumes] : byOctave) {
        if (levels.empty() || octave >= first + kOctaves) {
            levels.push_back({std::ldexp(finest, octave), std::vector<bool>(scene.volumes.size(), false), {}});
            first = octave;
        }
        for (const std::size_t v : volumes) levels.back().volumes[v] = true;
    }
    if (levels.size() < 2) return oneLevel(scene);
    std::vector<VolumeLevel> out;
    for (VolumeLevel& level : levels) {
        while (!out.empty() && level.voxel > kMostStep * out.back().voxel) {
            VolumeLevel between = out.back();
            between.voxel *= kMostStep;
            std::fill(between.volumes.begin(), between.volumes.end(), false);
            out.push_back(std::move(between));
        }
        level.around = level.volumes;
        out.push_back(std::move(level));
    }
    std::reverse(out.begin(), out.end());
    return out;
}

std::vector<Vec3> wsCorners(const ViewScene& scene, const VolumeLevel& level) {
    std::vector<Vec3> corners;
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        if (!level.around[v]) continue;
        const std::vector<Vec3> own = wsCorners(scene.volumes[v], scene.dials.kernel);
        corners.insert(corners.end(), own.begin(), own.end());
    }
    return corners;
}

}  // namespace scrim
