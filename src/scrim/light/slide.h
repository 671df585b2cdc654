// SPDX-License-Identifier: Apache-2.0
// The slide of a projective textured light (ZC02 section 5): a picture that the light shines through. Where its
// picture falls is slide_map.h's matter, how it is filtered slide_tile.h's.
#pragma once

#include <scrim/image/texture.h>

#include <memory>
#include <string>

namespace scrim {

/// What the light is like beyond the picture's border.
enum class SlideOutside { black, clamp, repeat };

struct Slide {
    std::string file;        ///< at this frame
    std::string colorspace;  ///< of the file; "": as readTexture chooses
    std::string where;       ///< of `file` in the scene: "scene.toml:12:18"
    double fov = 30;         ///< horizontal field of view, degrees; not of distant lights
    double width = 1;        ///< distant lights: world units across the picture
    double height = 0;       ///< distant lights: world units; 0: from `width` and the picture's aspect
    double roll = 0;         ///< degrees, clockwise for a viewer who stands at the light and looks along it
    SlideOutside outside = SlideOutside::black;
    std::shared_ptr<const Texture> image;  ///< null until it is loaded
};

}  // namespace scrim
