// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/openvdb_field.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/volume/field_builder.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <openvdb/tools/GridTransformer.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetUtil.h>

namespace scrim {

namespace {

/// Limit on the voxels of a resampled frustum grid's bounding box. Resampled at the voxel size of its middle, such a
/// grid could grow without bounds. (The box counts, not the active part; a frustum fills about half of it.)
constexpr double kMaxResampledVoxels = 1e9;

/// The grid resampled on an affine lattice of world-aligned cubes, as large as the smallest edge of
/// a voxel in the grid's middle.
openvdb::FloatGrid::Ptr resampled(const openvdb::FloatGrid& grid, const std::string& where,
                                  const MessageSink& messages) {
    openvdb::FloatGrid::Ptr out = openvdb::FloatGrid::create(0);
    out->setName(grid.getName());
    openvdb::CoordBBox box;
    if (!grid.tree().evalActiveVoxelBoundingBox(box)) return out;

    openvdb::BBoxd wsBox;
    for (int i = 0; i < 8; ++i) {
        const openvdb::Vec3d corner(i & 1 ? box.max().x() : box.min().x(), i & 2 ? box.max().y() : box.min().y(),
                                    i & 4 ? box.max().z() : box.min().z());
        wsBox.expand(grid.indexToWorld(corner));
    }
    const openvdb::Vec3d size = grid.transform().voxelSize(box.getCenter());
    double edge = std::min({size.x(), size.y(), size.z()});
    const openvdb::Vec3d extent = wsBox.extents();
    const double voxels = (extent.x() / edge + 1) * (extent.y() / edge + 1) * (extent.z() / edge + 1);
    if (!std::isfinite(voxels)) throw Error(ErrorKind::input, where + ": its frustum transform is degenerate");
    if (voxels > kMaxResampledVoxels) edge *= std::cbrt(voxels / kMaxResampledVoxels);

    out->setTransform(openvdb::math::Transform::createLinearTransform(edge));
    interpolateInto(*out, grid);
    notify(messages, Severity::info,
           fmt::format("{}: grid '{}' has a transform that is not affine: resampled to voxels of edge {:.4g}", where,
                       shortened(grid.getName(), 80), edge));
    return out;
}

/// The active voxels of a grid.
template <typename Grid>
SparseField convert(const Grid& grid, const FieldChoice& choice, BlockMemory& memory) {
    const auto list = leavesOf(grid);
    FieldPieces pieces = frameOf(grid, list, choice);
    pieces.fill = [&](std::size_t i, float* values) {
        const auto& mask = list[i]->valueMask();
        const auto* from = list[i]->buffer().data();
        for (openvdb::Index w = 0; w < kBlockVoxels / 64; ++w, from += 64, values += 64) {
            const auto on = mask.template getWord<std::uint64_t>(w);
            for (openvdb::Index n = 0; n < 64; ++n) values[n] = (on >> n & 1) != 0 ? choice.of(from[n]) : 0.0f;
        }
    };
    return buildField(std::move(pieces), memory);
}

/// As `convert`, with the file named in errors and a warning about cleaned values.
template <typename Grid>
SparseField reportedField(const Grid& grid, const FieldChoice& choice, const std::string& where,
                          const MessageSink& messages, BlockMemory& memory) {
    SparseField field;
    try {
        field = convert(grid, choice, memory);
    } catch (const Error& error) {
        throw Error(error.kind(), where + ": " + error.what());
    }
    reportCleaning(field, where, messages);
    return field;
}

SparseField scalarField(const openvdb::GridBase& base, const FieldChoice& choice, const std::string& where,
                        const MessageSink& messages, BlockMemory& memory) {
    const auto& grid = static_cast<const openvdb::FloatGrid&>(base);
    if (grid.transform().isLinear()) return reportedField(grid, choice, where, messages, memory);
    return reportedField(*resampled(grid, where, messages), choice, where, messages, memory);
}

/// A grid with the same active voxels, to each of whose values `valueOf` is applied.
template <typename Out, typename Grid, typename ValueOf>
typename Out::Ptr sameVoxels(const Grid& grid, const ValueOf& valueOf) {
    const auto zero = openvdb::zeroVal<typename Out::ValueType>();
    const auto out = Out::create(std::make_shared<typename Out::TreeType>(grid.tree(), zero, openvdb::TopologyCopy()));
    static_cast<openvdb::MetaMap&>(*out) = grid;  // name and class are metadata
    out->setTransform(grid.transform().copy());
    // Both trees have the same nodes, so their values come in the same order.
    auto to = out->tree().beginValueOn();
    for (auto from = grid.tree().cbeginValueOn(); from; ++from, ++to) to.setValue(valueOf(*from));
    return out;
}

SparseField componentField(const openvdb::GridBase& base, const FieldChoice& choice, const std::string& where,
                           const MessageSink& messages, BlockMemory& memory) {
    const auto& grid = static_cast<const openvdb::Vec3SGrid&>(base);
    if (grid.transform().isLinear()) return reportedField(grid, choice, where, messages, memory);
    const auto one = sameVoxels<openvdb::FloatGrid>(grid, [&](const auto& value) { return value[choice.component]; });
    one->setName(fieldName(grid.getName(), choice));
    return scalarField(*one, {GridRequest::kScalar, choice.part}, where, messages, memory);
}

/// Value range and counts of unusable values in one part of a grid.
struct Statistics {
    double minValue = std::numeric_limits<double>::infinity();
    double maxValue = -std::numeric_limits<double>::infinity();
    std::uint64_t nonFinite = 0;
    std::uint64_t negative = 0;

