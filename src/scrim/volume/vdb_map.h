// SPDX-License-Identifier: Apache-2.0
// Internal: the transform of a grid in a .vdb file, read without OpenVDB.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/volume/vdb_bytes.h>

#include <optional>
#include <string>

namespace scrim {

/// Reads the numbers of an OpenVDB map of the kind `map`, and leaves `walk` behind them: the world position of an
/// index. No value where the map is not affine. Throws Error(input) where the file ends too early.
std::optional<Mat4> readVdbMap(VdbWalker& walk, const std::string& map);

}  // namespace scrim
