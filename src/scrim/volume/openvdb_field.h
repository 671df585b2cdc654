// SPDX-License-Identifier: Apache-2.0
// Internal: from OpenVDB's grids to ours. Only the .cpp files that talk to OpenVDB include this header.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/grid_choice.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_info.h>

#include <string>

#include <openvdb/openvdb.h>

namespace scrim {

/// What a request can choose of a grid.
GridOffer offerOf(const openvdb::GridBase& grid);

/// The field of a scalar grid; `where` (the file) starts every message and error.
SparseField fieldFromGrid(const openvdb::GridBase& grid, const std::string& where, const MessageSink& messages);

/// Turns a scalar level set into fog where it stands, and says so; leaves every other grid as it is.
void levelSetIntoFog(openvdb::GridBase& grid, const std::string& where, const MessageSink& messages);

/// The field of a colour: of one component (0, 1, 2) of a vec3 grid, whose name gets ".r", ".g" or ".b" behind it, or
/// of a scalar grid (kScalar), of which it does not matter that it may call itself a level set.
SparseField colourFromGrid(const openvdb::GridBase& grid, int component, const std::string& where,
                           const MessageSink& messages);

/// The numbers above 0 of a velocity, or those below it without their sign, as a field: of a vec3 grid's component,
/// ".x", ".y" or ".z" (where the grid is staggered it stands on the faces of voxels), or of a scalar grid (kScalar).
SparseField velocityFromGrid(const openvdb::GridBase& grid, int component, bool negative, const std::string& where,
                             const MessageSink& messages);

/// Describes any grid; values of scalar ones.
GridInfo describeGrid(const openvdb::GridBase& grid);

}  // namespace scrim
