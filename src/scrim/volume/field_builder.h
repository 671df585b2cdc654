// SPDX-License-Identifier: Apache-2.0
// The one way a SparseField comes to be: values are cleaned, counted and put in order here, whether they come
// from a file, from a plug-in or from a finer field. What the splatter may rely on is therefore written once.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/sparse_field.h>

#include <array>
#include <deque>
#include <functional>
#include <string>
#include <vector>

namespace scrim {

/// Lattice order of origins: ascending x, then y, then z.
bool originLess(const Int3& a, const Int3& b);

/// Do all blocks of `other` lie where `field` has blocks, on the same lattice, and has neither any tiles? Then both are
/// splatted by one walk: a colour costs one, not three.
bool haveOneTopology(const SparseField& field, const SparseField& other);

/// "x, y, z", for messages.
std::string toText(const Int3& p);

/// A field before it is cleaned and sorted.
struct FieldPieces {
    std::string name;
    Mat4 wsFromIs{1.0};
    std::vector<Int3> blockOrigins;  ///< multiples of 8, each once, in any order
    /// Writes the 512 values of block i (the place in `blockOrigins`) in `blockOffset` order, 0 where a voxel
    /// is inactive. Called once a block, from several threads at a time.
    std::function<void(std::size_t i, float* values)> fill;
    /// Active tiles, whose edge is 8 times a power of two and whose origin is a multiple of the edge; any
    /// order.
    std::vector<ConstantTile> tiles;
};

/// Checks all of `pieces` but the values, whose origins must be sorted by `originLess`. Throws Error(input)
/// where origins break the rules above, two blocks or tiles overlap, or the transform cannot be inverted; the
/// message names the grid, not the file.
void checkPieces(const FieldPieces& pieces);

/// Cleans, counts and sorts: values that are not finite or below 0 become 0 and are counted, denormal ones
/// become 0, blocks and tiles without a value above 0 are removed. The result does not depend on the number
/// of threads. Throws what `checkPieces` throws.
SparseField buildField(FieldPieces pieces);

/// One warning "`where`: grid 'name': ..." if cleaning changed any value, with the numbers.
void reportCleaning(const SparseField& field, const std::string& where, const MessageSink& messages);

/// Collects a field piece by piece, for those who do not know beforehand what there will be.
class FieldBuilder {
  public:
    FieldBuilder(std::string name, const Mat4& wsFromIs);

    /// `values`: 512 values in `blockOffset` order, copied. Rules are those of FieldPieces, checked by
    /// finish().
    void addBlock(const Int3& origin, const float* values);
    void addTile(const ConstantTile& tile);

    const std::string& name() const { return m_pieces.name; }

    /// As `buildField`. The builder is empty afterwards.
    SparseField finish();

  private:
    FieldPieces m_pieces;
    std::deque<std::array<float, kBlockVoxels>> m_values;
};

}  // namespace scrim
