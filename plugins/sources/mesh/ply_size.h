// SPDX-License-Identifier: Apache-2.0
// Holds a PLY file's header against its size. Assimp's reader allocates what the header declares, and reads beyond the
// end of a shorter file.
#pragma once

#include <string>

namespace mesh {

/// Throws std::runtime_error, without a path, where `bytes`, a whole file, have no PLY header, where the header names
/// an unknown type, or where the file ends before all elements that the header declares. Binary files are walked to
/// their end, lists by their lengths; in text, a number takes at least a digit and a separator.
void checkPlySize(const std::string& bytes);

}  // namespace mesh
