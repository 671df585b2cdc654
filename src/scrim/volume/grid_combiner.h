// SPDX-License-Identifier: Apache-2.0
// Internal: puts a grid together from grids of several files (grid_edit.h). Only the .cpp files
// that use OpenVDB include this header.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/grid_choice.h>
#include <scrim/volume/grid_edit.h>

#include <string>
#include <vector>

#include <openvdb/openvdb.h>

namespace scrim {

/// The index of the grid that `part` of `grid` means among those of the file `path`. Throws
/// Error(input) with the place of the part where there is none.
std::size_t choosePart(const std::vector<GridOffer>& offers, const CombinedGrid& grid, const CombinedGrid::Part& part,
                       const std::string& path);

/// The grids of `edit` that a request for a grid called `wanted` can mean; "" stands for the density.
std::vector<const CombinedGrid*> gridsCalled(const GridEdit& edit, const std::string& wanted);

/// The grid that `parts` make, which belong to `grid.parts`. A single part is not copied. Grids of
/// other voxels than the first one's are interpolated linearly at its voxels; level sets that are
/// combined become fog first. An info message says what the scene does not: which grid was chosen,
/// or what was computed. Throws Error(input) with the place of the part that does not fit.
openvdb::GridBase::Ptr combine(const GridEdit& edit, const CombinedGrid& grid,
                               std::vector<openvdb::GridBase::Ptr> parts, const MessageSink& messages);

}  // namespace scrim
