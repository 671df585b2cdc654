// SPDX-License-Identifier: Apache-2.0
#include "vdb_make.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <openvdb/io/File.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/tools/LevelSetSphere.h>
#define NANOVDB_USE_ZIP
#define NANOVDB_USE_BLOSC
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

namespace scrim::test {

namespace {

openvdb::Coord coord(const Int3& p) {
    return {p.x, p.y, p.z};
}

openvdb::Index levelOf(const MadeTile& tile) {
    return tile.edge == 8 ? 1 : tile.edge == 128 ? 2 : 3;
}

template <typename Grid>
openvdb::GridBase::Ptr scalarGrid(const MadeGrid& made) {
    using Value = typename Grid::ValueType;
    typename Grid::Ptr grid = Grid::create(static_cast<Value>(made.background));
    for (const MadeTile& tile : made.tiles)
        grid->tree().addTile(levelOf(tile), coord(tile.at), static_cast<Value>(tile.value), true);
    for (const MadeVoxel& v : made.voxels) grid->tree().setValue(coord(v.at), static_cast<Value>(v.value));
    for (const MadeVoxel& v : made.inactive) grid->tree().setValueOff(coord(v.at), static_cast<Value>(v.value));
    return grid;
}

template <typename Grid>
openvdb::GridBase::Ptr vectorGrid(const MadeGrid& made) {
    using Vector = typename Grid::ValueType;
    using Value = typename Vector::value_type;
    typename Grid::Ptr grid = Grid::create();
    for (const MadeTile& tile : made.tiles)
        grid->tree().addTile(levelOf(tile), coord(tile.at), Vector(static_cast<Value>(tile.value)), true);
    for (const MadeVoxel& v : made.voxels) grid->tree().setValue(coord(v.at), Vector(static_cast<Value>(v.value)));
    for (const MadeColour& c : made.colours)
        grid->tree().setValue(coord(c.at), Vector(static_cast<Value>(c.value.x), static_cast<Value>(c.value.y),
                                                  static_cast<Value>(c.value.z)));
    return grid;
}

openvdb::GridBase::Ptr pointGrid(const MadeGrid& made) {
    std::vector<openvdb::Vec3s> positions;
    for (const MadeVoxel& v : made.voxels) positions.emplace_back(coord(v.at).asVec3s());
    const auto transform = openvdb::math::Transform::createLinearTransform(made.voxelSize);
    return openvdb::points::createPointDataGrid<openvdb::points::NullCodec, openvdb::points::PointDataGrid>(positions,
                                                                                                            *transform);
}

openvdb::GridBase::Ptr typedGrid(const MadeGrid& made) {
    if (made.type == "float" || made.type == "half" || made.type.starts_with("Fp"))
        return scalarGrid<openvdb::FloatGrid>(made);
    if (made.type == "double") return scalarGrid<openvdb::DoubleGrid>(made);
    if (made.type == "int32") return scalarGrid<openvdb::Int32Grid>(made);
    if (made.type == "int64") return scalarGrid<openvdb::Int64Grid>(made);
    if (made.type == "mask") return scalarGrid<openvdb::MaskGrid>(made);
    if (made.type == "bool") return scalarGrid<openvdb::BoolGrid>(made);
    if (made.type == "vec3s" || made.type == "vec3half") return vectorGrid<openvdb::Vec3SGrid>(made);
    if (made.type == "vec3d") return vectorGrid<openvdb::Vec3DGrid>(made);
    if (made.type == "vec3i") return vectorGrid<openvdb::Vec3IGrid>(made);
    if (made.type == "points") return pointGrid(made);
    if (made.type == "sphere")
        return openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(
            static_cast<float>(10 * made.voxelSize), openvdb::Vec3f(0), static_cast<float>(made.voxelSize));
    throw std::runtime_error("vdb_make: unknown type " + made.type);
}

openvdb::math::MapBase::Ptr mapOf(const std::string& name) {
    using namespace openvdb::math;
    const openvdb::Vec3d scale(0.5, 0.25, 2), shift(3, -4, 5), axis(1, 2, 3);
    if (name == "UniformScaleMap") return std::make_shared<UniformScaleMap>(0.3);
    if (name == "ScaleMap") return std::make_shared<ScaleMap>(scale);
    if (name == "TranslationMap") return std::make_shared<TranslationMap>(shift);
    if (name == "ScaleTranslateMap") return std::make_shared<ScaleTranslateMap>(scale, shift);
    if (name == "UniformScaleTranslateMap") return std::make_shared<UniformScaleTranslateMap>(0.3, shift);
    if (name == "UnitaryMap") return std::make_shared<UnitaryMap>(axis, 0.7);
    if (name == "AffineMap") {
        auto map = std::make_shared<AffineMap>();
        map->accumPreRotation(X_AXIS, 0.4);
        map->accumPreScale(scale);
        map->accumPostRotation(Z_AXIS, 1.1);
        map->accumPostTranslation(shift);
        return map;
    }
    throw std::runtime_error("vdb_make: unknown map " + name);
}

openvdb::math::Transform::Ptr transformOf(const MadeGrid& made) {
    if (!made.map.empty()) return std::make_shared<openvdb::math::Transform>(mapOf(made.map));
    if (made.frustum)
        return openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(16)),
                                                                /*taper=*/0.5, /*depth=*/1.0,
                                                                /*x voxel=*/made.voxelSize);
    auto transform = openvdb::math::Transform::createLinearTransform(made.voxelSize);
    transform->postTranslate(openvdb::Vec3d(made.translate.x, made.translate.y, made.translate.z));
    return transform;
}

