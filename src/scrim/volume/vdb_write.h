// SPDX-License-Identifier: Apache-2.0
// Saves fields as a .vdb file that every other program reads.
#pragma once

#include <scrim/volume/sparse_field.h>

#include <string>
#include <vector>

namespace scrim {

/// Writes `fields` as float fog volumes, in their order: voxels above 0 are active, tiles stay tiles; Blosc
/// compressed where OpenVDB can, zip else. The file appears whole or not at all. Throws Error(output).
void writeVdb(const std::string& path, const std::vector<SparseField>& fields);

}  // namespace scrim
