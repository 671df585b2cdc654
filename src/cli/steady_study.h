// SPDX-License-Identifier: Apache-2.0
// scrim study SCENE --steady: measures how much the frames of a shot flicker.
#pragma once

#include "options.h"

namespace scrim::cli {

/// Prints a table, and writes steady.csv and steady.json where a folder is given. Throws Error; of kind accuracy where
/// a layer flickers more than its preset promises.
void steadyStudy(const SceneOptions& options);

}  // namespace scrim::cli
