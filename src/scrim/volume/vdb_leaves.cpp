// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_leaves.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <new>
#include <numeric>
#include <span>
#include <vector>

#include <blosc.h>
#include <zlib.h>

namespace scrim {
namespace {

/// Bytes that are read at once: many leaves, and little enough for a processor's cache.
constexpr std::size_t kChunk = 512 << 10;
/// Leaves that are worth a thread.
constexpr std::size_t kLeavesPerThread = 256;
constexpr std::size_t kMaskBytes = kBlockVoxels / 8;

/// What a leaf says about its inactive voxels (openvdb/io/Compression.h).
enum InactiveValues : std::int8_t {
    kOneInactive = 2,
    kMask = 3,
    kMaskAndOneInactive = 4,
    kMaskAndTwoInactive = 5,
    kAllValues = 6,
};

/// A leaf in the bytes of a chunk.
struct PackedLeaf {
    const char* mask = nullptr;
    const char* data = nullptr;
    std::size_t bytes = 0;  ///< at `data`
    std::size_t count = 0;  ///< voxels that have values
    bool packed = false;    ///< `data` is compressed
    const char* end = nullptr;
};

enum class Found { leaf, partOfLeaf, nonsense };

std::array<std::uint64_t, kBlockVoxels / 64> maskAt(const char* at) {
    std::array<std::uint64_t, kBlockVoxels / 64> mask;
    std::memcpy(mask.data(), at, kMaskBytes);
    return mask;
}

/// Finds the parts of the leaf that begins with `bytes`.
Found findLeaf(std::span<const char> bytes, const LeafFormat& format, PackedLeaf& leaf) {
    std::size_t at = kMaskBytes + 1;
    if (bytes.size() < at) return Found::partOfLeaf;
    leaf.mask = bytes.data();
    const auto inactive = static_cast<std::int8_t>(bytes[kMaskBytes]);
    const std::size_t value = sizeof(float) * std::size_t(format.channels);
    if (inactive == kOneInactive || inactive == kMaskAndOneInactive) at += value;
    if (inactive == kMaskAndTwoInactive) at += 2 * value;
    if (inactive == kMask || inactive == kMaskAndOneInactive || inactive == kMaskAndTwoInactive) at += kMaskBytes;
    const auto mask = maskAt(leaf.mask);
    leaf.count = kBlockVoxels;
    if (format.masked && inactive != kAllValues)
        leaf.count = std::accumulate(mask.begin(), mask.end(), std::size_t{0}, [](std::size_t sum, std::uint64_t word) {
            return sum + std::size_t(std::popcount(word));
        });
    const std::size_t unpacked = leaf.count * (format.half ? value / 2 : value);
    leaf.bytes = unpacked;
    leaf.packed = false;
    const bool isEmpty = format.half && leaf.count == 0;  // of which OpenVDB writes nothing
    if (format.codec != LeafFormat::Codec::none && !isEmpty) {
        std::int64_t size = 0;
        if (bytes.size() < at + sizeof size) return Found::partOfLeaf;
        std::memcpy(&size, bytes.data() + at, sizeof size);
        at += sizeof size;
        leaf.packed = size > 0;  // what would not become smaller is not compressed
        if (leaf.packed) leaf.bytes = static_cast<std::size_t>(size);
        if (leaf.bytes > kChunk / 2 || (!leaf.packed && size != -static_cast<std::int64_t>(unpacked)))
            return Found::nonsense;
    }
    if (bytes.size() < at || bytes.size() - at < leaf.bytes) return Found::partOfLeaf;
    leaf.data = bytes.data() + at;
    leaf.end = leaf.data + leaf.bytes;
    return Found::leaf;
}

/// The number that 16 bits stand for. Written so that compilers vectorise it, and without denormal floats, which count
/// as 0 in parallel loops.
float fromHalf(std::uint16_t half) {
    constexpr std::uint32_t kBias = (127 - 15) << 23, kInfinity = 0x7F800000;
    const std::uint32_t magnitude = half & 0x7FFFU;
    const std::uint32_t normal = magnitude >= 0x7C00U ? kInfinity | magnitude << 13 : (magnitude << 13) + kBias;
    const auto small =
        std::bit_cast<std::uint32_t>(static_cast<float>(static_cast<std::int32_t>(magnitude)) * 0x1p-24f);
    return std::bit_cast<float>((magnitude < 0x400U ? small : normal) | std::uint32_t{half & 0x8000U} << 16);
}

/// Unpacks leaves; one for each thread.
class Unpacker {
  public:
    explicit Unpacker(const LeafFormat& format)
        : m_format(format), m_halves(kBlockVoxels * std::size_t(format.channels)), m_floats(m_halves.size()) {
        if (m_format.codec == LeafFormat::Codec::zip && ::inflateInit(&m_zip) != Z_OK) throw std::bad_alloc();
    }
    ~Unpacker() {
        if (m_format.codec == LeafFormat::Codec::zip) ::inflateEnd(&m_zip);
    }
    Unpacker(const Unpacker&) = delete;
    Unpacker& operator=(const Unpacker&) = delete;

