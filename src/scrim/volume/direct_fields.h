// SPDX-License-Identifier: Apache-2.0
// Internal: makes fields of a grid straight from its file, without a tree of its values in between: OpenVDB reads the
// tree above the leaves, readLeaves (vdb_leaves.h) the leaves. Several fields of a grid (colours, velocities) take one
// pass. What needs more than that (level sets, frustums, other numbers than floats, old files) is left to OpenVDB.
#pragma once

#include <scrim/volume/block_memory.h>
#include <scrim/volume/openvdb_field.h>
#include <scrim/volume/vdb_bytes.h>
#include <scrim/volume/vdb_layout.h>

#include <cstddef>
#include <vector>

namespace scrim {

struct DirectField {
    FieldChoice choice;
    bool asFog = false;  ///< a level set is to become fog
};

/// The fields of grid `place` of the file that `wanted` mean, equal to those that fieldFromGrid, colourFromGrid and
/// velocityFromGrid make of it. Their values lie in `memory`. Empty where the grid needs OpenVDB, or where anything is
/// wrong with it, which OpenVDB then reports. Throws Error only where `memory` does.
std::vector<SparseField> directFields(const VdbBytes& file, const VdbLayout& layout, std::size_t place,
                                      const std::vector<DirectField>& wanted, BlockMemory& memory);

}  // namespace scrim
