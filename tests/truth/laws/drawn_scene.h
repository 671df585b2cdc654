// SPDX-License-Identifier: Apache-2.0
// Small scenes drawn over the keys that the schema knows: text first, so that only what a user can write is rendered.
#pragma once

#include "draws.h"

#include <scrim/scene/view_scene.h>

#include <set>
#include <string>
#include <vector>

namespace scrim::test {

struct DrawnScene {
    std::string toml;
    ViewScene view;
    /// What it is made of: "light.dome", "medium.full", "volume.shadows", ...: a kind, or a key that it states.
    std::set<std::string> parts;

    bool has(const std::string& part) const { return parts.contains(part); }
};

/// The sections of a scene: camera, ambient and dials, output, then volumes, meshes and lights.
inline constexpr std::size_t kMostVolumes = 3, kMostMeshes = 2, kMostLights = 4;
inline constexpr std::size_t kSections = 3 + kMostVolumes + kMostMeshes + kMostLights;
/// A section more, for the choices of laws.
inline constexpr std::size_t kLawSection = kSections;

/// Throws Error where the scene is refused.
DrawnScene drawnScene(const std::vector<double>& numbers);

/// Keys that scenes of this folder never state, with the reason why, as "section.key".
const std::vector<std::pair<std::string, std::string>>& undrawnKeys();

}  // namespace scrim::test
