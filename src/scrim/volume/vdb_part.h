// SPDX-License-Identifier: Apache-2.0
// Internal: the bytes of a .vdb file that hold the grids which somebody wants, and nothing else.
#pragma once

#include <scrim/volume/grid_request.h>
#include <scrim/volume/vdb_bytes.h>
#include <scrim/volume/vdb_layout.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// The indices of the grids that `requests` need, and of those called `others`, in the file's order. No value where the
/// whole file must be read, because it does not say where its grids are, or one of the grids shares the voxels of
/// another.
std::optional<std::vector<std::size_t>> neededGrids(const VdbLayout& layout, const std::vector<GridRequest>& requests,
                                                    const std::vector<std::string>& others);

/// The bytes of a file that contains only the grids of `file` at `places`. The offsets in the descriptors are those of
/// the original, but OpenVDB's stream does not use them.
std::vector<char> partOfFile(const VdbBytes& file, const VdbLayout& layout, const std::vector<std::size_t>& places);

std::vector<char> allOfFile(const VdbBytes& file);

}  // namespace scrim
