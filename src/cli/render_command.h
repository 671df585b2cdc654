// SPDX-License-Identifier: Apache-2.0
// `scrim render`: renders scenes and assets to pictures.
#pragma once

#include "options.h"

namespace scrim::cli {

/// Renders all frames of all inputs; stops at the first failure. Throws Error.
void renderCommand(const SceneOptions& options);

}  // namespace scrim::cli
