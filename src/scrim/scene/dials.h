// SPDX-License-Identifier: Apache-2.0
// The values of the dials: every setting that trades accuracy for time. Their names, units,
// defaults, ranges and meanings stand in one table in quality.h.
#pragma once

#include <scrim/volume/sparse_field.h>

#include <optional>
#include <string>

namespace scrim {

enum class ShadowFilter { bilinear, nearest };
enum class ShadeMode { automatic, texel, pixel };
enum class SheetAxis { halfWay, imageAligned };
enum class SplatMode { shared, perView };
enum class ShadowPlane { light, image };

/// Default angle of a cross-fade, degrees. It is small, so that few lights pay for a second sweep, and large enough
/// that a light that crosses the perpendicular by one degree a frame fades over several frames.
inline constexpr double kCrossFade = 2;

/// Edge, in voxels, of the cells that carry multiply scattered light, where neither the scene nor a preset says one.
inline constexpr double kScatterCell = 2;

struct Dials {
    double sheetThickness = 1.5;  ///< voxels, before the factor of the cosine of the worst slant
    double texel = 0.7;           ///< edge of a texel, voxels
    Kernel kernel = Kernel::linear;
    int footprintSteps = 8;  ///< tabulated footprint positions per voxel along each axis; a power of two
    double shadowTexel = 1;  ///< edge of a shadow buffer's cell, texels
    ShadowFilter shadowFilter = ShadowFilter::bilinear;
    SplatMode splat = SplatMode::shared;
    ShadeMode shade = ShadeMode::automatic;
    ShadowPlane shadowPlane = ShadowPlane::light;
    SheetAxis sheets = SheetAxis::halfWay;
    double maxSlant = 60;  ///< degrees
    /// Angle around perpendicular, degrees, within which a light is swept from both sides. Without
    /// a value it is kCrossFade where the scene moves and 0 where it stands still.
    std::optional<double> crossFade;
    double opacityCutoff = 1e-3;  ///< transmittance below which a pixel counts as opaque
    double lightError = 0.005;    ///< relative error allowed to the sub-lights that represent an extended light
    /// Projected size of a voxel, pixels, below which a coarser level is splatted; 0: never; no
    /// value: chosen for the preset's promise (verify/promise.h), or 0 where nobody chooses.
    std::optional<double> lod;
    int antialias = 1;                ///< n x n rays a pixel
    std::optional<double> lightCell;  ///< edge, in voxels, of the smallest cells of lights on cells; no value: chosen
    /// The edge of the larger cells of other volumes, relative to what is chosen for them; no
    /// value: 1, or less where the smallest cells are smaller than chosen.
    std::optional<double> lightCellOthers;
    /// Edge, in voxels, of the cells that carry multiply scattered light; no value: chosen for the
    /// preset's promise (verify/promise.h), or kScatterCell where nobody chooses.
    std::optional<double> scatterCell;
    /// Directions that carry multiply scattered light; no value: chosen from the phase functions.
    std::optional<int> scatterDirections;
    /// Sweeps of multiply scattered light end when further ones are expected to change it by less than this, relative.
    double scatterError = 0.005;
    std::optional<int> shutterSamples;  ///< renders that motion blur averages; no value: chosen from the motion
    std::string simd = "auto";          ///< instruction set: "auto", or the highest one allowed
};

}  // namespace scrim
