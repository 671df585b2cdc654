// SPDX-License-Identifier: Apache-2.0
// Reads and writes cameras in the headers of pictures: OpenEXR's worldToCamera and worldToNDC, as
// renderers write them, and Scrim's own attribute.
#pragma once

#include <scrim/geometry/camera.h>
#include <scrim/image/colour.h>
#include <scrim/image/picture_module.h>
#include <scrim/scene/scene.h>

#include <string>

namespace scrim {

/// The camera that made a picture with this header, for the header's display window; `near` is 0. Renderers disagree
/// about the matrices:
/// - a left-handed worldToCamera looks along +z (OpenEXR's documents, RenderMan, Mantra), a right-handed one along -z
///   (Scrim, Karma, Arnold);
/// - worldToNDC has its middle at 0 (-1..1) or at 1/2 (0..1), with y up or down; `ndc` states which, or else the
///   middle's position decides;
/// - Mantra's worldToNDC is negative in front of the camera, as if it looked the other way; its sign is ignored.
/// Throws Error(input) where the header has no such camera, where the two matrices or the picture's shape and the lens
/// contradict each other, and where the convention cannot be told.
Camera cameraOf(const PictureHeader& header, NdcRange ndc, const ColourConfig& colour);

/// The camera as the keys of a scene's [camera]. Scrim writes this text into its pictures, because
/// it is exact and matrices of floats are not.
std::string cameraText(const Camera& camera);

}  // namespace scrim
