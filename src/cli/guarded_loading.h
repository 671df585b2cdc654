// SPDX-License-Identifier: Apache-2.0
// How all commands read volumes.
#pragma once

#include <scrim/guard/load_options.h>

#include <cstddef>

namespace scrim::cli {

/// `showStderr`: the reading process's, for those who look for its reason.
inline LoadOptions guardedLoading(std::size_t memory, bool showStderr) {
    return {VolumeLoading::guarded, "", memory, showStderr};
}

}  // namespace scrim::cli
