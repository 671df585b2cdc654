// SPDX-License-Identifier: Apache-2.0
// The eye's frustum, cut up where it is too wide for one sweep. Every part is swept on its own; neighbours overlap with
// smooth weights that sum to one, because two sweeps differ by their errors and a hard edge would show them.
#pragma once

#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// A ramp from 0 to 1 over [from, to] raster positions along one axis; from == to: 1 everywhere.
struct Fade {
    double from = 0, to = 0;
    double at(double position) const;
};

struct EyePart {
    PixelWindow window;              ///< pixels of the picture in which the part counts, before any crop
    Fade left, right, top, bottom;   ///< this part counts left(x) (1 - right(x)) top(y) (1 - bottom(y))
    bool whole = true;               ///< the only part: its weight is 1 everywhere
    std::vector<Vec3> wsDirections;  ///< unit, away from the eye; their cone holds its rays that meet the volume

    double weight(double x, double y) const;
};

/// The parts of a scene's eye: one, unless its rays to the volume open wider than 45 degrees from their middle. Does
/// not depend on a crop, whose pixels must come out as in the whole picture.
std::vector<EyePart> eyeParts(const ViewScene& scene, const std::vector<Vec3>& wsCorners);

}  // namespace scrim
