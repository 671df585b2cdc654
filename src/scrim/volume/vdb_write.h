// SPDX-License-Identifier: Apache-2.0
// Saves fields as a .vdb file that every other program reads.
#pragma once

#include <scrim/volume/sparse_field.h>

#include <bitset>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

/// Writes `fields` as float fog volumes, in their order: voxels above 0 are active, tiles stay tiles; Blosc
/// compressed where OpenVDB can, zip else. The file appears whole or not at all. Throws Error(output).
void writeVdb(const std::string& path, const std::vector<SparseField>& fields);

/// A grid of numbers of any sign, or of colours.
struct VdbGrid {
    std::string name;
    Mat4 wsFromIs{1.0};
    bool colour = false;                            ///< vec3s, else float
    std::vector<Int3> blockOrigins;                 ///< as SparseField has them, in any order
    std::vector<std::bitset<kBlockVoxels>> active;  ///< of each block
    std::vector<float> values;                      ///< of each block 512, or 512 reds, greens and blues
    std::vector<std::pair<std::string, std::string>> metadata;
};

/// Writes `grids` likewise; voxels are active as they say, and 0 elsewhere. `metadata` is the file's.
void writeVdbGrids(const std::string& path, const std::vector<VdbGrid>& grids,
                   const std::vector<std::pair<std::string, std::string>>& metadata = {});

}  // namespace scrim
