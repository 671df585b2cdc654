// SPDX-License-Identifier: Apache-2.0
// Internal: a stream over the bytes of a .vdb file that hold the grids which somebody wants, and
// nothing else. It reads piece by piece, so that a file is never in memory as a whole.
#pragma once

#include <scrim/volume/grid_request.h>
#include <scrim/volume/vdb_bytes.h>
#include <scrim/volume/vdb_layout.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <streambuf>
#include <string>
#include <vector>

namespace scrim {

/// The indices of the grids that `requests` need, and of those called `others`, in the file's
/// order. No value where the whole file must be read, because it does not say where its grids are,
/// or one of the grids shares the voxels of another.
std::optional<std::vector<std::size_t>> neededGrids(const VdbLayout& layout, const std::vector<GridRequest>& requests,
                                                    const std::vector<std::string>& others);

/// With the seeking that OpenVDB's point grids need. Refers to the file, which must outlive it.
class VdbStream : public std::streambuf {
  public:
    /// The bytes [begin, end) of the file.
    VdbStream(const VdbBytes& file, std::uint64_t begin, std::uint64_t end);
    /// The whole file, as one of version `version`.
    VdbStream(const VdbBytes& file, std::uint32_t version);
    /// A file of that version which contains only the grids of `file` at `places`. The offsets in
    /// the descriptors are those of the original, but OpenVDB's stream does not use them.
    VdbStream(const VdbBytes& file, std::uint32_t version, const VdbLayout& layout,
              const std::vector<std::size_t>& places);

    VdbStream(const VdbStream&) = delete;
    VdbStream& operator=(const VdbStream&) = delete;

    std::uint64_t size() const { return m_size; }
    /// The bytes before the next one.
    std::uint64_t position() const { return m_windowEnd - static_cast<std::uint64_t>(egptr() - gptr()); }

  protected:
    int_type underflow() override;
    pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode mode) override;
    pos_type seekpos(pos_type at, std::ios_base::openmode mode) override {
        return seekoff(off_type(at), std::ios_base::beg, mode);
    }

  private:
    /// A part of the stream: these bytes, or those of the file from `at` on.
    struct Piece {
        std::string bytes;
        std::uint64_t at = 0;
        std::uint64_t size = 0;
    };
    void add(std::string bytes);
    void add(std::uint64_t begin, std::uint64_t end);

    const VdbBytes& m_file;
    std::vector<Piece> m_pieces;
    std::uint64_t m_size = 0;
    std::vector<char> m_window;
    std::uint64_t m_windowEnd = 0;  ///< position in the stream
};

}  // namespace scrim
