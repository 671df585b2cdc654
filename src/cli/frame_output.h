// SPDX-License-Identifier: Apache-2.0
// A rendered frame as files: the OpenEXR picture with what a pipeline wants to know about it, and the
// preview.
#pragma once

#include "console.h"
#include "frame_report.h"

#include <scrim/image/colour.h>
#include <scrim/scene/scene.h>

#include <string>

namespace scrim::cli {

/// Writes `frame` (in the working space), and converts it in doing so. `sceneToml` goes into the metadata.
/// Throws Error.
void writeFrame(const Scene& scene, const std::string& sceneToml, const ColourConfig& colour, Frame frame,
                const FrameReport& report, Console& console);

}  // namespace scrim::cli
