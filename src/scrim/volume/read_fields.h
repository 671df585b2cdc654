// SPDX-License-Identifier: Apache-2.0
// Internal: reads a .vdb file in this process.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/block_memory.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/point_cloud.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_bytes.h>

#include <functional>
#include <string>
#include <vector>

namespace scrim {

class GridEditor;

/// The fields that `requests` mean, in their order. Each message is sent once, although a grey grid
/// is read once for each component. Values lie in `memory`.
std::vector<SparseField> readFields(const VdbBytes& file, const std::vector<GridRequest>& requests,
                                    const MessageSink& messages, BlockMemory& memory, const PointLook& look = {});
/// The fields that `requests` mean among the grids of several files, after `editor` has edited these.
std::vector<SparseField> readFields(const VdbFiles& files, const std::vector<GridRequest>& requests,
                                    const GridEditor& editor, const MessageSink& messages);
/// The fields that `requests` mean among the grids of a source called `name`, after `editor` has edited these.
std::vector<SparseField> editFields(const std::vector<SparseField>& grids, const std::string& name,
                                    const std::vector<GridRequest>& requests, const GridEditor& editor,
                                    const MessageSink& messages);

/// Runs `task`, which reads `path`, and turns exceptions of libraries into Errors.
void readWithErrors(const std::string& path, const std::function<void()>& task);

}  // namespace scrim
