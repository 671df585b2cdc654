// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_module.h>

#include <scrim/base/atomic_file.h>
#include <scrim/base/system_error.h>
#include <scrim/volume/openvdb_field.h>
#include <scrim/volume/vdb_bytes.h>
#include <scrim/volume/vdb_layout.h>

#include <openvdb/openvdb.h>
#include <openvdb/io/File.h>

#include <cerrno>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace scrim {

namespace {

/// Makes a grid of type `Grid`. `valueAt(floats of the block, voxel)` gives a voxel's value.
template <typename Grid, typename ValueAt>
openvdb::GridBase::Ptr gridFrom(const VdbGrid& from, std::size_t floatsABlock, const ValueAt& valueAt) {
    typename Grid::Ptr grid = Grid::create();
    placeGrid(*grid, from.name, from.wsFromIs);
    if (!from.colour) grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    for (std::size_t b = 0; b < from.blockOrigins.size(); ++b) {
        const Int3& origin = from.blockOrigins[b];
        auto* leaf = grid->tree().touchLeaf(openvdb::Coord(origin.x, origin.y, origin.z));
        const float* values = from.values.data() + b * floatsABlock;
        for (openvdb::Index n = 0; n < kBlockVoxels; ++n)
            if (from.active[b][n]) leaf->setValueOn(n, valueAt(values, n));
    }
    for (const auto& [key, value] : from.metadata) grid->insertMeta(key, openvdb::StringMetadata(value));
    return grid;
}

openvdb::GridBase::Ptr gridFrom(const VdbGrid& from) {
    if (!from.colour)
        return gridFrom<openvdb::FloatGrid>(from, kBlockVoxels,
                                            [](const float* values, openvdb::Index n) { return values[n]; });
    return gridFrom<openvdb::Vec3SGrid>(from, std::size_t{3} * kBlockVoxels, [](const float* v, openvdb::Index n) {
        return openvdb::Vec3s(v[n], v[kBlockVoxels + n], v[2 * kBlockVoxels + n]);
    });
}

/// The errno of appending to a file, which tells why a write failed.
int errorOfAdding(const std::string& path) {
    const std::vector<char> zeros(std::size_t{1} << 20);
    const int file = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
    int error = file < 0 ? errno : 0;
    // The first attempt may succeed with whatever still fits.
    for (int attempt = 0; attempt < 2 && error == 0; ++attempt)
        if (::write(file, zeros.data(), zeros.size()) < 0) error = errno;
    if (file >= 0) ::close(file);
    return error == 0 ? EIO : error;
}

/// Checks the written file, since OpenVDB ignores failed writes.
void checkWritten(const AtomicFile& file) {
    try {
        checkVdbLayout(VdbBytes(file.tempPath()));
    } catch (const Error&) {
        throw Error(ErrorKind::output, shortened(fmt::format("{}: cannot be written: {}", file.path(),
                                                             systemErrorText(errorOfAdding(file.tempPath())))));
    }
}

template <typename Source>
void writeAll(const std::string& path, const std::vector<Source>& sources,
              const std::vector<std::pair<std::string, std::string>>& more) {
    openvdb::initialize();
    AtomicFile file(path);
    try {
        openvdb::GridCPtrVec grids;
        for (const Source& source : sources) grids.push_back(gridFrom(source));
        openvdb::MetaMap metadata;
        metadata.insertMeta("creator", openvdb::StringMetadata("Scrim"));
        for (const auto& [key, value] : more) metadata.insertMeta(key, openvdb::StringMetadata(value));
        openvdb::io::File out(file.tempPath());
        out.setCompression(
            openvdb::io::COMPRESS_ACTIVE_MASK |
            (openvdb::io::Archive::hasBloscCompression() ? openvdb::io::COMPRESS_BLOSC : openvdb::io::COMPRESS_ZIP));
        out.write(grids, metadata);
        out.close();
    } catch (const std::bad_alloc&) {
        throw Error(ErrorKind::memory, shortened(path + ": not enough memory to write it"));
    } catch (const std::exception& error) {
        throw Error(ErrorKind::output, shortened(path + ": cannot be written: " + error.what()));
    }
    checkWritten(file);
    file.commit();
}

}  // namespace

void writeVdbContent(const std::string& path, const std::vector<SparseField>& fields) {
    writeAll(path, fields, {});
}

void writeVdbGridContent(const std::string& path, const std::vector<VdbGrid>& grids,
                         const std::vector<std::pair<std::string, std::string>>& metadata) {
    writeAll(path, grids, metadata);
}

}  // namespace scrim
