// SPDX-License-Identifier: Apache-2.0
// Internal: all of a grid of a .vdb file but the values of its leaves, read without OpenVDB and safely on any bytes.
//
// A program that is linked to OpenVDB starts for 20 ms, longer than a small file takes. And OpenVDB makes a node of
// each leaf before it reads the values, while a field needs the place of the leaf alone. Everything unusual (nodes out
// of order, unknown classes, old versions) is left to OpenVDB, which then also finds the words for what is wrong.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/volume/vdb_bytes.h>
#include <scrim/volume/vdb_layout.h>
#include <scrim/volume/vdb_packed.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// The types of grids that are read here, as files name them.
inline constexpr const char* kVdbFloats = "Tree_float_5_4_3";
inline constexpr const char* kVdbVectors = "Tree_vec3s_5_4_3";

struct VdbTree {
    /// An active tile: the voxels origin .. origin + edge - 1 on each axis have the value.
    struct Tile {
        Int3 origin{0};
        int edge = 0;
        std::array<float, 3> value{};  ///< as many numbers as the grid has channels
    };

    std::string name;
    bool isLevelSet = false;
    bool isStaggered = false;
    Mat4 wsFromIs{1.0};
    ValueFormat format;
    std::vector<Int3> leaves;  ///< origins, in the order in which the file holds the values
    std::vector<Tile> tiles;
    std::uint64_t leavesAt = 0;  ///< where in the file the values of the leaves begin
};

/// The tree of a grid of floats, or of vectors of three floats. No value where OpenVDB is needed
/// for it. Throws Error(input) where the file ends too early, std::bad_alloc.
std::optional<VdbTree> readVdbTree(const VdbBytes& file, const VdbLayout& layout, const VdbLayout::Grid& grid);

}  // namespace scrim
