// SPDX-License-Identifier: Apache-2.0
// Cameras that stand in the headers of pictures: OpenEXR's worldToCamera and worldToNDC, as renderers write them, and
// Scrim's own words.
#pragma once

#include <scrim/geometry/camera.h>
#include <scrim/image/colour.h>
#include <scrim/image/picture_module.h>
#include <scrim/scene/scene.h>

#include <string>

namespace scrim {

/// The camera that made a picture with this header, of its display window; `near` is 0. Renderers disagree:
/// - a left-handed worldToCamera looks along +z (OpenEXR's documents, RenderMan, Mantra), a right-handed one along -z
///   (Scrim, Karma, Arnold);
/// - worldToNDC has its middle at 0 (-1..1) or at 1/2 (0..1), with y up or down; `ndc` says which, or it is told from
///   where the middle is;
/// - Mantra's worldToNDC is negative in front of the camera: as if it looked the other way. It is read as if it were
/// not. Throws Error(input) where there is no such camera, where the two do not fit together, or the picture's shape is
/// not that of the lens, and where it cannot be told what is meant.
Camera cameraOf(const PictureHeader& header, NdcRange ndc, const ColourConfig& colour);

/// The camera as [camera] of a scene has it: what Scrim writes into its pictures, exact where matrices of floats are
/// not.
std::string cameraText(const Camera& camera);

}  // namespace scrim