    /// The values, which live until the next call; false: the data is damaged.
    bool unpack(const PackedLeaf& leaf, LeafValues& out) {
        const std::size_t numbers = leaf.count * std::size_t(m_format.channels);
        char* const to =
            m_format.half ? reinterpret_cast<char*>(m_halves.data()) : reinterpret_cast<char*>(m_floats.data());
        const std::size_t bytes = numbers * (m_format.half ? sizeof(std::uint16_t) : sizeof(float));
        if (!leaf.packed)
            std::memcpy(to, leaf.data, bytes);
        else if (!(m_format.codec == LeafFormat::Codec::zip ? unzip(leaf, to, bytes) : unblosc(leaf, to, bytes)))
            return false;
        if (m_format.half)
            for (std::size_t i = 0; i < numbers; ++i) m_floats[i] = fromHalf(m_halves[i]);
        out.active = maskAt(leaf.mask);
        out.values = m_floats.data();
        out.channels = m_format.channels;
        out.all = leaf.count == kBlockVoxels;
        return true;
    }

  private:
    bool unzip(const PackedLeaf& leaf, char* to, std::size_t bytes) {
        if (::inflateReset(&m_zip) != Z_OK) return false;
        m_zip.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(leaf.data));  // it is only read
        m_zip.avail_in = static_cast<uInt>(leaf.bytes);
        m_zip.next_out = reinterpret_cast<Bytef*>(to);
        m_zip.avail_out = static_cast<uInt>(bytes);
        return ::inflate(&m_zip, Z_FINISH) == Z_STREAM_END && m_zip.avail_out == 0;
    }
    static bool unblosc(const PackedLeaf& leaf, char* to, std::size_t bytes) {
        std::size_t unpacked = 0;
        return ::blosc_cbuffer_validate(leaf.data, leaf.bytes, &unpacked) >= 0 && unpacked == bytes &&
               ::blosc_decompress_ctx(leaf.data, to, bytes, 1) == static_cast<int>(bytes);
    }

    LeafFormat m_format;
    std::vector<std::uint16_t> m_halves;
    std::vector<float> m_floats;
    z_stream m_zip{};
};

/// Some leaves that follow one another, and their bytes.
struct Chunk {
    std::vector<char> bytes = std::vector<char>(kChunk);
    std::size_t first = 0;
    std::vector<PackedLeaf> leaves;
};

/// Divides leaves among threads, chunk by chunk.
class LeafStream {
  public:
    LeafStream(const VdbBytes& file, std::uint64_t begin, std::uint64_t end, std::size_t count,
               const LeafFormat& format)
        : m_file(file), m_at(begin), m_end(end), m_count(count), m_format(format) {}

    /// Returns false where no leaves are left, or where something is wrong.
    bool next(Chunk& chunk) {
        const std::scoped_lock lock(m_mutex);
        chunk.leaves.clear();
        if (m_broken || m_next == m_count) return false;
        const std::uint64_t size = std::min<std::uint64_t>(kChunk, m_end - m_at);
        const std::span<const char> bytes(chunk.bytes.data(), size);
        m_file.copy(m_at, size, chunk.bytes.data());
        chunk.first = m_next;
        std::size_t done = 0;
        for (PackedLeaf leaf; m_next < m_count; ++m_next) {
            const Found found = findLeaf(bytes.subspan(done), m_format, leaf);
            if (found == Found::nonsense) fail();
            if (found != Found::leaf) break;
            chunk.leaves.push_back(leaf);
            done = static_cast<std::size_t>(leaf.end - bytes.data());
        }
        m_at += done;
        if (chunk.leaves.empty()) fail();
        return !m_broken;
    }
    void fail() { m_broken = true; }
    bool isWhole() const { return !m_broken && m_next == m_count && m_at == m_end; }

  private:
    const VdbBytes& m_file;
    std::mutex m_mutex;
    std::uint64_t m_at, m_end;
    std::size_t m_next = 0, m_count;
    LeafFormat m_format;
    std::atomic<bool> m_broken = false;
};

}  // namespace

bool readLeaves(const VdbBytes& file, std::uint64_t begin, std::uint64_t end, std::size_t count,
                const LeafFormat& format, const std::function<void(std::size_t, const LeafValues&)>& visit) {
    LeafStream stream(file, begin, end, count, format);
    const std::size_t threads =
        std::clamp<std::size_t>(count / kLeavesPerThread, 1, static_cast<std::size_t>(threadCount()));
    parallelFor(threads, [&](std::size_t) {
        Unpacker unpacker(format);
        LeafValues values;
        try {
            for (Chunk chunk; stream.next(chunk);)
                for (std::size_t i = 0; i < chunk.leaves.size(); ++i)
                    if (unpacker.unpack(chunk.leaves[i], values))
                        visit(chunk.first + i, values);
                    else
                        return stream.fail();
        } catch (...) {
            stream.fail();  // the others need not go on
            throw;
        }
    });
    return stream.isWhole();
}

}  // namespace scrim
