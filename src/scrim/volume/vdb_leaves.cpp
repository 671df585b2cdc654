// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_leaves.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <span>
#include <vector>

namespace scrim {
namespace {

/// Bytes that are read at once: many leaves, and little enough for a processor's cache.
constexpr std::size_t kChunk = 512 << 10;
/// Leaves that are worth a thread.
constexpr std::size_t kLeavesPerThread = 256;

/// Some leaves that follow one another, and their bytes.
struct Chunk {
    std::vector<char> bytes = std::vector<char>(kChunk);
    std::size_t first = 0;
    std::vector<PackedValues> leaves;
};

/// Divides leaves among threads, chunk by chunk.
class LeafStream {
  public:
    LeafStream(const VdbBytes& file, std::uint64_t begin, std::uint64_t end, std::size_t count,
               const ValueFormat& format)
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
        for (PackedValues leaf; m_next < m_count; ++m_next) {
            const Found found = findValues(bytes.subspan(done), m_format, kBlockVoxels, leaf);
            if (found == Found::nonsense) fail();
            if (found != Found::values) break;
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
    ValueFormat m_format;
    std::atomic<bool> m_broken = false;
};

}  // namespace

bool readLeaves(const VdbBytes& file, std::uint64_t begin, std::uint64_t end, std::size_t count,
                const ValueFormat& format, const std::function<void(std::size_t, const LeafValues&)>& visit) {
    LeafStream stream(file, begin, end, count, format);
    const std::size_t threads =
        std::clamp<std::size_t>(count / kLeavesPerThread, 1, static_cast<std::size_t>(threadCount()));
    parallelFor(threads, [&](std::size_t) {
        Unpacker unpacker(format, kBlockVoxels);
        LeafValues values;
        values.channels = format.channels;
        try {
            for (Chunk chunk; stream.next(chunk);)
                for (std::size_t i = 0; i < chunk.leaves.size(); ++i) {
                    const PackedValues& leaf = chunk.leaves[i];
                    values.values = unpacker.unpack(leaf);
                    if (values.values == nullptr) return stream.fail();
                    std::memcpy(values.active.data(), leaf.mask, sizeof values.active);
                    values.all = leaf.all;
                    visit(chunk.first + i, values);
                }
        } catch (...) {
            stream.fail();  // the others need not go on
            throw;
        }
    });
    return stream.isWhole();
}

}  // namespace scrim
