// SPDX-License-Identifier: Apache-2.0
// Internal: from OpenVDB's grids to ours. Only the .cpp files that talk to OpenVDB include this header.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_info.h>

#include <string>

#include <openvdb/openvdb.h>

namespace scrim {

/// Whether `fieldFromGrid` accepts it: a float grid (also one saved as half) or a double grid.
bool isScalarGrid(const openvdb::GridBase& grid);

/// The field of a scalar grid; `where` (the file) starts every message and error.
SparseField fieldFromGrid(const openvdb::GridBase& grid, const std::string& where, const MessageSink& messages);

/// Describes any grid; values of scalar ones.
GridInfo describeGrid(const openvdb::GridBase& grid);

}  // namespace scrim
