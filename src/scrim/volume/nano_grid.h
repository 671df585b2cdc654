// SPDX-License-Identifier: Apache-2.0
// Makes OpenVDB grids of NanoVDB grids, which are trees in one piece of memory whose nodes refer to each other by
// offsets. NanoVDB's own reader believes all of them; here each is checked before it is followed.
#pragma once

#include <scrim/volume/vdb_layout.h>

#include <openvdb/openvdb.h>

namespace scrim {

/// The grid `layout` of the file: a float grid, or a vec3s grid of vectors and colours (of four components the first
/// three, 8-bit colours by 1/255). All numbers become floats, those of masks 1. Throws Error(input) "path: ..." where
/// the grid's type is not read or its bytes are damaged, and std::bad_alloc.
openvdb::GridBase::Ptr readNanoGrid(const VdbBytes& file, const VdbLayout::Grid& layout);

}  // namespace scrim
