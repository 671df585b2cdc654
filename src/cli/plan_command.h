// SPDX-License-Identifier: Apache-2.0
// `scrim plan`: shows what a render would do, without rendering.
#pragma once

#include "options.h"

namespace scrim::cli {

/// Prints the plan of every requested frame. Throws Error.
void planCommand(const SceneOptions& options);

}  // namespace scrim::cli
