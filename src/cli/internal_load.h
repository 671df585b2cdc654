// SPDX-License-Identifier: Apache-2.0
// This program is its own loader: it reads volumes in children of itself, which it starts with a hidden command.
#pragma once

#include <scrim/volume/guarded_load.h>
#include <scrim/volume/load_options.h>

#include <cstddef>

namespace scrim::cli {

using scrim::internalLoad;
using scrim::kInternalLoad;

/// How all commands read volumes. `showStderr`: the child's, for those who look for its reason.
inline LoadOptions guardedLoading(std::size_t memory, int threads, bool showStderr) {
    return {VolumeLoading::guarded, "/proc/self/exe", memory, threads, showStderr};
}

}  // namespace scrim::cli
