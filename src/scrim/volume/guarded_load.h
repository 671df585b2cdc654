// SPDX-License-Identifier: Apache-2.0
// Reads .vdb files in a child process under a memory limit: OpenVDB's reader can crash on damaged files, and then the
// child dies and this process says so. The child is a program that calls `internalLoad` for a hidden command, as
// `scrim` does; the result comes back through shared memory (field_transfer.h).
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/load_options.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_info.h>

#include <string>
#include <vector>

namespace scrim {

/// As `loadFields` (load_fields.h). Calls `checkpoint` every few milliseconds; where that throws, the child is ended.
std::vector<SparseField> guardedFields(const std::string& path, const std::vector<GridRequest>& requests,
                                       const LoadOptions& options, const MessageSink& messages,
                                       const Checkpoint& checkpoint);
VdbFileInfo guardedInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint);

/// The child's side: the name of the hidden command, and what it does with the arguments behind it. Returns the exit
/// status. A damaged file may have spoilt the heap: the program should end at once, by `_exit`.
inline constexpr const char* kInternalLoad = "internal-load";
int internalLoad(const std::vector<std::string>& arguments);

}  // namespace scrim
