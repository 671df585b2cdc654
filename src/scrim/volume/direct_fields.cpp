// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/direct_fields.h>

#include <scrim/base/error.h>
#include <scrim/volume/vdb_leaves.h>
#include <scrim/volume/vdb_part.h>

#include <algorithm>
#include <deque>
#include <istream>
#include <memory>
#include <new>
#include <type_traits>

#include <openvdb/io/Compression.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>

namespace scrim {
namespace {

/// From this version on, leaves are stored as readLeaves expects; it cannot be known how newer files store them.
constexpr std::uint32_t kOldest = openvdb::OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION;
constexpr std::uint32_t kNewest = openvdb::OPENVDB_FILE_VERSION;

/// A grid whose leaves have no values yet.
struct TreeOfGrid {
    openvdb::GridBase::Ptr grid;  ///< null: it needs OpenVDB
    LeafFormat format;
    std::uint64_t leavesAt = 0;
};

LeafFormat formatOf(std::uint32_t compression, bool half, int channels) {
    LeafFormat format;
    format.codec = (compression & openvdb::io::COMPRESS_BLOSC) != 0 ? LeafFormat::Codec::blosc
                   : (compression & openvdb::io::COMPRESS_ZIP) != 0 ? LeafFormat::Codec::zip
                                                                    : LeafFormat::Codec::none;
    format.masked = (compression & openvdb::io::COMPRESS_ACTIVE_MASK) != 0;
    format.half = half;
    format.channels = channels;
    return format;
}

/// Reads what lies before the leaves, in the order in which OpenVDB reads it (openvdb/io/Archive.cc).
TreeOfGrid readTree(const VdbBytes& file, const VdbLayout& layout, const VdbLayout::Grid& place, bool asFog) {
    VdbStream buffer(file, place.begin, place.end);
    std::istream stream(&buffer);
    stream.exceptions(std::ios_base::badbit | std::ios_base::failbit | std::ios_base::eofbit);
    openvdb::io::setVersion(stream, {layout.libraryMajor, layout.libraryMinor}, layout.fileVersion);
    auto metadata = std::make_shared<openvdb::io::StreamMetadata>();
    openvdb::io::setStreamMetadataPtr(stream, metadata, /*transfer=*/true);

    TreeOfGrid out;
    openvdb::io::GridDescriptor descriptor;
    const openvdb::GridBase::Ptr grid = descriptor.read(stream);
    std::uint32_t compression = 0;
    stream.read(reinterpret_cast<char*>(&compression), sizeof compression);
    openvdb::io::setDataCompression(stream, compression);
    openvdb::io::setHalfFloat(stream, grid->saveFloatAsHalf());
    grid->readMeta(stream);
    grid->readTransform(stream);
    if (!grid->transform().isLinear()) return out;
    if (asFog && grid->getGridClass() == openvdb::GRID_LEVEL_SET) return out;
    grid->readTopology(stream);
    out.format = formatOf(compression, grid->saveFloatAsHalf(), grid->isType<openvdb::FloatGrid>() ? 1 : 3);
    out.leavesAt = place.begin + buffer.position();
    out.grid = grid;
    return out;
}

template <typename Grid>
std::vector<SparseField> fill(const TreeOfGrid& tree, const VdbBytes& file, std::uint64_t end,
                              const std::vector<DirectField>& wanted, BlockMemory& memory) {
    const Grid& grid = static_cast<const Grid&>(*tree.grid);
    const auto leaves = leavesOf(grid);
    std::deque<FieldFill> fields;
    for (const DirectField& field : wanted) fields.emplace_back(frameOf(grid, leaves, field.choice), memory);
    const auto visit = [&](std::size_t leaf, const LeafValues& values) {
        for (std::size_t f = 0; f < wanted.size(); ++f) {
            values.fill(std::max(wanted[f].choice.component, 0), wanted[f].choice, fields[f].block(leaf));
            fields[f].filled(leaf);
        }
    };
    std::vector<SparseField> out;
    if (!readLeaves(file, tree.leavesAt, end, leaves.size(), tree.format, visit)) return out;
    for (std::size_t f = 0; f < wanted.size(); ++f) {
        out.push_back(fields[f].finish());
        placeOnFaces(out.back(), grid, wanted[f].choice);
    }
    return out;
}

/// True where a grid of this type has such components.
template <typename Grid>
bool hasAll(const VdbLayout::Grid& place, const std::vector<DirectField>& wanted) {
    constexpr bool kScalar = std::is_same_v<Grid, openvdb::FloatGrid>;
    return place.type == Grid::gridType() && std::all_of(wanted.begin(), wanted.end(), [](const DirectField& field) {
               return kScalar == (field.choice.component == GridRequest::kScalar);
           });
}

}  // namespace

std::vector<SparseField> directFields(const VdbBytes& file, const VdbLayout& layout, std::size_t place,
                                      const std::vector<DirectField>& wanted, BlockMemory& memory) {
    const VdbLayout::Grid& grid = layout.grids.at(place);
    if (layout.fileVersion < kOldest || layout.fileVersion > kNewest || grid.instance) return {};
    const bool scalar = hasAll<openvdb::FloatGrid>(grid, wanted);
    if (!scalar && !hasAll<openvdb::Vec3SGrid>(grid, wanted)) return {};
    const bool asFog = std::any_of(wanted.begin(), wanted.end(), [](const DirectField& f) { return f.asFog; });
    try {
        const TreeOfGrid tree = readTree(file, layout, grid, asFog);
        if (!tree.grid) return {};
        return scalar ? fill<openvdb::FloatGrid>(tree, file, grid.end, wanted, memory)
                      : fill<openvdb::Vec3SGrid>(tree, file, grid.end, wanted, memory);
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::input) throw;
        return {};
    } catch (const std::exception&) {
        return {};
    }
}

}  // namespace scrim
