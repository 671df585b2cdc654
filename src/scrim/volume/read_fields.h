// SPDX-License-Identifier: Apache-2.0
// Internal: reads a .vdb file in this process.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_bytes.h>

#include <functional>
#include <string>
#include <vector>

namespace scrim {

/// The fields that `requests` mean, in their order. Each message is sent once, although a grey grid is read once for
/// each component.
std::vector<SparseField> readFields(const VdbBytes& file, const std::vector<GridRequest>& requests,
                                    const MessageSink& messages);

/// Runs `task`, which reads `path`, and turns exceptions of libraries into Errors.
void readWithErrors(const std::string& path, const std::function<void()>& task);

}  // namespace scrim
