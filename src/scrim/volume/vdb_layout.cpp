// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_layout.h>

#include <scrim/base/error.h>
#include <scrim/volume/grid_choice.h>
#include <scrim/volume/nano_layout.h>
#include <scrim/volume/point_file.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace scrim {

namespace {

constexpr std::uint64_t kMagic = 0x56444220;  ///< openvdb::OPENVDB_MAGIC, as a little-endian 64-bit number
/// From this version on compression flags are stored in the grids, as the layout below assumes.
constexpr std::uint32_t kOldestChecked = 222;
constexpr std::uint32_t kOldestReadable = 211;  ///< the first version with library versions
constexpr std::uint32_t kNewestKnown = 224;     ///< OPENVDB_FILE_VERSION of OpenVDB 5 to 12
/// Later versions have changed little so far, so reading them is attempted.
constexpr std::uint32_t kNewestTried = 255;
constexpr std::uint32_t kZip = 0x1;           ///< openvdb::io::COMPRESS_ZIP
constexpr std::uint32_t kActiveValues = 0x2;  ///< openvdb::io::COMPRESS_ACTIVE_MASK
constexpr std::uint32_t kBlosc = 0x4;         ///< openvdb::io::COMPRESS_BLOSC
constexpr std::size_t kUuidBytes = 36;
constexpr std::uint32_t kLongestClass = 40;  ///< bytes; the existing classes take 13 at most
constexpr std::uint32_t kLongestCreator = 200;
constexpr std::string_view kHalfSuffix = "_HalfFloat";  ///< GridDescriptor: appended to the type of grids saved as half
constexpr char kNameSeparator = '\x1e';                 ///< GridDescriptor: unique name = name, this, number

void checkMagic(const VdbBytes& bytes) {
    std::array<char, sizeof kMagic> start{};
    const std::uint64_t size = std::min<std::uint64_t>(bytes.size(), start.size());
    bytes.copy(0, size, start.data());
    if (size == start.size() && std::memcmp(start.data(), &kMagic, sizeof kMagic) == 0) return;
    if (size == 0) throw Error(ErrorKind::input, bytes.path() + ": not a VDB file (it is empty)");
    throw Error(ErrorKind::input, fmt::format("{}: not a VDB file (starts with '{}')", bytes.path(),
                                              shortened(std::string_view(start.data(), size))));
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

/// Takes the useful entries from a grid's metadata.
void walkMetadata(VdbWalker& walk, VdbLayout::Grid& grid) {
    walk.metadata([&](const std::string& name, const std::string& type, std::uint32_t size) {
        const auto vector = [&]() -> std::optional<Int3> {
            if (type != "vec3i" || size != sizeof(Int3)) return {};
            return walk.number<Int3>("a metadata value");
        };
        if (name == "file_bbox_min") grid.isLower = vector();
        if (name == "file_bbox_max") grid.isUpper = vector();
        if (name == "class" && type == "string" && size <= kLongestClass) {
            grid.gridClass.clear();
            for (std::uint32_t i = 0; i < size; ++i) grid.gridClass += walk.number<char>("a metadata value");
        }
    });
}

/// Reads one grid's descriptor and the head of its data; leaves `walk` at the grid's end.
VdbLayout::Grid walkGrid(VdbWalker& walk, std::uint64_t fileSize) {
    VdbLayout::Grid grid;
    grid.begin = walk.at();
    grid.name = walk.text("a grid's name");
    grid.name = grid.name.substr(0, grid.name.find(kNameSeparator));
    grid.type = walk.text("a grid's type");
    if (grid.type.ends_with(kHalfSuffix)) grid.type.resize(grid.type.size() - kHalfSuffix.size());
    grid.instance = !walk.text("a grid's instance parent").empty();
    const auto gridAt = walk.number<std::uint64_t>("a grid's offsets");
    const auto blocksAt = walk.number<std::uint64_t>("a grid's offsets");
    const auto endAt = walk.number<std::uint64_t>("a grid's offsets");
    const std::string quoted = "grid '" + shortened(grid.name, 80) + "'";
    if (gridAt != walk.at() || endAt < gridAt || (!grid.instance && (blocksAt < gridAt || blocksAt > endAt)))
        walk.damaged(quoted + " has offsets that contradict each other");
    if (endAt > fileSize) walk.damaged(fmt::format("{} ends at byte {}, the file at byte {}", quoted, endAt, fileSize));
    const auto compression = walk.number<std::uint32_t>("a grid's compression");
    if ((compression & ~(kZip | kActiveValues | kBlosc)) != 0)
        walk.damaged(fmt::format("{} has unknown compression flags {:#x}", quoted, compression));
    grid.codec = codecName(compression);
    walkMetadata(walk, grid);
    grid.map = walk.text("a grid's transform");
    grid.mapAt = walk.at();
    grid.end = endAt;
    walk.goTo(endAt);
    return grid;
}

/// Reads the rest of the file's head and the heads of all grids.
VdbLayout walkGrids(VdbWalker& walk, const VdbBytes& bytes, VdbLayout layout) {
    layout.hasOffsets = walk.number<char>("the header") != 0;
    walk.skip(kUuidBytes, "the header");
    walk.metadata([&](const std::string& name, const std::string& type, std::uint32_t size) {
        if (name != "creator" || type != "string") return;
        for (std::uint32_t i = 0; i < std::min(size, kLongestCreator); ++i)
            layout.creator += walk.number<char>("a metadata value");
    });
    layout.gridsBegin = walk.at();
    const auto count = walk.number<std::int32_t>("the number of grids");
    // A descriptor takes at least three lengths, and with offsets three of those, too.
    if (count < 0 || static_cast<std::uint64_t>(count) > walk.left() / 12)
        walk.damaged(fmt::format("it claims {} grids", count));
    if (!layout.hasOffsets) return layout;
    for (std::int32_t i = 0; i < count; ++i) layout.grids.push_back(walkGrid(walk, bytes.size()));
    if (walk.left() > 0)
        walk.damaged(fmt::format("its grids end at byte {}, the file at byte {}", walk.at(), bytes.size()));
    return layout;
}

VdbLayout layoutOfPoints(const VdbBytes& bytes, std::string format) {
    VdbLayout layout;
    layout.points = std::move(format);
    layout.hasOffsets = true;
    VdbLayout::Grid& grid = layout.grids.emplace_back();
    grid.name = "points";
    grid.type = GridOffer::kPoints;
    grid.codec = "none";
    grid.end = bytes.size();
    return layout;
}

}  // namespace

VdbLayout checkVdbLayout(const VdbBytes& bytes) {
    if (isNanoVdb(bytes)) return checkNanoLayout(bytes);
    if (std::string format = pointFormat(bytes); !format.empty()) return layoutOfPoints(bytes, std::move(format));
    checkMagic(bytes);
    VdbWalker walk(bytes, sizeof kMagic);
    VdbLayout layout;
    layout.fileVersion = walk.number<std::uint32_t>("the header");
    if (layout.fileVersion < kOldestReadable || layout.fileVersion > kNewestTried)
        throw Error(ErrorKind::input, fmt::format("{}: VDB file version {} (versions {} to {} can be read)",
                                                  bytes.path(), layout.fileVersion, kOldestReadable, kNewestKnown));
    layout.isNewer = layout.fileVersion > kNewestKnown;
    layout.libraryMajor = walk.number<std::uint32_t>("the header");
    layout.libraryMinor = walk.number<std::uint32_t>("the header");
    if (layout.fileVersion < kOldestChecked) return layout;
    try {
        return walkGrids(walk, bytes, layout);
    } catch (const Error&) {
        // A version that is unknown here may have the last known layout; where it does not, OpenVDB may still read it.
        if (!layout.isNewer) throw;
        return layout;
    }
}

VdbLayout checkVdbLayout(const std::string& path, std::span<const char> bytes) {
    return checkVdbLayout(VdbBytes(path, bytes));
}

}  // namespace scrim
