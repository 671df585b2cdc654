// SPDX-License-Identifier: Apache-2.0
// Fields that are made of a scene's grids voxel by voxel, before anything is splatted. What is splatted is linear in
// them, so that a picture shows the same, whatever sheets and texels are.
#pragma once

#include <scrim/scene/view_scene.h>

#include <array>
#include <memory>
#include <utility>
#include <vector>

namespace scrim {

using FieldPointer = std::shared_ptr<const SparseField>;

/// The field with its voxels remapped, linear between the ramp's points and constant beyond them. Empty space stays
/// empty, whatever the ramp says of 0: only active voxels are splatted.
FieldPointer withRamp(const SparseField& field, const std::vector<std::pair<double, double>>& ramp);

/// Of red, green and blue, the density times the albedo at each of the density's voxels, on the density's lattice. The
/// grid's colour is in its own space (see ColourGrid), interpolated where the lattices differ, and cut to [0, 1]. A
/// product of voxels and not of reconstructed fields: where both end together, colours do not darken towards the rim.
std::vector<FieldPointer> scatteringFields(const SparseField& density, const std::array<FieldPointer, 3>& albedo,
                                           const ColourGrid& look);

/// Of x, y and z the density times (velocity - `least`) at each of the density's voxels, on the density's lattice.
/// `velocity`: the parts above and below 0 of each (GridPart), in the asset's space. `assetFromIs`: of the density.
std::vector<FieldPointer> flowFields(const SparseField& density, const Mat4& assetFromIs,
                                     const std::vector<FieldPointer>& velocity, const Vec3& least);

/// Radiance per world unit as fields times colours: one field where all of the ramp is shades of one colour, else
/// three. They stay on the lattice of `field`.
struct EmittedField {
    FieldPointer field;
    Rgb color;
};
std::vector<EmittedField> emittedFields(const FieldPointer& field, const Emission& emission);

}  // namespace scrim
