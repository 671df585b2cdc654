// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_packed.h>

#include <scrim/base/half_float.h>

#include <bit>
#include <cstring>
#include <new>

#include <blosc.h>
#include <zlib.h>

namespace scrim {
namespace {

/// What a node says about its inactive values (openvdb/io/Compression.h).
enum InactiveValues : std::int8_t {
    kOneInactive = 2,
    kMask = 3,
    kMaskAndOneInactive = 4,
    kMaskAndTwoInactive = 5,
    kAllValues = 6,
};

/// What a codec adds at most to values that it cannot compress.
constexpr std::size_t kMostAdded = 4096;

std::size_t countOf(const char* mask, std::size_t size) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < size / 64; ++i) {
        std::uint64_t word = 0;
        std::memcpy(&word, mask + i * sizeof word, sizeof word);
        count += static_cast<std::size_t>(std::popcount(word));
    }
    return count;
}

}  // namespace

Found findValues(std::span<const char> bytes, const ValueFormat& format, std::size_t size, PackedValues& values) {
    const std::size_t maskBytes = size / 8, value = format.bytes();
    std::size_t at = maskBytes + 1;
    if (bytes.size() < at) return Found::partOfThem;
    values.mask = bytes.data();
    const auto inactive = static_cast<std::int8_t>(bytes[maskBytes]);
    if (inactive == kOneInactive || inactive == kMaskAndOneInactive) at += value;
    if (inactive == kMaskAndTwoInactive) at += 2 * value;
    if (inactive == kMask || inactive == kMaskAndOneInactive || inactive == kMaskAndTwoInactive) at += maskBytes;
    values.count = format.masked && inactive != kAllValues ? countOf(values.mask, size) : size;
    values.all = values.count == size;
    const std::size_t unpacked = values.count * (format.half ? value / 2 : value);
    values.bytes = unpacked;
    values.packed = false;
    const bool isEmpty = format.half && values.count == 0;  // of which OpenVDB writes nothing
    if (format.codec != ValueFormat::Codec::none && !isEmpty) {
        std::int64_t stored = 0;
        if (bytes.size() < at + sizeof stored) return Found::partOfThem;
        std::memcpy(&stored, bytes.data() + at, sizeof stored);
        at += sizeof stored;
        values.packed = stored > 0;  // what would not become smaller is not compressed
        if (values.packed) values.bytes = static_cast<std::size_t>(stored);
        if (values.bytes > unpacked + kMostAdded || (!values.packed && stored != -static_cast<std::int64_t>(unpacked)))
            return Found::nonsense;
    }
    if (bytes.size() < at || bytes.size() - at < values.bytes) return Found::partOfThem;
    values.data = bytes.data() + at;
    values.end = values.data + values.bytes;
    return Found::values;
}

std::size_t mostPackedBytes(const ValueFormat& format, std::size_t size) {
    return 2 * (size / 8) + 1 + (size + 2) * format.bytes() + sizeof(std::int64_t) + kMostAdded;
}

/// A stream of zlib.
struct Unpacker::Zip {
    Zip() {
        if (::inflateInit(&stream) != Z_OK) throw std::bad_alloc();
    }
    ~Zip() { ::inflateEnd(&stream); }
    Zip(const Zip&) = delete;
    Zip& operator=(const Zip&) = delete;

    bool unpack(const PackedValues& values, char* to, std::size_t bytes) {
        if (::inflateReset(&stream) != Z_OK) return false;
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(values.data));  // it is only read
        stream.avail_in = static_cast<uInt>(values.bytes);
        stream.next_out = reinterpret_cast<Bytef*>(to);
        stream.avail_out = static_cast<uInt>(bytes);
        return ::inflate(&stream, Z_FINISH) == Z_STREAM_END && stream.avail_out == 0;
    }

    z_stream stream{};
};

namespace {

bool unblosc(const PackedValues& values, char* to, std::size_t bytes) {
    std::size_t unpacked = 0;
    return ::blosc_cbuffer_validate(values.data, values.bytes, &unpacked) >= 0 && unpacked == bytes &&
           ::blosc_decompress_ctx(values.data, to, bytes, 1) == static_cast<int>(bytes);
}

}  // namespace

Unpacker::Unpacker(const ValueFormat& format, std::size_t size)
    : m_format(format),
      m_halves(format.half ? size * std::size_t(format.channels) : 0),
      m_floats(size * std::size_t(format.channels)) {
    if (m_format.codec == ValueFormat::Codec::zip) m_zip = std::make_unique<Zip>();
}

Unpacker::~Unpacker() = default;

bool Unpacker::unpackTo(const PackedValues& values, char* to, std::size_t bytes) {
    if (values.packed) return m_zip ? m_zip->unpack(values, to, bytes) : unblosc(values, to, bytes);
    std::memcpy(to, values.data, bytes);
    return true;
}

const float* Unpacker::unpack(const PackedValues& values) {
    const std::size_t numbers = values.count * std::size_t(m_format.channels);
    char* const to =
        m_format.half ? reinterpret_cast<char*>(m_halves.data()) : reinterpret_cast<char*>(m_floats.data());
    if (!unpackTo(values, to, numbers * (m_format.half ? sizeof(std::uint16_t) : sizeof(float)))) return nullptr;
    if (m_format.half)
        for (std::size_t i = 0; i < numbers; ++i) m_floats[i] = fromHalf(m_halves[i]);
    return m_floats.data();
}

}  // namespace scrim
