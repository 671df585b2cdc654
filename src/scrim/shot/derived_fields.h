// SPDX-License-Identifier: Apache-2.0
// Fields that are computed from a scene's grids voxel by voxel, before anything is splatted. Splatting is linear in
// them, so the picture does not depend on the thickness of sheets or the size of texels.
#pragma once

#include <scrim/scene/view_scene.h>

#include <array>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace scrim {

using FieldPointer = std::shared_ptr<const SparseField>;

/// The field with its voxels mapped by the ramp: linear between points and constant outside of them. Empty space stays
/// empty whatever the ramp maps 0 to, since only active voxels are splatted.
FieldPointer withRamp(const SparseField& field, const std::vector<std::pair<double, double>>& ramp);

/// The field without faint blocks far from all others, which would enlarge the box that is
/// rendered. `extinction`: of a value of 1 and a voxel's edge. What is left out takes at most a
/// ten-thousandth of the light of a view of the rest. Returns `field` itself where nothing is.
FieldPointer withoutStrays(const FieldPointer& field, double extinction);

/// The density times the red, green and blue albedo at each of the density's voxels, as three
/// fields on the density's lattice. The albedo is converted from its own space (see ColourGrid),
/// interpolated where the lattices differ, and clamped to [0, 1]. Voxels are multiplied, not
/// reconstructed fields, so that colours do not darken towards a rim where both grids end.
std::vector<FieldPointer> scatteringFields(const SparseField& density, const std::array<FieldPointer, 3>& albedo,
                                           const ColourGrid& look);

/// The density times (velocity - `least`) for x, y and z at each of the density's voxels, as three
/// fields on the density's lattice. `velocity`: the fields of positive and negative values of each
/// component (GridPart), in the asset's space. `assetFromIs` belongs to the density.
std::vector<FieldPointer> flowFields(const SparseField& density, const Mat4& assetFromIs,
                                     const std::vector<FieldPointer>& velocity, const Vec3& least);

/// A block of one value, which was a part of a tile.
struct ConstantBlock {
    Int3 origin{0};
    float value = 0;
};

/// The field with `constant` and `tiles` in place of its tiles, after change(origin, values) of
/// each block's 512 values.
FieldPointer changedBlocks(const SparseField& field, const std::vector<ConstantBlock>& constant,
                           std::vector<ConstantTile> tiles,
                           const std::function<void(const Int3& origin, float* values)>& change);

/// Emitted radiance per world unit as a sum of field times colour: one field where all colours of
/// the ramp are shades of one colour, else three. They stay on the lattice of `field`.
struct EmittedField {
    FieldPointer field;
    Rgb color;
};
std::vector<EmittedField> emittedFields(const FieldPointer& field, const Emission& emission);

}  // namespace scrim
