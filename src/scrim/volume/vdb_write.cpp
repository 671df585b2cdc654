// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_write.h>

#include <scrim/base/error.h>
#include <scrim/base/atomic_file.h>

#include <openvdb/openvdb.h>
#include <openvdb/io/File.h>

namespace scrim {

namespace {

openvdb::FloatGrid::Ptr gridFrom(const SparseField& field) {
    using Leaf = openvdb::FloatTree::LeafNodeType;
    openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(0.0f);
    grid->setName(field.name);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    openvdb::Mat4d m;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) m(i, j) = field.wsFromIs[i][j];
    grid->setTransform(openvdb::math::Transform::createLinearTransform(m));

    openvdb::FloatTree& tree = grid->tree();
    for (const ConstantTile& tile : field.tiles) {
        const openvdb::Coord low(tile.origin.x, tile.origin.y, tile.origin.z);
        tree.sparseFill(openvdb::CoordBBox(low, low.offsetBy(tile.edge - 1)), tile.value, /*active=*/true);
    }
    for (std::size_t i = 0; i < field.blockCount(); ++i) {
        const Int3& origin = field.blockOrigins[i];
        Leaf* leaf = tree.touchLeaf(openvdb::Coord(origin.x, origin.y, origin.z));
        const float* values = field.block(i);
        for (openvdb::Index n = 0; n < kBlockVoxels; ++n)
            if (values[n] > 0) leaf->setValueOn(n, values[n]);
    }
    return grid;
}

}  // namespace

void writeVdb(const std::string& path, const std::vector<SparseField>& fields) {
    openvdb::initialize();
    AtomicFile file(path);
    try {
        openvdb::GridCPtrVec grids;
        for (const SparseField& field : fields) grids.push_back(gridFrom(field));
        openvdb::MetaMap metadata;
        metadata.insertMeta("creator", openvdb::StringMetadata("Scrim"));
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
    file.commit();
}

}  // namespace scrim