    void add(double value, std::uint64_t voxels) {
        if (!std::isfinite(value)) {
            nonFinite += voxels;
            return;
        }
        if (value < 0) negative += voxels;
        minValue = std::min(minValue, value);
        maxValue = std::max(maxValue, value);
    }
    void add(const Statistics& s) {
        minValue = std::min(minValue, s.minValue);
        maxValue = std::max(maxValue, s.maxValue);
        nonFinite += s.nonFinite;
        negative += s.negative;
    }
};

template <typename Grid>
Statistics statistics(const Grid& grid) {
    const auto list = leavesOf(grid);
    constexpr std::size_t kLeavesPerTask = 64;
    std::vector<Statistics> parts((list.size() + kLeavesPerTask - 1) / kLeavesPerTask);
    parallelFor(parts.size(), [&](std::size_t task) {
        const std::size_t end = std::min(list.size(), (task + 1) * kLeavesPerTask);
        for (std::size_t i = task * kLeavesPerTask; i < end; ++i)
            for (auto value = list[i]->cbeginValueOn(); value; ++value) parts[task].add(static_cast<double>(*value), 1);
    });
    Statistics total;
    for (const Statistics& part : parts) total.add(part);
    visitTiles(grid, [&](const openvdb::Coord&, int edge, auto value) {
        const auto e = static_cast<std::uint64_t>(edge);
        total.add(static_cast<double>(value), e * e * e);
    });
    return total;
}

}  // namespace

Int3 fromOpenVdb(const openvdb::Coord& c) {
    return {c.x(), c.y(), c.z()};
}

// OpenVDB multiplies rows from the left: its row i is the image of axis i, which is GLM's column i.
Mat4 fromOpenVdb(const openvdb::math::Transform& transform) {
    const openvdb::Mat4d m = transform.baseMap()->getAffineMap()->getMat4();
    Mat4 out;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) out[i][j] = m(i, j);
    return out;
}

void placeOnFaces(SparseField& field, const openvdb::GridBase& grid, const FieldChoice& choice) {
    if (grid.getGridClass() == openvdb::GRID_STAGGERED && grid.transform().isLinear()) placeOnFaces(field, choice);
}

void interpolateInto(openvdb::GridBase& out, const openvdb::GridBase& grid) {
    out.apply<FloatGrids>([&](auto& typed) {
        using Grid = std::decay_t<decltype(typed)>;
        openvdb::tools::resampleToMatch<openvdb::tools::BoxSampler>(static_cast<const Grid&>(grid), typed);
    });
}

openvdb::GridBase::Ptr inFloats(openvdb::GridBase::Ptr grid) {
    if (grid->isType<openvdb::DoubleGrid>())
        return std::make_shared<openvdb::FloatGrid>(static_cast<const openvdb::DoubleGrid&>(*grid));
    if (grid->isType<openvdb::Vec3DGrid>())
        // OpenVDB converts no vectors.
        return sameVoxels<openvdb::Vec3SGrid>(static_cast<const openvdb::Vec3DGrid&>(*grid),
                                              [](const openvdb::Vec3d& value) { return openvdb::Vec3s(value); });
    openvdb::GridBase::Ptr made;
    const openvdb::GridBase& other = *grid;
    other.apply<WholeGrids>([&](const auto& whole) {
        made = sameVoxels<openvdb::FloatGrid>(whole, [](const auto& value) { return static_cast<float>(value); });
    });
    return made ? made : grid;
}

GridOffer offerOf(const openvdb::GridBase& grid) {
    return {grid.getName(), grid.type(), openvdb::GridBase::gridClassToString(grid.getGridClass())};
}

