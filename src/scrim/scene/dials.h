// SPDX-License-Identifier: Apache-2.0
// The dials: every setting that trades accuracy for time, as values. Their names, units, defaults, ranges and
// meanings stand in one table in quality.h.
#pragma once

#include <scrim/volume/kernel.h>

#include <optional>
#include <string>

namespace scrim {

enum class ShadowFilter { bilinear, nearest };
enum class ShadeMode { automatic, texel, pixel };
enum class SheetAxis { halfWay, imageAligned };
enum class SplatMode { shared, perView };
enum class ShadowPlane { light, image };

/// Degrees of a cross-fade where no other number is given: little enough that few lights pay for it, enough that one
/// which crosses the perpendicular at a degree a frame is seen to fade.
inline constexpr double kCrossFade = 2;

struct Dials {
    double sheetThickness = 1.5;  ///< voxels, before the cosine of the worst slant
    double texel = 0.7;           ///< voxels
    Kernel kernel = Kernel::linear;
    int footprintSteps = 8;  ///< quantised positions a voxel along each axis, a power of two
    double shadowTexel = 1;  ///< texels a shadow buffer's cell
    ShadowFilter shadowFilter = ShadowFilter::bilinear;
    SplatMode splat = SplatMode::shared;
    ShadeMode shade = ShadeMode::automatic;
    ShadowPlane shadowPlane = ShadowPlane::light;
    SheetAxis sheets = SheetAxis::halfWay;
    double maxSlant = 60;  ///< degrees
    /// Degrees around perpendicular in which a light is served from both sides; nothing: kCrossFade where the scene
    /// moves, 0 where it stands still.
    std::optional<double> crossFade;
    double opacityCutoff = 1e-3;  ///< transmittance below which a pixel counts as opaque
    double lightError = 0.005;    ///< relative, that sub-lights may leave of lights that are larger than a point
    double lod = 0;               ///< pixels a voxel may shrink to before a coarser level is splatted; 0: never
    int antialias = 1;            ///< n x n rays a pixel
    double scatterCell = 2;  ///< voxels: edge of the cells that light is carried through which scatters more than once
    std::optional<int> scatterDirections;  ///< that it is carried along; nothing: by the phase functions
    double scatterError = 0.002;           ///< relative change by a sweep of them that is small enough
    std::optional<int> shutterSamples;     ///< renders that motion blur is the mean of; nothing: chosen by the motion
    std::string simd = "auto";             ///< instruction set: auto, or the most one may use
};

}  // namespace scrim
