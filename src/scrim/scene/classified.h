// SPDX-License-Identifier: Apache-2.0
// Classified shading as ZC02 section 3.1 states it: a transfer function turns the reconstructed field into colour and
// extinction after splatting, gradients of the field serve as normals, and light is reflected by Phong's model.
#pragma once

#include <scrim/geometry/spaces.h>

#include <utility>
#include <vector>

namespace scrim {

/// A point of a transfer function, which is linear between points and constant outside of them. Two
/// points of equal value make a step.
struct TransferPoint {
    double value = 0;       ///< of the field
    Rgb color{1};           ///< C_obj, working space
    double extinction = 0;  ///< per world unit; or per voxel, see Classified
};

/// The coefficients k_a, k_d, k_s and k_n of ZC02 eq. 3, 6, 8 and 9, and the transfer function that gives C_obj.
struct Classified {
    std::vector<TransferPoint> transfer;  ///< ascending values; a value of 0 has extinction 0
    double densityScale = 1;              ///< factor on the extinction of every point
    /// Extinctions are per edge of a voxel, whatever unit the scan has; where the scene is
    /// assembled, `densityScale` takes the edge in.
    bool perVoxel = false;
    /// (length of the field's gradient per world unit, ascending; factor on the extinction, at most 1), linear between
    /// points and constant outside of them; empty: 1. Thus boundaries show, and homogeneous matter does not (J. Kniss,
    /// G. Kindlmann, C. Hansen, "Multidimensional transfer functions for interactive volume rendering", 2002).
    std::vector<std::pair<double, double>> gradientRamp = {};
    double ambient = 0.2;
    double diffuse = 0.7;
    double specular = 0.3;
    double exponent = 20;
    bool twoSided = false;  ///< uses |N.L| in place of max(N.L, 0), so that light from behind a surface counts, too
    /// Light that has scattered before, and light that comes from all around ([ambient], and domes but for their suns),
    /// scatters evenly to all sides, any number of times: the scattering coefficient is the extinction times the colour
    /// times `albedo`. Phong's model is left with the light that comes straight from lights, and `ambient` does not
    /// count, since what is around enters through the border of the volumes and is attenuated on its way.
    bool scatters = false;
    Rgb albedo{0.9};
};

/// Colour and scaled extinction of one value of the field.
struct ClassifiedValue {
    Rgb color{0};
    double extinction = 0;
};
ClassifiedValue classify(const Classified& classified, double value);

/// The largest part of the extinction that is scattered, in any channel and at any value of the field.
double mostScattered(const Classified& classified);
/// True if that part is the same in all channels at every value.
bool scattersGrey(const Classified& classified);
/// The largest extinction at any value up to `value`.
double mostExtinction(const Classified& classified, double value);

/// The factor on the extinction where the field's gradient (per world unit) has this length.
double gradientFactor(const Classified& classified, double gradientLength);

/// The windows of CT that have names.
enum class ScanWindow { bone, softTissue, lung, vessels };

/// The value of a grid at 0 Hounsfield units, as the volume source `scan` makes it: air is at 24,
/// and nothing is below 0.
inline constexpr double kHounsfieldZero = 1024;

/// The transfer function of a window, in Hounsfield units plus `zero`, with extinctions per voxel:
/// "bone" is opaque from 300 on, and so on.
std::vector<TransferPoint> transferOf(ScanWindow window, double zero = kHounsfieldZero);

/// The same for a window as viewers have it, [centre - width / 2, centre + width / 2]: from black and clear to white
/// and opaque. Values below 0 of the grid are empty, so that a window that begins there begins at 0.
std::vector<TransferPoint> transferOf(double centre, double width, double zero = kHounsfieldZero);

/// The weight, in [0, 1], of the normal in shading. Where the gradient (per world unit) vanishes there is neither
/// surface nor normal, and the diffuse term falls back to 1 so that interiors are not black. The weight is 1/2 where
/// the field changes by a hundredth of the transfer function's last value over one voxel (`voxel`, world units).
double normalWeight(const Classified& classified, double gradientLength, double voxel);

/// The length (per world unit) of the gradient that a cut face adds (geometry/half_space.h): a
/// change by the transfer function's last value over a voxel.
double cutGradient(const Classified& classified, double voxel);

/// The gradient's length (per world unit) at which the normal has the weight 1/2.
double vagueGradient(const Classified& classified, double voxel);

/// The fraction of irradiance / pi that is reflected, by ZC02 eq. 3 for one light. `diffuse` is to
/// be multiplied by the object's colour, `specular` is not. All vectors are unit: `normal` points
/// out of the dense side, `toLight` and `toEye` away from the surface.
struct Reflected {
    double diffuse = 0, specular = 0;
};
Reflected phong(const Classified& classified, const Vec3& normal, double normalWeight, const Vec3& toLight,
                const Vec3& toEye);

}  // namespace scrim
