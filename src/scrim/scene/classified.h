// SPDX-License-Identifier: Apache-2.0
// Classified shading, as ZC02 section 3.1 states it: a transfer function turns the reconstructed field into colour
// and extinction after splatting, gradients of the field serve as normals, and light is reflected after Phong.
#pragma once

#include <scrim/geometry/spaces.h>

#include <vector>

namespace scrim {

/// What a value of the field looks like. Linear between points, constant outside of them; two points of one value
/// are a step.
struct TransferPoint {
    double value = 0;       ///< of the field
    Rgb color{1};           ///< C_obj, working space
    double extinction = 0;  ///< per world unit
};

/// ZC02 eq. 3, 6, 8 and 9: k_a, k_d, k_s and k_n, and the transfer function that gives C_obj.
struct Classified {
    std::vector<TransferPoint> transfer;  ///< ascending values; a value of 0 has extinction 0
    double densityScale = 1;              ///< multiplies every extinction of it
    double ambient = 0.2;
    double diffuse = 0.7;
    double specular = 0.3;
    double exponent = 20;
    bool twoSided = false;  ///< |N.L| instead of max(N.L, 0): light from behind a surface counts, too
};

/// Colour and (scaled) extinction of one value of the field.
struct ClassifiedValue {
    Rgb color{0};
    double extinction = 0;
};
ClassifiedValue classify(const Classified& classified, double value);

/// Where the gradient (per world unit) vanishes there is no surface and no normal: the diffuse term then falls back
/// to 1, so that interiors are not black. Weight of the normal in [0, 1]; it is 1/2 where the field changes by a
/// hundredth of the transfer function's last value over a voxel.
double normalWeight(const Classified& classified, double gradientLength, double voxel);

/// The gradient's length (per world unit) at which a normal counts half.
double vagueGradient(const Classified& classified, double voxel);

/// Share of the light's irradiance over pi that is reflected, to be multiplied by the object's colour (`diffuse`)
/// or not (`specular`): eq. 3 for one light. Unit vectors: `normal` out of the dense side, `toLight`, `toEye`.
struct Reflected {
    double diffuse = 0, specular = 0;
};
Reflected phong(const Classified& classified, const Vec3& normal, double normalWeight, const Vec3& toLight,
                const Vec3& toEye);

}  // namespace scrim
