// SPDX-License-Identifier: Apache-2.0
// Turns a loaded shot into its plan, and into a picture that is verified on request.
#pragma once

#include <scrim/engine/model/frame.h>
#include <scrim/shot/load_shot.h>
#include <scrim/shot/shot_frame.h>
#include <scrim/shot/shot_options.h>

#include <cstddef>
#include <functional>

namespace scrim {

/// True if the picture is compared with the reference.
bool isVerified(const Scene& scene, const RenderOptions& options);

struct PlannedShot {
    ShotPlan plan;
    Dials dials;           ///< of the render, or of each render that motion blur averages
    bool coarser = false;  ///< these have other texels or sheets than a still of the scene would
};

/// The plan of the render, without rendering. Throws Error.
PlannedShot planLoaded(const LoadedShot& shot, const RenderOptions& options);

/// Renders, and verifies or keeps a tolerance. Fills in `report` except for the parts about loading and files. Calls
/// `begins` with the bytes of its buffers before each render; there may be several. Throws Error.
Frame renderLoaded(const LoadedShot& shot, const RenderOptions& options, ShotReport& report,
                   const std::function<void(std::size_t)>& begins);

}  // namespace scrim
