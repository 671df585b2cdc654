// SPDX-License-Identifier: Apache-2.0
// Internal: the values of a node of a tree, as .vdb files hold them (openvdb/io/Compression.h): packed, and mostly
// without those of inactive voxels. They are found and unpacked without OpenVDB, and safely on any bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace scrim {

/// How the values of a grid are stored.
struct ValueFormat {
    enum class Codec { none, zip, blosc };
    Codec codec = Codec::none;
    int channels = 1;     ///< floats of a value
    bool half = false;    ///< in 16 bits each
    bool masked = false;  ///< mostly without inactive values

    std::size_t bytes() const { return sizeof(float) * static_cast<std::size_t>(channels); }
};

/// The values of a node among the bytes of a file.
struct PackedValues {
    const char* mask = nullptr;  ///< of active values, a bit for each
    const char* data = nullptr;
    std::size_t bytes = 0;  ///< at `data`
    std::size_t count = 0;  ///< values that are stored
    bool all = false;       ///< these are all of the node, else the active ones
    bool packed = false;    ///< `data` is compressed
    const char* end = nullptr;
};

enum class Found { values, partOfThem, nonsense };

/// Finds the parts of what begins with the mask of a node of `size` values, a multiple of 64.
Found findValues(std::span<const char> bytes, const ValueFormat& format, std::size_t size, PackedValues& values);

/// No node takes more bytes than this: with its mask, and packed as badly as can be.
std::size_t mostPackedBytes(const ValueFormat& format, std::size_t size);

/// Unpacks values of nodes of up to `size` values; one for each thread. Throws std::bad_alloc.
class Unpacker {
  public:
    Unpacker(const ValueFormat& format, std::size_t size);
    ~Unpacker();
    Unpacker(const Unpacker&) = delete;
    Unpacker& operator=(const Unpacker&) = delete;

    /// The stored values, channel by channel of one after the other, until the next call; null: the data is damaged.
    const float* unpack(const PackedValues& values);

  private:
    struct Zip;
    bool unpackTo(const PackedValues& values, char* to, std::size_t bytes);

    ValueFormat m_format;
    std::vector<std::uint16_t> m_halves;
    std::vector<float> m_floats;
    std::unique_ptr<Zip> m_zip;
};

}  // namespace scrim
