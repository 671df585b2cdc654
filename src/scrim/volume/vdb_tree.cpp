// SPDX-License-Identifier: Apache-2.0
// The order of the bytes is that of openvdb/io/Archive.cc and of `readTopology` in openvdb/tree.
#include <scrim/volume/vdb_tree.h>

#include <scrim/volume/vdb_map.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <span>
#include <tuple>

namespace scrim {
namespace {

/// The first and the last version whose nodes are stored as they are read here (openvdb/version.h,
/// OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION and OPENVDB_FILE_VERSION of OpenVDB 5 to 12).
constexpr std::uint32_t kOldest = 222, kNewest = 224;
// Flags of openvdb::io.
constexpr std::uint32_t kZip = 0x1, kActiveMask = 0x2, kBlosc = 0x4;
constexpr const char* kNode = "a node";

/// The nodes of two levels above the leaves: voxels along the edge of a child, and children along that of the node.
struct Level {
    int childEdge;
    int edge;  ///< in children
    std::size_t size() const { return std::size_t(edge) * std::size_t(edge) * std::size_t(edge); }
};
constexpr Level kUpper{128, 32}, kLower{8, 16};
constexpr int kRootEdge = kUpper.childEdge * kUpper.edge;
constexpr std::size_t kLeafBytes = 8 * 8 * 8 / 8;  // a leaf's mask, which stands before its values once more

/// Ascending as in the maps of OpenVDB's roots.
bool isBefore(const Int3& a, const Int3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// What a grid's metadata says; no value where it is unusual.
struct Head {
    std::string name;
    std::string gridClass = "unknown";
    bool half = false;
    std::uint32_t compression = 0;
    std::string map;
};

std::string wordAt(VdbWalker& walk, std::uint32_t size) {
    std::string word(size, '\0');
    for (char& letter : word) letter = walk.number<char>("a metadata value");
    return word;
}

/// Reads what lies before the transform's numbers.
std::optional<Head> readHead(VdbWalker& walk) {
    constexpr std::uint32_t kLongest = 1000;
    Head head;
    (void)walk.text("a grid's name");
    const bool savedAsHalf = walk.text("a grid's type").ends_with("_HalfFloat");
    (void)walk.text("a grid's instance parent");
    walk.skip(3 * sizeof(std::uint64_t), "a grid's offsets");
    head.compression = walk.number<std::uint32_t>("a grid's compression");
    bool usual = true;
    int names = 0, classes = 0;
    walk.metadata([&](const std::string& name, const std::string& type, std::uint32_t size) {
        const bool isName = name == "name", isClass = name == "class";
        if (isName || isClass) {
            usual = usual && type == "string" && size <= kLongest && ++(isName ? names : classes) == 1;
            if (usual) (isName ? head.name : head.gridClass) = wordAt(walk, size);
        }
        if (name != "is_saved_as_half_float") return;
        usual = usual && type == "bool" && size == 1;
        if (usual) head.half = walk.number<char>("a metadata value") != 0;
    });
    constexpr std::array<const char*, 4> kClasses{"unknown", "level set", "fog volume", "staggered"};
    usual = usual && head.half == savedAsHalf &&
            std::find(kClasses.begin(), kClasses.end(), head.gridClass) != kClasses.end();
    head.map = walk.text("a grid's transform");
    return usual ? std::optional<Head>(std::move(head)) : std::nullopt;
}

ValueFormat formatOf(const Head& head, int channels) {
    ValueFormat format;
    format.codec = (head.compression & kBlosc) != 0 ? ValueFormat::Codec::blosc
                   : (head.compression & kZip) != 0 ? ValueFormat::Codec::zip
                                                    : ValueFormat::Codec::none;
    format.masked = (head.compression & kActiveMask) != 0;
    format.half = head.half;
    format.channels = channels;
    return format;
}

/// Bytes of the file, many at a time.
class Window {
  public:
    Window(const VdbBytes& file, std::uint64_t end) : m_file(file), m_end(end), m_bytes(kBytes) {}

    /// Up to `most` bytes from position `at` on, fewer only at the end.
    std::span<const char> see(std::uint64_t at, std::size_t most) {
        const std::uint64_t wanted = std::min<std::uint64_t>(most, m_end - std::min(at, m_end));
        if (at < m_at || at + wanted > m_at + m_size) {
            m_size = 0;  // in case the next line throws
            if (most > m_bytes.size()) m_bytes.resize(most);
            const std::uint64_t size = std::min<std::uint64_t>(m_bytes.size(), m_end - std::min(at, m_end));
            m_file.copy(at, size, m_bytes.data());
            m_at = at;
            m_size = size;
        }
        return {m_bytes.data() + (at - m_at), static_cast<std::size_t>(wanted)};
    }

  private:
    static constexpr std::size_t kBytes = 256 << 10;
    const VdbBytes& m_file;
    std::uint64_t m_end, m_at = 0, m_size = 0;
    std::vector<char> m_bytes;
};

/// The bits of a mask in the bytes of a file, word by word.
std::uint64_t wordOf(const char* mask, std::size_t i) {
    std::uint64_t word = 0;
    std::memcpy(&word, mask + i * sizeof word, sizeof word);
    return word;
}

/// Walks a tree down to its leaves. Every function returns false where something is unusual.
class TreeWalk {
  public:
    TreeWalk(const VdbBytes& file, std::uint64_t at, std::uint64_t end, VdbTree& tree)
        : m_file(file),
          m_at(at),
          m_end(end),
          m_tree(tree),
          m_window(file, end),
          m_unpacker(tree.format, kUpper.size()) {}

    std::uint64_t at() const { return m_at; }

    bool root() {
        VdbWalker walk(m_file, m_at);
        if (walk.number<std::int32_t>("a tree") != 1) return false;  // the number of its buffers
        walk.skip(m_tree.format.bytes(), "a tree");                  // the background
        const auto tiles = walk.number<std::uint32_t>("a tree"), children = walk.number<std::uint32_t>("a tree");
        Place last;
        for (std::uint32_t i = 0; i < tiles; ++i)
            if (!rootTile(walk, last)) return false;
        m_at = walk.at();
        last = {};
        for (std::uint32_t i = 0; i < children; ++i) {
            VdbWalker place(m_file, m_at);
            const auto origin = place.number<Int3>(kNode);
            m_at = place.at();
            if (!last.isFollowedBy(origin) || !node(origin, kUpper)) return false;
        }
        return m_at <= m_end;
    }

  private:
    /// An origin at the top of a tree.
    struct Place {
        std::optional<Int3> origin;
        bool isFollowedBy(const Int3& next) {
            for (int i = 0; i < 3; ++i)
                if (next[i] % kRootEdge != 0) return false;
            const bool follows = !origin || isBefore(*origin, next);
            origin = next;
            return follows;
        }
    };

    bool rootTile(VdbWalker& walk, Place& last) {
        VdbTree::Tile tile;
        tile.origin = walk.number<Int3>(kNode);
        tile.edge = kRootEdge;
        for (int c = 0; c < m_tree.format.channels; ++c) tile.value.at(std::size_t(c)) = walk.number<float>(kNode);
        const auto active = walk.number<std::uint8_t>(kNode);
        if (active == 1) m_tree.tiles.push_back(tile);
        return active <= 1 && last.isFollowedBy(tile.origin);
    }

    bool node(const Int3& origin, const Level& level) {
        const std::size_t maskBytes = level.size() / 8;
        const std::span<const char> bytes =
            m_window.see(m_at, maskBytes + mostPackedBytes(m_tree.format, level.size()));
        if (bytes.size() < 2 * maskBytes) return false;
        PackedValues values;
        if (findValues(bytes.subspan(maskBytes), m_tree.format, level.size(), values) != Found::values) return false;
        const std::vector<char> children(bytes.data(), bytes.data() + maskBytes);
        if (!nodeTiles(origin, level, children.data(), values)) return false;
        m_at += static_cast<std::uint64_t>(values.end - bytes.data());
        for (std::size_t w = 0; w < level.size() / 64; ++w)
            for (std::uint64_t word = wordOf(children.data(), w); word != 0; word &= word - 1) {
                const Int3 child = placeIn(origin, level, 64 * w + std::size_t(std::countr_zero(word)));
                if (level.childEdge == kLower.childEdge) {
                    m_tree.leaves.push_back(child);
                    m_at += kLeafBytes;
                } else if (!node(child, kLower)) {
                    return false;
                }
            }
        return m_at <= m_end;
    }

    /// Takes the active tiles of a node. Its mask is that of `values`.
    bool nodeTiles(const Int3& origin, const Level& level, const char* children, const PackedValues& values) {
        bool any = false;
        for (std::size_t w = 0; w < level.size() / 64; ++w) {
            const std::uint64_t active = wordOf(values.mask, w);
            if ((active & wordOf(children, w)) != 0) return false;
            any = any || active != 0;
        }
        if (!any) return true;
        const float* const numbers = m_unpacker.unpack(values);
        if (numbers == nullptr) return false;
        std::size_t stored = 0;
        for (std::size_t w = 0; w < level.size() / 64; ++w)
            for (std::uint64_t word = wordOf(values.mask, w); word != 0; word &= word - 1, ++stored) {
                const std::size_t place = 64 * w + std::size_t(std::countr_zero(word));
                const auto channels = static_cast<std::size_t>(m_tree.format.channels);
                VdbTree::Tile tile{placeIn(origin, level, place), level.childEdge};
                std::copy_n(numbers + (values.all ? place : stored) * channels, channels, tile.value.begin());
                m_tree.tiles.push_back(tile);
            }
        return true;
    }

    static Int3 placeIn(const Int3& origin, const Level& level, std::size_t n) {
        const auto place = static_cast<int>(n);
        return origin + level.childEdge * Int3(place / (level.edge * level.edge), place / level.edge % level.edge,
                                               place % level.edge);
    }

    const VdbBytes& m_file;
    std::uint64_t m_at, m_end;
    VdbTree& m_tree;
    Window m_window;
    Unpacker m_unpacker;
};

}  // namespace

std::optional<VdbTree> readVdbTree(const VdbBytes& file, const VdbLayout& layout, const VdbLayout::Grid& grid) {
    const int channels = grid.type == kVdbFloats ? 1 : grid.type == kVdbVectors ? 3 : 0;
    if (layout.isNano || layout.fileVersion < kOldest || layout.fileVersion > kNewest || grid.instance || channels == 0)
        return {};
    VdbWalker walk(file, grid.begin);
    const std::optional<Head> head = readHead(walk);
    if (!head) return {};
    const std::optional<Mat4> wsFromIs = readVdbMap(walk, head->map);
    if (!wsFromIs) return {};
    VdbTree tree;
    tree.name = head->name;
    tree.isLevelSet = head->gridClass == "level set";
    tree.isStaggered = head->gridClass == "staggered";
    tree.wsFromIs = *wsFromIs;
    tree.format = formatOf(*head, channels);
    TreeWalk nodes(file, walk.at(), grid.end, tree);
    if (!nodes.root()) return {};
    tree.leavesAt = nodes.at();
    return tree;
}

}  // namespace scrim
