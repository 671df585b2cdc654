// SPDX-License-Identifier: Apache-2.0
// Small fields made in code, and scenes around them, for tests that need no files.
#pragma once

#include <scrim/engine/sweep.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <functional>
#include <memory>
#include <string>

namespace scrim::test {

/// The voxels lower .. upper (inclusive) with value(index position), index space scaled by `voxel`.
std::shared_ptr<SparseField> makeField(const Int3& lower, const Int3& upper, double voxel,
                                       const std::function<double(const Vec3& is)>& value);

/// A box of constant value 1.
std::shared_ptr<SparseField> boxField(const Int3& lower, const Int3& upper, double voxel = 1);

/// Smoke of no particular shape: smooth bumps inside a ball of `radius` voxels, wispy at its edge.
std::shared_ptr<SparseField> smokeField(int radius, double voxel = 1);

/// A scene with one volume, an orthographic camera looking along -z that sees `height` world units, and no light;
/// texels and sheets of one voxel.
ViewScene orthographicScene(std::shared_ptr<const SparseField> field, const Medium& medium, double height,
                            int resolution);

/// A distant light that travels along `direction` with the given irradiance.
Light distantLight(const Vec3& direction, double irradiance = 1);

/// A point light.
Light lamp(const Vec3& wsPosition, double intensity, double radius = 0);

/// Plan and render in one go.
Frame renderScene(const ViewScene& scene);

/// "linear".
std::string nameOf(Kernel kernel);

/// RGBA of pixel (x, y).
std::array<double, 4> pixelOf(const Frame& frame, int x, int y);

}  // namespace scrim::test
