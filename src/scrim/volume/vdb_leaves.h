// SPDX-License-Identifier: Apache-2.0
// Internal: the values of a tree's leaves, straight from a .vdb file and on all threads.
//
// OpenVDB reads one leaf after another through a stream. Nearly all of a file is leaves, and each says how long it is:
// so one thread can find where they begin while others unpack them. vdb_tree.h reads what lies above them.
#pragma once

#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_bytes.h>
#include <scrim/volume/vdb_packed.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace scrim {

/// The unpacked values of one leaf.
struct LeafValues {
    std::array<std::uint64_t, kBlockVoxels / 64> active{};  ///< a bit for each voxel, in `blockOffset` order
    const float* values = nullptr;  ///< of all voxels, or of the active ones; `channels` numbers for each
    int channels = 1;
    bool all = false;

    /// Writes numberOf(value) of one channel for active voxels, and 0 for all others.
    template <typename NumberOf>
    void fill(int channel, const NumberOf& numberOf, float* block) const {
        const float* from = values + channel;
        for (std::uint64_t word : active) {
            if (word == ~std::uint64_t{0} && channels == 1) {
                for (int n = 0; n < 64; ++n) block[n] = numberOf(from[n]);
                from += 64;
            } else if (all) {
                for (int n = 0; n < 64; ++n, from += channels) block[n] = (word >> n & 1) != 0 ? numberOf(*from) : 0.0f;
            } else {
                for (int n = 0; n < 64; ++n) block[n] = 0;
                for (; word != 0; word &= word - 1, from += channels) block[std::countr_zero(word)] = numberOf(*from);
            }
            block += 64;
        }
    }
};

/// Reads `count` leaves, which fill the bytes [begin, end) of the file, and calls visit(i, values) for leaf i, once for
/// each, in any order and from several threads at a time. Returns false where the bytes are something else. Throws
/// Error(input) where the disk fails, std::bad_alloc, and whatever `visit` throws.
bool readLeaves(const VdbBytes& file, std::uint64_t begin, std::uint64_t end, std::size_t count,
                const ValueFormat& format, const std::function<void(std::size_t, const LeafValues&)>& visit);

}  // namespace scrim
