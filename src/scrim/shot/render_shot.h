// SPDX-License-Identifier: Apache-2.0
// From a loaded scene to its plan, and to a picture that is verified where that is asked for.
#pragma once

#include <scrim/engine/model/frame.h>
#include <scrim/shot/load_shot.h>
#include <scrim/shot/shot_frame.h>
#include <scrim/shot/shot_options.h>

#include <cstddef>
#include <functional>

namespace scrim {

/// Whether the picture is compared with the reference.
bool isVerified(const Scene& scene, const RenderOptions& options);

/// The plan of what a render would do. Throws Error.
ShotPlan planLoaded(const LoadedShot& shot, const RenderOptions& options);

/// Renders, and verifies or keeps a tolerance. Fills in `report`, except for what concerns loading and files. Throws
/// Error.
/// Calls `begins` with the bytes of its buffers before it begins to render; that may be more than once.
Frame renderLoaded(const LoadedShot& shot, const RenderOptions& options, ShotReport& report,
                   const std::function<void(std::size_t)>& begins);

}  // namespace scrim
