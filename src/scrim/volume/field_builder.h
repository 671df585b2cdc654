// SPDX-License-Identifier: Apache-2.0
// Makes a SparseField. All fields are cleaned, counted and sorted here, whether they come from a file, from a plug-in
// or from a finer field, so that the guarantees that the splatter relies on are implemented once.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/sparse_field.h>

#include <array>
#include <deque>
#include <functional>
#include <string>
#include <vector>

namespace scrim {

/// True if `a` comes before `b` in lattice order: ascending x, then y, then z.
bool originLess(const Int3& a, const Int3& b);

/// True if `field` has blocks wherever `other` has some, both are on the same lattice, and neither has tiles. One walk
/// can then splat both, so a colour costs one walk instead of three.
bool haveOneTopology(const SparseField& field, const SparseField& other);

/// "x, y, z", for messages.
std::string toText(const Int3& p);

/// A field before it is cleaned and sorted.
struct FieldPieces {
    std::string name;
    Mat4 wsFromIs{1.0};
    std::vector<Int3> blockOrigins;  ///< multiples of 8, without repetitions, in any order
    /// Writes the 512 values of block i (its index in `blockOrigins`) in `blockOffset` order, 0 where a voxel is
    /// inactive. Called once for each block, from several threads at a time.
    std::function<void(std::size_t i, float* values)> fill;
    /// Active tiles in any order. Their edge is 8 times a power of two, and their origin is a multiple of the edge.
    std::vector<ConstantTile> tiles;
};

/// Checks all of `pieces` except for the values; origins must be sorted by `originLess`. Throws Error(input) where
/// origins break the rules above, two blocks or tiles overlap, or the transform cannot be inverted; the message names
/// the grid, not the file.
void checkPieces(const FieldPieces& pieces);

/// Cleans, counts and sorts: values that are not finite or below 0 become 0 and are counted, denormal ones become 0,
/// and blocks and tiles without a value above 0 are removed. The result does not depend on the number of threads.
/// Throws as `checkPieces` does.
SparseField buildField(FieldPieces pieces);

/// Sends one warning "`where`: grid 'name': ..." with the numbers of cleaned values, if there are any.
void reportCleaning(const SparseField& field, const std::string& where, const MessageSink& messages);

/// Collects a field piece by piece, where the pieces are not known beforehand.
class FieldBuilder {
  public:
    FieldBuilder(std::string name, const Mat4& wsFromIs);

    /// Adds a block. `values`: 512 values in `blockOffset` order, which are copied. finish() checks the rules of
    /// FieldPieces.
    void addBlock(const Int3& origin, const float* values);
    void addTile(const ConstantTile& tile);

    const std::string& name() const { return m_pieces.name; }

    /// Returns the field, as `buildField` does. The builder is empty afterwards.
    SparseField finish();

  private:
    FieldPieces m_pieces;
    std::deque<std::array<float, kBlockVoxels>> m_values;
};

}  // namespace scrim
