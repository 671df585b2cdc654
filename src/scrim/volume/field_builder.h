// SPDX-License-Identifier: Apache-2.0
// Makes a SparseField. All fields are cleaned, counted and sorted here, whether they come from a file, from a plug-in
// or from a finer field, so that the guarantees that the splatter relies on are implemented once.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/block_memory.h>
#include <scrim/volume/sparse_field.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace scrim {

/// True if `a` comes before `b` in lattice order: ascending x, then y, then z.
bool originLess(const Int3& a, const Int3& b);

/// True if `field` has blocks wherever `other` has some, both are on the same lattice, and neither
/// has tiles. One walk can then splat both, so a colour costs one walk instead of three.
bool haveOneTopology(const SparseField& field, const SparseField& other);

/// "x, y, z", for messages.
std::string toText(const Int3& p);

/// A field before it is cleaned and sorted.
struct FieldPieces {
    std::string name;
    Mat4 wsFromIs{1.0};
    std::vector<Int3> blockOrigins;  ///< multiples of 8, without repetitions, in any order
    /// Writes the 512 values of block i (its index in `blockOrigins`) in `blockOffset` order, 0
    /// where a voxel is inactive. Called once for each block, from several threads at a time.
    std::function<void(std::size_t i, float* values)> fill;
    /// Active tiles in any order. Their edge is 8 times a power of two, and their origin is a multiple of the edge.
    std::vector<ConstantTile> tiles;
};

/// Checks all of `pieces` except for the values; origins must be sorted by `originLess`. Throws
/// Error(input) where origins break the rules above, two blocks or tiles overlap, or the transform
/// cannot be inverted; the message names the grid, not the file.
void checkPieces(const FieldPieces& pieces);

/// Cleans, counts and sorts: values that are not finite or below 0 become 0 and are counted, denormal ones become 0,
/// and blocks and tiles without a value above 0 are removed. The result does not depend on the number of threads.
/// Throws as `checkPieces` does. Values lie in `memory`, or in memory of this process.
SparseField buildField(FieldPieces pieces, BlockMemory& memory);
SparseField buildField(FieldPieces pieces);

/// Makes a field whose values arrive block by block, in any order and from several threads at a
/// time. Cleans, counts and sorts as `buildField`, which is made of this.
class FieldFill {
  public:
    /// Takes all of `pieces` but `fill`, which is not called. `memory` must outlive this object.
    /// Throws as `checkPieces`.
    FieldFill(FieldPieces pieces, BlockMemory& memory);
    ~FieldFill();
    FieldFill(const FieldFill&) = delete;
    FieldFill& operator=(const FieldFill&) = delete;

    std::size_t blockCount() const { return m_places.size(); }
    /// The place of the 512 values of block i, by its index in `blockOrigins`.
    float* block(std::size_t i) const { return m_values.get() + std::size_t{m_places[i]} * kBlockVoxels; }
    /// Cleans and counts block i; called once for each block after its values were written.
    void filled(std::size_t i);
    /// The field, once all blocks are filled. Called once.
    SparseField finish();

  private:
    struct Counts {
        std::uint64_t active = 0;
        std::uint64_t nonFinite = 0;
        std::uint64_t negative = 0;
        float maxValue = 0;
        void add(const Counts& c);
    };
    static Counts clean(float* values);
    void addTiles(SparseField& field, Counts& counts) const;

    FieldPieces m_pieces;  ///< origins sorted
    BlockMemory& m_memory;
    std::vector<std::uint32_t> m_places;  ///< of block i in that order
    std::shared_ptr<float[]> m_values;
    std::vector<Counts> m_counts;  ///< of each block in that order
};

/// Sends one warning "`where`: grid 'name': ..." with the numbers of cleaned values, if there are any.
void reportCleaning(const SparseField& field, const std::string& where, const MessageSink& messages);

/// Collects a field piece by piece, where the pieces are not known beforehand.
class FieldBuilder {
  public:
    FieldBuilder(std::string name, const Mat4& wsFromIs);

    /// Adds a block. `values`: 512 values in `blockOffset` order, which are copied. finish() checks
    /// the rules of FieldPieces.
    void addBlock(const Int3& origin, const float* values);
    void addTile(const ConstantTile& tile);

    const std::string& name() const { return m_pieces.name; }

    /// Returns the field, as `buildField` does. The builder is empty afterwards. It gives its own
    /// memory back to the system while it fills that of the field.
    SparseField finish(BlockMemory& memory);
    SparseField finish();

  private:
    FieldPieces m_pieces;
    BlockMemory m_memory;
    std::vector<std::shared_ptr<float[]>> m_chunks;  ///< the values of so many blocks each
};

}  // namespace scrim
