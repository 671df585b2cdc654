// SPDX-License-Identifier: Apache-2.0
// `scrim bake`: bakes the light that reaches the voxels of a scene into grids.
#pragma once

namespace scrim::cli {

struct SceneOptions;

/// Bakes all frames. Throws Error.
void bakeCommand(const SceneOptions& options);

}  // namespace scrim::cli
