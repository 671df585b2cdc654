// SPDX-License-Identifier: Apache-2.0
// Fields with the shading of a scene, computed once after they were read.
#pragma once

#include <scrim/scene/scene.h>
#include <scrim/shot/derived_fields.h>

#include <functional>
#include <vector>

namespace scrim {

/// The density after `shading`. `mask` is the grid of its mask, if it has one. `wsFromAsset` places
/// the volume in the scene. Throws Error(memory) where constant regions are too large for voxels of
/// their own, which masks and noise need.
FieldPointer shadedDensity(const FieldPointer& density, const DensityShading& shading, const FieldPointer& mask,
                           const Mat4& wsFromAsset);

/// The field as it is at x - displacement(x), where each coordinate of the displacement is
/// `noise.amount` times a pattern of its own. Throws likewise.
FieldPointer displacedField(const FieldPointer& field, const Noise& noise, const Mat4& wsFromAsset);

/// The field times the values that `mask` makes of its grid, at the voxels of the field. Throws likewise.
FieldPointer maskedField(const FieldPointer& field, const Mask& mask, const FieldPointer& grid);

/// The field with each voxel times the part of it that lies in the intersection of `spaces`, which
/// are in the field's own world. Throws likewise.
FieldPointer clippedField(const FieldPointer& field, const std::vector<HalfSpace>& spaces);

/// Shades the fields of volumes, and keeps the results as long as the next frame needs them, too. A
/// volume without shading gets its fields back.
class FieldShader {
  public:
    FieldPointer density(const SceneVolume& volume, const FieldPointer& field, const FieldPointer& mask);
    FieldPointer displaced(const SceneVolume& volume, const FieldPointer& field);
    /// Forgets what was not asked for since the last call.
    void forgetUnused();

  private:
    /// A result, and all that it depends on.
    struct Shaded {
        FieldPointer field, mask;
        DensityShading shading = {};
        std::optional<Noise> displacement = {};
        Mat4 wsFromAsset{1.0};
        FieldPointer made = nullptr;
        bool used = true;
    };
    FieldPointer kept(Shaded wanted, const std::function<FieldPointer()>& make);

    std::vector<Shaded> m_all;
};

}  // namespace scrim
