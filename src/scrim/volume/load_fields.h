// SPDX-License-Identifier: Apache-2.0
// Reads volume files, in this process or in a child.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/load_options.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_info.h>

#include <functional>
#include <string>
#include <vector>

namespace scrim {

/// The fields that `requests` mean in one file, in that order. A guarded load calls `checkpoint` while it waits. Throws
/// GridError where the file lacks one of them, else Error: input, memory, usage (guarded without a loader), and what
/// `checkpoint` throws.
std::vector<SparseField> loadFields(const std::string& path, const std::vector<GridRequest>& requests,
                                    const LoadOptions& options, const MessageSink& messages,
                                    const Checkpoint& checkpoint = {});

/// What the file says about itself. Throws as `loadFields`.
VdbFileInfo loadInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint = {});

/// Reads the fields in this process. Tells each message once: a grey grid is read once a component.
std::vector<SparseField> readFields(const std::string& path, const std::vector<GridRequest>& requests,
                                    const MessageSink& messages);

/// Runs `task`, which reads `path`; turns exceptions of libraries into Errors.
void readWithErrors(const std::string& path, const std::function<void()>& task);

}  // namespace scrim