void placeGrid(openvdb::GridBase& grid, const std::string& name, const Mat4& wsFromIs) {
    grid.setName(name);
    openvdb::Mat4d m;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) m(i, j) = wsFromIs[i][j];
    grid.setTransform(openvdb::math::Transform::createLinearTransform(m));
}

openvdb::FloatGrid::Ptr gridFrom(const SparseField& field) {
    using Leaf = openvdb::FloatTree::LeafNodeType;
    openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(0.0f);
    placeGrid(*grid, field.name, field.wsFromIs);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);

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

void levelSetIntoFog(openvdb::GridBase& grid, const std::string& where, const MessageSink& messages) {
    if (grid.getGridClass() != openvdb::GRID_LEVEL_SET || !grid.isType<openvdb::FloatGrid>()) return;
    openvdb::tools::sdfToFogVolume(static_cast<openvdb::FloatGrid&>(grid));  // it records that in the grid's class
    notify(messages, Severity::info,
           fmt::format("{}: grid '{}' is a level set: turned into fog of density 1", where,
                       shortened(grid.getName(), 80)));
}

SparseField fieldFromGrid(openvdb::GridBase::Ptr grid, const std::string& where, const MessageSink& messages,
                          BlockMemory& memory) {
    grid = inFloats(std::move(grid));
    if (grid->getGridClass() == openvdb::GRID_LEVEL_SET) {
        grid = grid->deepCopyGrid();
        levelSetIntoFog(*grid, where, messages);
    }
    return scalarField(*grid, {}, where, messages, memory);
}

SparseField colourFromGrid(openvdb::GridBase::Ptr grid, int component, const std::string& where,
                           const MessageSink& messages, BlockMemory& memory) {
    grid = inFloats(std::move(grid));
    if (component == GridRequest::kScalar) return scalarField(*grid, {}, where, messages, memory);
    return componentField(*grid, {component}, where, messages, memory);
}

SparseField velocityFromGrid(openvdb::GridBase::Ptr grid, int component, bool negative, const std::string& where,
                             const MessageSink& messages, BlockMemory& memory) {
    grid = inFloats(std::move(grid));
    const FieldChoice choice{component, negative ? GridPart::negative : GridPart::positive};
    if (component == GridRequest::kScalar) return scalarField(*grid, choice, where, messages, memory);
    SparseField field = componentField(*grid, choice, where, messages, memory);
    placeOnFaces(field, *grid, choice);
    return field;
}

GridInfo describeGrid(const openvdb::GridBase& grid) {
    GridInfo info;
    info.name = grid.getName();
    info.valueType = grid.valueType();
    info.gridClass = openvdb::GridBase::gridClassToString(grid.getGridClass());
    info.savedAsHalf = grid.saveFloatAsHalf();
    if (const auto codec = grid.getMetadata<openvdb::StringMetadata>(openvdb::GridBase::META_FILE_COMPRESSION))
        info.codec = codec->value();
    info.activeVoxels = grid.baseTree().activeLeafVoxelCount();
    info.activeTiles = grid.baseTree().activeTileCount();

    openvdb::CoordBBox box;
    if (grid.baseTree().evalActiveVoxelBoundingBox(box)) {
        info.isLower = fromOpenVdb(box.min());
        info.isUpper = fromOpenVdb(box.max());
    } else {
        box = openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(0));
    }
    info.affine = grid.transform().isLinear();
    const openvdb::Vec3d size =
        info.affine ? grid.transform().voxelSize() : grid.transform().voxelSize(box.getCenter());
    info.voxelSize = {size.x(), size.y(), size.z()};
    if (info.affine) info.wsFromIs = fromOpenVdb(grid.transform());

    info.usable = offerOf(grid).isScalar();
    info.colour = offerOf(grid).isVector();
    if (!info.usable) return info;
    const auto valuesOf = [](const openvdb::GridBase& real) {
        return real.isType<openvdb::FloatGrid>() ? statistics(static_cast<const openvdb::FloatGrid&>(real))
                                                 : statistics(static_cast<const openvdb::DoubleGrid&>(real));
    };
    const Statistics values = offerOf(grid).isReal()
                                  ? valuesOf(grid)
                                  : valuesOf(*inFloats(std::const_pointer_cast<openvdb::GridBase>(grid.copyGrid())));
    info.nonFinite = values.nonFinite;
    info.negative = values.negative;
    if (values.minValue <= values.maxValue) {
        info.minValue = values.minValue;
        info.maxValue = values.maxValue;
    }
    return info;
}

}  // namespace scrim
