// SPDX-License-Identifier: Apache-2.0
// `scrim bake`: the light that reaches the voxels of a scene, as grids.
#pragma once

namespace scrim::cli {

struct SceneOptions;

/// Throws Error.
void bakeCommand(const SceneOptions& options);

}  // namespace scrim::cli
