// SPDX-License-Identifier: Apache-2.0
// Where a light's slide falls: the projective map from the world to the slide's pixels (ZC02 section 5's light
// screen), in double precision, and the slide's exact value at a point.
//
// Slide coordinates count pixels of the picture: x to the right, y down, pixel (0, 0) covers [0, 1) x [0, 1). The
// picture is upright and not mirrored for a viewer who stands at the light, looks along it and holds the head so that
// the light's `up` is up.
#pragma once

#include <scrim/geometry/sheets.h>
#include <scrim/geometry/spaces.h>
#include <scrim/scene/light.h>

#include <optional>
#include <vector>

namespace scrim {

/// (X, Y, W) = perWs * (ws - wsOrigin) + atOrigin; the slide position is (X / W, Y / W), and where W <= 0 the light
/// does not shine: that is behind it. Distant lights have W = 1 everywhere.
struct SlideMap {
    /// The map over one sheet: (X, Y, W) = atOrigin + u perU + v perV + (N - middle) perN, with u and v in texels and N
    /// in sheets.
    struct OnSheet {
        Vec3 atOrigin{0, 0, 1}, perU{0}, perV{0}, perN{0};
    };

    Vec3 wsOrigin{0};
    Mat3 perWs{0.0};
    Vec3 atOrigin{0, 0, 1};

    Vec3 homogeneous(const Vec3& ws) const { return perWs * (ws - wsOrigin) + atOrigin; }
};

/// Of a light with a slide whose image is loaded.
SlideMap slideMap(const Light& light);

/// The slide over the light's intensity at `ws`: bilinear between the picture's pixels, whatever their size.
Rgb slideValue(const Light& light, const SlideMap& map, const Vec3& ws);

/// Composed in double from the sheets' local origin.
SlideMap::OnSheet sheetMap(const SlideMap& map, const Sheets& sheets, double middle);

/// Half the angle between the opposite corners of the slide of a light that is not distant; radians.
double slideHalfAngle(const Light& light);

/// Directions (unit) from a light that is not distant through the corners of its slide.
std::vector<Vec3> slideCorners(const Light& light);

/// The corners of a distant light's slide in world space.
std::vector<Vec3> distantSlideCorners(const Light& light);

/// World units that a pixel of the slide covers at `ws`, the smaller of its two edges; nothing behind the light.
std::optional<double> slidePixel(const Light& light, const Vec3& ws);

}  // namespace scrim
