// SPDX-License-Identifier: Apache-2.0
// The dials: every setting that trades accuracy for time, as values. Their names, units, defaults, ranges and
// meanings stand in one table in quality.h.
#pragma once

#include <scrim/light/shadow_buffer.h>
#include <scrim/splat/kernel.h>

#include <string>

namespace scrim {

enum class ShadeMode { automatic, texel, pixel };
enum class SheetAxis { halfWay, imageAligned };
enum class SplatMode { shared, perView };
enum class ShadowPlane { light, image };

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
    double maxSlant = 60;         ///< degrees
    double crossFade = 2;         ///< degrees around perpendicular in which a light is served from both sides
    double opacityCutoff = 1e-3;  ///< transmittance below which a pixel counts as opaque
    double lod = 0;               ///< pixels a voxel may shrink to before a coarser level is fed; 0: never
    int antialias = 1;            ///< n x n rays a pixel
    std::string simd = "auto";    ///< instruction set: auto, or the most one may use
};

}  // namespace scrim
