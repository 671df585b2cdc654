// SPDX-License-Identifier: Apache-2.0
// Reads .vdb files in a child process under a memory limit: OpenVDB's reader can crash on damaged files, and
// then the child dies and this process says so. The child is this program itself with a hidden command; the
// result comes back through shared memory (volume/field_transfer.h).
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_info.h>

#include <cstddef>
#include <string>
#include <vector>

namespace scrim::cli {

struct LoadLimits {
    std::size_t memory = 0;   ///< bytes a child may take; 0: by the file's size
    int threads = 0;          ///< of a child; 0: some
    bool showStderr = false;  ///< the child's, for those who look for its reason
};

/// The fields that `requests` mean in one file, in that order. Throws GridError where the file does not have one of
/// them, else Error: input, memory, interrupted.
std::vector<SparseField> loadFields(const std::string& path, const std::vector<GridRequest>& requests,
                                    const LoadLimits& limits, const MessageSink& messages);

/// What the file says about itself. Throws as `loadFields`.
VdbFileInfo loadInfo(const std::string& path, const LoadLimits& limits);

/// The name of the hidden command, and what it does with the arguments behind it. Returns the exit status.
inline constexpr const char* kInternalLoad = "internal-load";
int internalLoad(const std::vector<std::string>& arguments);

}  // namespace scrim::cli
