// SPDX-License-Identifier: Apache-2.0
// Internal: converts OpenVDB's grids to fields. Only the .cpp files that use OpenVDB include this header.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/block_memory.h>
#include <scrim/volume/field_builder.h>
#include <scrim/volume/field_choice.h>
#include <scrim/volume/grid_choice.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_info.h>

#include <string>
#include <vector>

#include <openvdb/openvdb.h>

namespace scrim {

/// The types of grids that are computed with. Each costs half a minute of compilation.
using FloatGrids = openvdb::TypeList<openvdb::FloatGrid, openvdb::Vec3SGrid>;
/// Scalar grids of other numbers than real ones.
using WholeGrids = openvdb::TypeList<openvdb::Int32Grid, openvdb::Int64Grid, openvdb::BoolGrid, openvdb::MaskGrid>;

Int3 fromOpenVdb(const openvdb::Coord& c);
/// The matrix of an affine transform.
Mat4 fromOpenVdb(const openvdb::math::Transform& transform);

/// Moves the component of a staggered velocity to the faces of voxels; leaves every other field unchanged.
void placeOnFaces(SparseField& field, const openvdb::GridBase& grid, const FieldChoice& choice);

/// The leaves of a grid's tree, in the order in which files hold them.
template <typename Grid>
std::vector<const typename Grid::TreeType::LeafNodeType*> leavesOf(const Grid& grid) {
    std::vector<const typename Grid::TreeType::LeafNodeType*> list;
    grid.tree().getNodes(list);
    return list;
}

/// Calls `visit(origin, edge, value)` for every active tile.
template <typename Grid, typename Visit>
void visitTiles(const Grid& grid, const Visit& visit) {
    auto tile = grid.tree().cbeginValueOn();
    tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1);
    for (; tile; ++tile) {
        openvdb::CoordBBox box;
        tile.getBoundingBox(box);
        visit(box.min(), box.max().x() - box.min().x() + 1, tile.getValue());
    }
}

/// All of the field that `choice` means but its values, which are those of `leaves`, block by block.
template <typename Grid, typename Leaf>
FieldPieces frameOf(const Grid& grid, const std::vector<const Leaf*>& leaves, const FieldChoice& choice) {
    FieldPieces pieces;
    pieces.name = fieldName(grid.getName(), choice);
    pieces.wsFromIs = fromOpenVdb(grid.transform());
    pieces.blockOrigins.reserve(leaves.size());
    for (const Leaf* leaf : leaves) pieces.blockOrigins.push_back(fromOpenVdb(leaf->origin()));
    visitTiles(grid, [&](const openvdb::Coord& origin, int edge, const auto& value) {
        pieces.tiles.push_back({fromOpenVdb(origin), edge, choice.of(value)});
    });
    return pieces;
}

/// Gives the grid a name and a place.
void placeGrid(openvdb::GridBase& grid, const std::string& name, const Mat4& wsFromIs);

/// The field as a fog volume; voxels above 0 are active.
openvdb::FloatGrid::Ptr gridFrom(const SparseField& field);

/// The grid itself, or a copy with floats in place of numbers of double precision.
openvdb::GridBase::Ptr inFloats(openvdb::GridBase::Ptr grid);

/// Gives `out` the values of `grid` at its own voxels, trilinearly interpolated. Both are of one of `FloatGrids`.
void interpolateInto(openvdb::GridBase& out, const openvdb::GridBase& grid);

/// The properties of a grid by which a request chooses.
GridOffer offerOf(const openvdb::GridBase& grid);

/// The field of a scalar grid, with its values in `memory`; `where` (the file) starts every message and error.
SparseField fieldFromGrid(openvdb::GridBase::Ptr grid, const std::string& where, const MessageSink& messages,
                          BlockMemory& memory);

/// Turns a level set of floats into fog in place, with a message; leaves every other grid unchanged.
void levelSetIntoFog(openvdb::GridBase& grid, const std::string& where, const MessageSink& messages);

/// The field of a colour component (0, 1, 2) of a vec3 grid, named as the grid with ".r", ".g" or ".b" added; or of a
/// scalar grid (kScalar), which may be called a level set without being converted.
SparseField colourFromGrid(openvdb::GridBase::Ptr grid, int component, const std::string& where,
                           const MessageSink& messages, BlockMemory& memory);

/// The numbers of a velocity that are above 0, or those below 0 without their sign (`negative`), as
/// a field. It is a component of a vec3 grid, named with ".x", ".y" or ".z" (placed on the faces of
/// voxels where the grid is staggered), or a scalar grid (kScalar).
SparseField velocityFromGrid(openvdb::GridBase::Ptr grid, int component, bool negative, const std::string& where,
                             const MessageSink& messages, BlockMemory& memory);

/// Describes any grid, with the range of values of scalar ones.
GridInfo describeGrid(const openvdb::GridBase& grid);

}  // namespace scrim
