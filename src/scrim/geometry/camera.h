// SPDX-License-Identifier: Apache-2.0
// Cameras, and the family of rays that a camera sends through its raster.
#pragma once

#include <scrim/geometry/spaces.h>

namespace scrim {

enum class CameraType { perspective, orthographic };

/// The camera's place and projection. It looks along -z of its own frame, with y up.
struct Camera {
    CameraType type = CameraType::perspective;
    Vec3 wsPosition{0, 0, 1};
    Mat3 wsFromCamera{1.0};  ///< columns: right, up, back; orthonormal
    double fov = 35.0;       ///< perspective: horizontal field of view, degrees, in (0, 180)
    double height = 2.0;     ///< orthographic: height of the picture, world units
    double near = 0.0;       ///< depth along the viewing axis from which on the camera sees, world units
    Int2 resolution{512, 512};
    double pixelAspect = 1.0;  ///< width of a pixel over its height
    Vec2 shift{0};             ///< moves the picture's window to the right and up, in widths of the picture
};

/// A thin lens in place of a point: what is not at its distance is blurred.
struct Lens {
    double radius = 0;  ///< world units
    double focus = 1;   ///< depth along the viewing axis at which things are sharp, world units
};

/// What a perspective camera sees from one place on its lens, (x, y) in radii to the right and up.
/// Things at the depth of the focus keep their places in the picture.
Camera throughLens(Camera camera, const Lens& lens, const Vec2& place);

/// The diameter, in pixels, of the picture of a point at this depth along the viewing axis.
double blurAt(const Camera& camera, const Lens& lens, double depth);

/// An orthonormal frame at `position` that looks at `target`, with `up` as near to y as possible. Where `up` lies along
/// the line of sight, another axis takes its place. `position` and `target` must differ.
Mat3 lookAt(const Vec3& position, const Vec3& target, const Vec3& up);

/// Rays as affine functions of the raster position (x, y): origin and direction are each `0 + x*X + y*Y`. Directions
/// are scaled so that their component along the viewing axis is 1; therefore `t` along a ray is depth. One formula
/// covers perspective views (constant origin) and orthographic ones (constant direction).
struct RayFamily {
    Vec3 origin0{0}, originX{0}, originY{0};
    Vec3 direction0{0}, directionX{0}, directionY{0};
    double near = 0;  ///< depth at which rays begin

    Vec3 origin(double x, double y) const { return origin0 + x * originX + y * originY; }
    Vec3 direction(double x, double y) const { return direction0 + x * directionX + y * directionY; }
};

/// The camera's rays in world space; raster positions are in its own pixels.
RayFamily wsRays(const Camera& camera);

/// The width, in world units, that a pixel covers at `distance` from the camera.
double pixelAt(const Camera& camera, double distance);

/// The viewing direction in world space (unit, away from the eye).
inline Vec3 viewingAxis(const Camera& camera) {
    return -camera.wsFromCamera[2];
}

/// The direction of travel (unit) of light that goes from `ws` to the eye.
Vec3 travelToEye(const Camera& camera, const Vec3& ws);

/// `camera` with every pixel divided into n x n.
Camera supersampled(Camera camera, int n);

/// The map from world to camera space as EXR's `worldToCamera` defines it: x right, y up, looking
/// along -z (column vectors).
Mat4 worldToCamera(const Camera& camera);

/// The map from world space to normalised device coordinates, x and y in [-1, 1] over the picture (column vectors).
Mat4 worldToNdc(const Camera& camera);

}  // namespace scrim
