// SPDX-License-Identifier: Apache-2.0
// Saves fields as a .vdb file for other programs.
#pragma once

#include <scrim/volume/sparse_field.h>

#include <bitset>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

/// Writes `fields` as float fog volumes in their order. Voxels above 0 are active, and tiles remain tiles. Compression
/// is Blosc where OpenVDB supports it, else zip. The file appears completely or not at all. Throws Error(output).
void writeVdb(const std::string& path, const std::vector<SparseField>& fields);

/// A grid of numbers of any sign, or of colours.
struct VdbGrid {
    std::string name;
    Mat4 wsFromIs{1.0};
    bool colour = false;                            ///< vec3s, else float
    std::vector<Int3> blockOrigins;                 ///< as in SparseField, but in any order
    std::vector<std::bitset<kBlockVoxels>> active;  ///< for each block
    std::vector<float> values;  ///< for each block 512 values, or 512 triples of red, green and blue
    std::vector<std::pair<std::string, std::string>> metadata;
};

/// Writes `grids` in the same way. Voxels are active where `active` says so, and 0 elsewhere.
/// `metadata` belongs to the file.
void writeVdbGrids(const std::string& path, const std::vector<VdbGrid>& grids,
                   const std::vector<std::pair<std::string, std::string>>& metadata = {});

}  // namespace scrim
