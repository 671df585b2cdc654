// SPDX-License-Identifier: Apache-2.0
// Errors of lights with an extent that no dial removes: a promise that they break is told before the render.
#pragma once

#include <scrim/scene/view_scene.h>
#include <scrim/verify/promise.h>

namespace scrim {

/// Adds what lamps leave that opaque voxels touch.
void addTouchingLamps(const ViewScene& scene, PromisedDials& promised);
/// Adds what lobes of phase functions and spreads of surfaces leave where they are narrow beside the lights.
void addNarrow(const ViewScene& scene, PromisedDials& promised);
/// Adds what surfaces among the volumes leave close to them, where the camera sees that.
void addSurfacesAmong(const ViewScene& scene, PromisedDials& promised);

}  // namespace scrim
