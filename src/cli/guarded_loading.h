// SPDX-License-Identifier: Apache-2.0
// How all commands read volumes: in a guarded process.
#pragma once

#include <scrim/guard/load_options.h>

#include <cstddef>

namespace scrim::cli {

/// `showStderr`: shows stderr of the reading process, for users who look for the reason of a failure.
inline LoadOptions guardedLoading(std::size_t memory, bool showStderr) {
    return {VolumeLoading::guarded, "", memory, showStderr};
}

}  // namespace scrim::cli
