// SPDX-License-Identifier: Apache-2.0
// scrim study SCENE -o DIR: measures what accuracy costs in time on the user's own scene, or how steady its frames are.
#pragma once

#include "options.h"

namespace scrim::cli {

/// Writes study.csv, study.json and index.html, or does what steadyStudy does. Throws Error.
void studyCommand(const SceneOptions& options);

}  // namespace scrim::cli
