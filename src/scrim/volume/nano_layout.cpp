// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/nano_layout.h>

#include <scrim/base/error.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

namespace scrim {

namespace {

constexpr std::string_view kMagic = "NanoVDB";  ///< then the kind of file
/// What follows it: files of OpenVDB 9 to 11.0 and those of later versions. '1' is a grid without a file around it.
constexpr char kOldFile = '0', kGridAlone = '1', kFile = '2';
/// NanoVDB's major version changes with the layout of grids in memory, which is that in files.
constexpr std::uint32_t kMajor = 32;
constexpr std::uint32_t kLongestName = 1 << 16;
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 37;  ///< of a grid: 128 GB
/// Largest ratios of deflate (zlib's technical details) and of blosc (runs of LZ4), and room for small grids.
constexpr std::uint64_t kMostRatio = 1032, kSlack = 1 << 16;

struct NanoType {
    const char* name;  ///< NanoVDB's
    const char* type;  ///< that of the OpenVDB grid made of it; null: not read
};
/// In the order of nanovdb::GridType.
constexpr std::array<NanoType, 27> kTypes{{
    {"unknown", nullptr},
    {"float", "Tree_float_5_4_3"},
    {"double", "Tree_float_5_4_3"},
    {"int16", "Tree_float_5_4_3"},
    {"int32", "Tree_float_5_4_3"},
    {"int64", "Tree_float_5_4_3"},
    {"Vec3f", "Tree_vec3s_5_4_3"},
    {"Vec3d", "Tree_vec3s_5_4_3"},
    {"Mask", "Tree_float_5_4_3"},
    {"Half", nullptr},
    {"uint32", "Tree_float_5_4_3"},
    {"bool", "Tree_float_5_4_3"},
    {"RGBA8", "Tree_vec3s_5_4_3"},
    {"Fp4", "Tree_float_5_4_3"},
    {"Fp8", "Tree_float_5_4_3"},
    {"Fp16", "Tree_float_5_4_3"},
    {"FpN", "Tree_float_5_4_3"},
    {"Vec4f", "Tree_vec3s_5_4_3"},
    {"Vec4d", "Tree_vec3s_5_4_3"},
    {"Index", nullptr},
    {"OnIndex", nullptr},
    {"IndexMask", nullptr},
    {"OnIndexMask", nullptr},
    {"PointIndex", nullptr},
    {"Vec3u8", nullptr},
    {"Vec3u16", nullptr},
    {"UInt8", nullptr},
}};
constexpr std::array<const char*, 3> kCodecs{"none", "zip", "blosc"};

const char* className(std::uint32_t gridClass) {
    constexpr std::array<const char*, 4> kClasses{"unknown", "level set", "fog volume", "staggered"};
    return gridClass < kClasses.size() ? kClasses[gridClass] : "unknown";
}

/// One of the descriptions in a segment, and its size on disk.
VdbLayout::Grid describedGrid(VdbWalker& walk, std::uint64_t& diskBytes) {
    constexpr const char* kWhat = "a grid's description";
    VdbLayout::Grid grid;
    VdbLayout::Nano nano;
    nano.bytes = walk.number<std::uint64_t>(kWhat);
    diskBytes = walk.number<std::uint64_t>(kWhat);
    walk.skip(2 * sizeof(std::uint64_t), kWhat);  // a hash of the name, the number of voxels
    nano.type = walk.number<std::uint32_t>(kWhat);
    grid.gridClass = className(walk.number<std::uint32_t>(kWhat));
    walk.skip(6 * sizeof(double), kWhat);  // its bounds in the world
    grid.isLower = walk.number<Int3>(kWhat);
    grid.isUpper = walk.number<Int3>(kWhat);
    walk.skip(3 * sizeof(double), kWhat);  // the size of a voxel
    const auto nameBytes = walk.number<std::uint32_t>(kWhat);
    walk.skip(7 * sizeof(std::uint32_t), kWhat);  // numbers of nodes and tiles
    nano.codec = walk.number<std::uint16_t>(kWhat);
    walk.skip(sizeof(std::uint16_t) + sizeof(std::uint32_t), kWhat);  // padding, version
    if (nameBytes > kLongestName) walk.damaged(fmt::format("a grid's name claims {} bytes", nameBytes));
    for (std::uint32_t i = 0; i < nameBytes; ++i) grid.name += walk.number<char>(kWhat);
    grid.name.resize(std::min(grid.name.find('\0'), grid.name.size()));

    const std::string quoted = "grid '" + shortened(grid.name, 80) + "'";
    if (nano.codec >= kCodecs.size()) walk.damaged(fmt::format("{} has an unknown codec {}", quoted, nano.codec));
    const bool packed = nano.codec != 0;
    if (nano.bytes > kMostBytes || (packed && nano.bytes > diskBytes * kMostRatio + kSlack))
        walk.damaged(
            fmt::format("{} claims {} bytes, more than its {} in the file can hold", quoted, nano.bytes, diskBytes));
    if (!packed && nano.bytes != diskBytes)
        walk.damaged(fmt::format("{} has {} bytes in the file, expected {}", quoted, diskBytes, nano.bytes));
    const NanoType* const known = nano.type < kTypes.size() ? &kTypes[nano.type] : nullptr;
    const std::string name = known != nullptr ? known->name : fmt::format("type {}", nano.type);
    grid.type = known != nullptr && known->type != nullptr ? known->type : "NanoVDB " + name;
    grid.codec = fmt::format("{} (NanoVDB {})", kCodecs[nano.codec], name);
    grid.nano = nano;
    return grid;
}

/// Walks a segment; leaves `walk` at its end.
void walkSegment(VdbWalker& walk, const VdbBytes& bytes, VdbLayout& layout) {
    constexpr const char* kWhat = "a segment's header";
    std::array<char, 8> magic = walk.number<std::array<char, 8>>(kWhat);
    const std::string_view start(magic.data(), kMagic.size());
    if (start != kMagic || (magic[7] != kOldFile && magic[7] != kFile))
        walk.damaged(fmt::format("no segment begins at byte {}", walk.at() - magic.size()));
    const auto version = walk.number<std::uint32_t>(kWhat);
    layout.fileVersion = version >> 21;
    layout.libraryMajor = layout.fileVersion;
    layout.libraryMinor = version >> 10 & 0x7ff;
    if (layout.fileVersion != kMajor)
        throw Error(
            ErrorKind::input,
            fmt::format("{}: is of NanoVDB {}.{}, expected version {} (that of OpenVDB 9 to 12): write it anew, "
                        "or convert it to .vdb",
                        bytes.path(), layout.fileVersion, layout.libraryMinor, kMajor));
    const auto count = walk.number<std::uint16_t>(kWhat);
    walk.skip(sizeof(std::uint16_t), kWhat);  // the codec, which each grid states, too
    std::vector<std::uint64_t> sizes(count);
    const std::size_t first = layout.grids.size();
    for (std::uint64_t& size : sizes) layout.grids.push_back(describedGrid(walk, size));
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        VdbLayout::Grid& grid = layout.grids[first + i];
        grid.begin = walk.at();
        walk.skip(sizes[i], "a grid");
        grid.end = walk.at();
    }
}

}  // namespace

bool isNanoVdb(const VdbBytes& bytes) {
    std::array<char, 8> start{};
    if (bytes.size() < start.size()) return false;
    bytes.copy(0, start.size(), start.data());
    return std::string_view(start.data(), kMagic.size()) == kMagic;
}

VdbLayout checkNanoLayout(const VdbBytes& bytes) {
    char kind = 0;
    bytes.copy(kMagic.size(), 1, &kind);
    if (kind == kGridAlone)
        throw Error(ErrorKind::input,
                    fmt::format("{}: is a NanoVDB grid as it lies in memory, expected a file of grids (writeGrid)",
                                bytes.path()));
    VdbLayout layout;
    layout.hasOffsets = true;
    layout.isNano = true;
    VdbWalker walk(bytes);
    while (walk.left() > 0) walkSegment(walk, bytes, layout);
    return layout;
}

}  // namespace scrim
