// SPDX-License-Identifier: Apache-2.0
// What tells how large the things in a preview are, and how they are turned.
#pragma once

#include <scrim/geometry/camera.h>
#include <scrim/image/colour.h>

namespace scrim {

/// Where the middle of what a picture shows lies, as a display shows it.
struct PreviewMarks {
    Camera camera;
    Vec3 wsMiddle{0};
};

/// The largest of 1, 2 and 5 times a power of ten that is at most `length`, which must be above 0.
double roundLength(double length);

/// Draws into the picture of a whole camera: at the lower left a bar with its length in world units, which is round and
/// true at the middle; at the lower right the directions of the world's x, y and z (red, green, blue) as they are seen
/// there, each with its letter. Lines are white beside that, on a dark rim.
void drawMarks(DisplayImage& picture, const PreviewMarks& marks);

}  // namespace scrim
