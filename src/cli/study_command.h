// SPDX-License-Identifier: Apache-2.0
// scrim study SCENE -o DIR: measures what accuracy costs in time on the user's own scene.
#pragma once

#include "options.h"

namespace scrim::cli {

/// Writes study.csv, study.json and index.html. Throws Error.
void studyCommand(const SceneOptions& options);

}  // namespace scrim::cli
