// SPDX-License-Identifier: Apache-2.0
// `scrim plan`: what a render would do, without doing it.
#pragma once

#include "options.h"

namespace scrim::cli {

/// Prints the plan of every frame asked for. Throws Error.
void planCommand(const SceneOptions& options);

}  // namespace scrim::cli
