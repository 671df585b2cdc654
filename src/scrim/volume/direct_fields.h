// SPDX-License-Identifier: Apache-2.0
// Internal: makes fields of a .vdb file straight from its bytes, without OpenVDB and without a tree
// of its values in between: vdb_tree.h reads the tree above the leaves, vdb_leaves.h the leaves.
// Several fields of a grid (colours, velocities) take one pass. What needs more than that (level
// sets, frustums, other numbers than floats, old files) is left to OpenVDB.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/block_memory.h>
#include <scrim/volume/grid_choice.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_bytes.h>
#include <scrim/volume/vdb_layout.h>

#include <map>
#include <optional>
#include <vector>

namespace scrim {

/// The fields among `requests` that need no OpenVDB, equal to those that fieldFromGrid, colourFromGrid and
/// velocityFromGrid make of its grids. Their values lie in `memory`. None of a grid where anything is wrong with it,
/// which OpenVDB then reports. `layout` and `offers` are those of the file. Throws Error only where `memory` does.
std::map<GridRequest, SparseField> directFields(const VdbBytes& file, const VdbLayout& layout,
                                                const std::vector<GridOffer>& offers,
                                                const std::vector<GridRequest>& requests, BlockMemory& memory);

/// What readFields (read_fields.h) returns for these requests. No value, and no message, where
/// OpenVDB is needed for any of them. Throws as directFields, and Error(input) as checkVdbLayout.
std::optional<std::vector<SparseField>> readWithoutOpenVdb(const VdbBytes& file,
                                                           const std::vector<GridRequest>& requests,
                                                           const MessageSink& messages, BlockMemory& memory);

}  // namespace scrim
