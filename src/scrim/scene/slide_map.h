// SPDX-License-Identifier: Apache-2.0
// Where a light's slide falls: the projective map from the world to the slide's pixels (the light
// screen of ZC02 section 5), in double precision, and the slide's exact value at a point.
//
// Slide coordinates count pixels of the picture: x to the right, y down, pixel (0, 0) covers [0, 1)
// x [0, 1). The picture is upright and not mirrored for a viewer who stands at the light, looks
// along it and whose up is the light's `up`.
#pragma once

#include <scrim/geometry/sheets.h>
#include <scrim/geometry/spaces.h>
#include <scrim/scene/light.h>

#include <optional>
#include <vector>

namespace scrim {

/// The homogeneous slide position is (X, Y, W) = perWs * (ws - wsOrigin) + atOrigin, and the position is (X / W, Y /
/// W). Where W <= 0 the point is behind the light, which does not shine there. Distant lights have W = 1 everywhere.
struct SlideMap {
    /// The map on sheets: (X, Y, W) = atOrigin + u perU + v perV + (N - middle) perN, with u and v
    /// in texels and N in sheets.
    struct OnSheet {
        Vec3 atOrigin{0, 0, 1}, perU{0}, perV{0}, perN{0};
    };

    Vec3 wsOrigin{0};
    Mat3 perWs{0.0};
    Vec3 atOrigin{0, 0, 1};

    Vec3 homogeneous(const Vec3& ws) const { return perWs * (ws - wsOrigin) + atOrigin; }
};

/// The map of a light whose slide has a loaded image.
SlideMap slideMap(const Light& light);

/// The factor by which the slide multiplies the light's intensity at `ws`: bilinear between the
/// picture's pixels, however large a pixel is there.
Rgb slideValue(const Light& light, const SlideMap& map, const Vec3& ws);

/// The map on sheets, composed in double precision from the sheets' local origin.
SlideMap::OnSheet sheetMap(const SlideMap& map, const Sheets& sheets, double middle);

/// Half the angle between opposite corners of the slide, radians. The light must not be distant.
double slideHalfAngle(const Light& light);

/// Unit directions from the light through the corners of its slide. The light must not be distant.
std::vector<Vec3> slideCorners(const Light& light);

/// The corners of a distant light's slide, in world space.
std::vector<Vec3> distantSlideCorners(const Light& light);

/// The smaller edge, in world units, of the area that one pixel of the slide covers at `ws`; no value behind the light.
std::optional<double> slidePixel(const Light& light, const Vec3& ws);

}  // namespace scrim
