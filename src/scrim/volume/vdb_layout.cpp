// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_layout.h>

#include <scrim/base/error.h>

#include <algorithm>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

namespace scrim {

namespace {

constexpr std::uint64_t kMagic = 0x56444220;    ///< openvdb::OPENVDB_MAGIC, as a little-endian 64-bit number
constexpr std::uint32_t kOldestChecked = 222;   ///< compression flags moved into the grids: the layout below
constexpr std::uint32_t kOldestReadable = 211;  ///< the first to carry library versions
constexpr std::uint32_t kNewestReadable = 224;  ///< OPENVDB_FILE_VERSION of OpenVDB 5 to 12
constexpr std::uint32_t kZip = 0x1;             ///< openvdb::io::COMPRESS_ZIP
constexpr std::uint32_t kActiveValues = 0x2;    ///< openvdb::io::COMPRESS_ACTIVE_MASK
constexpr std::uint32_t kBlosc = 0x4;           ///< openvdb::io::COMPRESS_BLOSC
constexpr std::size_t kUuidBytes = 36;
constexpr std::string_view kHalfSuffix = "_HalfFloat";  ///< GridDescriptor: appended to the type of grids saved as half
constexpr char kNameSeparator = '\x1e';                 ///< GridDescriptor: unique name = name, this, number

class Walker {
  public:
    Walker(const std::string& path, std::span<const char> bytes) : m_path(path), m_bytes(bytes) {}

    template <typename T>
    T number(const char* what) {
        need(sizeof(T), what);
        T value;
        std::memcpy(&value, m_bytes.data() + m_at, sizeof(T));
        m_at += sizeof(T);
        return value;
    }

    std::string text(const char* what) {
        const auto size = number<std::uint32_t>(what);
        need(size, what);
        std::string value(m_bytes.data() + m_at, size);
        m_at += size;
        return value;
    }

    void skip(std::uint64_t size, const char* what) {
        need(size, what);
        m_at += size;
    }

    /// A map of metadata: names, types and values of a stated size.
    void metadata() {
        const auto count = number<std::uint32_t>("the metadata");
        // An entry takes at least three lengths.
        if (count > (m_bytes.size() - m_at) / 12) damaged(fmt::format("it claims {} entries of metadata", count));
        for (std::uint32_t i = 0; i < count; ++i) {
            text("a metadata name");
            text("a metadata type");
            const auto size = number<std::uint32_t>("a metadata value");
            skip(size, "a metadata value");
        }
    }

    std::uint64_t at() const { return m_at; }
    void goTo(std::uint64_t at) { m_at = at; }
    std::uint64_t size() const { return m_bytes.size(); }

    [[noreturn]] void damaged(const std::string& reason) const {
        throw Error(ErrorKind::input, clipped(m_path + ": truncated or damaged: " + reason, 1000));
    }

  private:
    void need(std::uint64_t size, const char* what) const {
        if (size > m_bytes.size() - m_at)
            damaged(fmt::format("{} at byte {} needs {} bytes, the file ends after {}", what, m_at, size,
                                m_bytes.size() - m_at));
    }

    const std::string& m_path;
    std::span<const char> m_bytes;
    std::uint64_t m_at = 0;
};

void checkMagic(const std::string& path, std::span<const char> bytes) {
    std::uint64_t magic = 0;
    if (bytes.size() >= sizeof magic) std::memcpy(&magic, bytes.data(), sizeof magic);
    if (magic == kMagic) return;
    if (bytes.empty()) throw Error(ErrorKind::input, path + ": not a VDB file (it is empty)");
    const std::string start = clipped(std::string_view(bytes.data(), std::min<std::size_t>(bytes.size(), 8)));
    throw Error(ErrorKind::input, fmt::format("{}: not a VDB file (starts with '{}')", path, start));
}

std::string codecName(std::uint32_t flags) {
    std::string name;
    const auto add = [&](std::uint32_t flag, const char* word) {
        if ((flags & flag) != 0) name += (name.empty() ? "" : " + ") + std::string(word);
    };
    add(kZip, "zip");
    add(kBlosc, "blosc");
    add(kActiveValues, "active values");
    return name.empty() ? "none" : name;
}

/// One grid's descriptor and the head of its data; leaves `walk` at the grid's end.
VdbLayout::Grid walkGrid(Walker& walk) {
    VdbLayout::Grid grid;
    grid.name = walk.text("a grid's name");
    grid.name = grid.name.substr(0, grid.name.find(kNameSeparator));
    grid.type = walk.text("a grid's type");
    if (grid.type.ends_with(kHalfSuffix)) grid.type.resize(grid.type.size() - kHalfSuffix.size());
    const bool instance = !walk.text("a grid's instance parent").empty();
    const auto gridAt = walk.number<std::uint64_t>("a grid's offsets");
    const auto blocksAt = walk.number<std::uint64_t>("a grid's offsets");
    const auto endAt = walk.number<std::uint64_t>("a grid's offsets");
    const std::string quoted = "grid '" + clipped(grid.name, 80) + "'";
    if (gridAt != walk.at() || endAt < gridAt || (!instance && (blocksAt < gridAt || blocksAt > endAt)))
        walk.damaged(quoted + " has offsets that contradict each other");
    if (endAt > walk.size())
        walk.damaged(fmt::format("{} ends at byte {}, the file at byte {}", quoted, endAt, walk.size()));
    const auto compression = walk.number<std::uint32_t>("a grid's compression");
    if ((compression & ~(kZip | kActiveValues | kBlosc)) != 0)
        walk.damaged(fmt::format("{} has unknown compression flags {:#x}", quoted, compression));
    grid.codec = codecName(compression);
    walk.metadata();
    walk.text("a grid's transform");
    walk.goTo(endAt);
    return grid;
}

}  // namespace

VdbLayout checkVdbLayout(const std::string& path, std::span<const char> bytes) {
    checkMagic(path, bytes);
    Walker walk(path, bytes);
    walk.skip(sizeof(kMagic), "the header");
    VdbLayout layout;
    layout.fileVersion = walk.number<std::uint32_t>("the header");
    if (layout.fileVersion < kOldestReadable || layout.fileVersion > kNewestReadable)
        throw Error(ErrorKind::input, fmt::format("{}: VDB file version {} (versions {} to {} can be read)", path,
                                                  layout.fileVersion, kOldestReadable, kNewestReadable));
    layout.libraryMajor = walk.number<std::uint32_t>("the header");
    layout.libraryMinor = walk.number<std::uint32_t>("the header");
    if (layout.fileVersion < kOldestChecked) return layout;

    layout.hasOffsets = walk.number<char>("the header") != 0;
    walk.skip(kUuidBytes, "the header");
    walk.metadata();
    const auto count = walk.number<std::int32_t>("the number of grids");
    // A descriptor takes at least three lengths; with offsets three of those too.
    if (count < 0 || static_cast<std::uint64_t>(count) > (walk.size() - walk.at()) / 12)
        walk.damaged(fmt::format("it claims {} grids", count));
    if (!layout.hasOffsets) return layout;
    for (std::int32_t i = 0; i < count; ++i) layout.grids.push_back(walkGrid(walk));
    if (walk.at() != walk.size())
        walk.damaged(fmt::format("its grids end at byte {}, the file at byte {}", walk.at(), walk.size()));
    return layout;
}

}  // namespace scrim
