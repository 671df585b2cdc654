// SPDX-License-Identifier: Apache-2.0
// scrim render --budget: the preset that a time allows.
#pragma once

#include "console.h"
#include "options.h"
#include "scene_input.h"

namespace scrim::cli {

/// Sets the finest preset with which a frame of `input` should take at most `options.budget` seconds, for all frames.
/// The first one that is not skipped is rendered with the coarsest preset, which tells how fast this machine is. Throws
/// Error: usage where the options choose a quality already, and as rendering does.
void takePresetWithin(SceneInput& input, const SceneOptions& options, Console& console);

}  // namespace scrim::cli
