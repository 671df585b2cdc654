// SPDX-License-Identifier: Apache-2.0
// `scrim view`: shows a scene in the browser. The viewer is Python code (plugins/python/scrim/view) and takes the place
// of this process, so that signals and the exit status are its own and no child is left.
#pragma once

#include <optional>
#include <string>

namespace scrim::cli {

struct ViewOptions {
    std::string input;
    std::string listen, up, resolution, ocio;  ///< "": the viewer's defaults; it checks them
    std::optional<int> frame;                  ///< none: the first
    bool noBrowser = false;
};

/// Becomes the viewer, and returns only by throwing: Error(input) where Python cannot be started.
[[noreturn]] void viewCommand(const ViewOptions& options);

}  // namespace scrim::cli
