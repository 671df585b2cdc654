// SPDX-License-Identifier: Apache-2.0
// How deep the places of a density are inside of it.
#pragma once

#include <scrim/volume/sparse_field.h>

#include <cstddef>
#include <unordered_map>
#include <vector>

namespace scrim {

/// Lower bounds on the optical depth of the shortest way from outside of a density to a place in it, however the way
/// bends. No ray to that place passes less, from whichever side it comes. Safe to use from many threads.
class WaysOut {
  public:
    WaysOut() = default;  ///< all places are at the surface
    /// `depth`: of a density of 1 along the shortest edge of a voxel. `inside`: voxels that eyes or
    /// lights are near, which count as outside.
    WaysOut(const SparseField& field, double depth, const std::vector<Int3>& inside);
    /// The least of all places in the box of the voxels `lower` to `upper`.
    double to(const Int3& lower, const Int3& upper) const;

  private:
    struct Hash {
        std::size_t operator()(const Int3& cell) const;
    };
    void addCells(const SparseField& field);
    double acrossAround(const Int3& cell, double depth) const;

    struct Cell {
        float least = 0;  ///< density
        double way = 0;
    };
    int m_shift = 0;  ///< cells are cubes of 2^shift voxels
    std::unordered_map<Int3, Cell, Hash> m_cells;
};

}  // namespace scrim