openvdb::GridBase::Ptr make(const MadeGrid& made) {
    openvdb::GridBase::Ptr grid = typedGrid(made);
    grid->setName(made.name);
    grid->setSaveFloatAsHalf(made.type == "half" || made.type == "vec3half");
    if (made.type != "sphere") grid->setGridClass(openvdb::GridBase::stringToGridClass(made.gridClass));
    if (made.type != "sphere" && made.type != "points") grid->setTransform(transformOf(made));
    return grid;
}

template <typename Open, typename Nano>
nanovdb::GridHandle<> nanoAs(const openvdb::GridBase& grid) {
    using Grid = openvdb::Grid<typename openvdb::tree::Tree4<Open>::Type>;
    nanovdb::OpenToNanoVDB<Open, Nano> convert;
    return convert(static_cast<const Grid&>(grid));
}

nanovdb::GridHandle<> nanoGrid(const MadeGrid& made) {
    const openvdb::GridBase::Ptr grid = make(made);
    if (made.type == "Fp4") return nanoAs<float, nanovdb::Fp4>(*grid);
    if (made.type == "Fp8") return nanoAs<float, nanovdb::Fp8>(*grid);
    if (made.type == "Fp16") return nanoAs<float, nanovdb::Fp16>(*grid);
    if (made.type == "FpN") return nanoAs<float, nanovdb::FpN>(*grid);
    if (made.type == "double") return nanoAs<double, double>(*grid);
    if (made.type == "int32") return nanoAs<std::int32_t, std::int32_t>(*grid);
    if (made.type == "vec3s") return nanoAs<openvdb::Vec3f, nanovdb::Vec3f>(*grid);
    if (made.type == "bool") return nanoAs<bool, bool>(*grid);
    if (made.type == "mask") return nanoAs<openvdb::ValueMask, nanovdb::ValueMask>(*grid);
    return nanoAs<float, float>(*grid);
}

}  // namespace

void makeNvdb(const std::string& path, const std::vector<MadeGrid>& grids, NanoCodec codec, NanoSegments segments) {
    openvdb::initialize();
    std::vector<nanovdb::GridHandle<>> made;
    for (const MadeGrid& grid : grids) made.push_back(nanoGrid(grid));
    std::ofstream file(path, std::ios::binary);
    const auto packed = static_cast<nanovdb::io::Codec>(codec);
    if (segments == NanoSegments::one) return nanovdb::io::writeGrids(file, made, packed);
    for (const nanovdb::GridHandle<>& grid : made) nanovdb::io::writeGrid(file, grid, packed);
}

double frustumVolume(const MadeGrid& grid, const Int3& lower, const Int3& upper) {
    const auto transform = transformOf(grid);
    const auto at = [&](int x, int y, int z) {
        return transform->indexToWorld(openvdb::Vec3d(
            x ? upper.x + 0.5 : lower.x - 0.5, y ? upper.y + 0.5 : lower.y - 0.5, z ? upper.z + 0.5 : lower.z - 0.5));
    };
    const auto area = [&](int z) {
        return (at(1, 0, z) - at(0, 0, z)).length() * (at(0, 1, z) - at(0, 0, z)).length();
    };
    const double depth = std::abs(at(0, 0, 1).z() - at(0, 0, 0).z());
    return depth / 3 * (area(0) + area(1) + std::sqrt(area(0) * area(1)));
}

std::vector<MadeVoxel> box(const Int3& lower, const Int3& upper, double value) {
    std::vector<MadeVoxel> voxels;
    for (int x = lower.x; x <= upper.x; ++x)
        for (int y = lower.y; y <= upper.y; ++y)
            for (int z = lower.z; z <= upper.z; ++z) voxels.push_back({{x, y, z}, value});
    return voxels;
}

void makeVdb(const std::string& path, const std::vector<MadeGrid>& grids, Container container, const Packing& packing) {
    openvdb::initialize();
    openvdb::GridCPtrVec made;
    for (const MadeGrid& grid : grids) made.push_back(make(grid));
    openvdb::MetaMap metadata;
    metadata.insertMeta("creator", openvdb::StringMetadata("vdb_make"));
    if (container == Container::stream) {
        std::ofstream file(path, std::ios::binary);
        openvdb::io::Stream(file).write(made, metadata);
        return;
    }
    openvdb::io::File file(path);
    file.setCompression((packing.codec == "blosc" ? openvdb::io::COMPRESS_BLOSC
                         : packing.codec == "zip" ? openvdb::io::COMPRESS_ZIP
                                                  : openvdb::io::COMPRESS_NONE) |
                        (packing.activeMask ? openvdb::io::COMPRESS_ACTIVE_MASK : openvdb::io::COMPRESS_NONE));
    file.write(made, metadata);
}

void makeVdbWithInstance(const std::string& path, const MadeGrid& density) {
    openvdb::initialize();
    const openvdb::GridBase::Ptr original = make(density);
    const openvdb::GridBase::Ptr copy = original->copyGrid();  // shares the tree
    copy->setName("copy");
    copy->setTransform(openvdb::math::Transform::createLinearTransform(2 * density.voxelSize));
    openvdb::io::File(path).write(openvdb::GridCPtrVec{original, copy});
}

std::string readBytes(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error("cannot read " + path);
    return {std::istreambuf_iterator<char>(file), {}};
}

void writeBytes(const std::string& path, const std::string& bytes) {
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!file) throw std::runtime_error("cannot write " + path);
}

}  // namespace scrim::test
