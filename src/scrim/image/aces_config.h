// SPDX-License-Identifier: Apache-2.0
// Scrim's own OpenColorIO config for users who have none: the few ACES spaces that a renderer
// needs, built in memory from OpenColorIO's built-in transforms, so that no look-up file has to be
// installed or found. Making the config is separate from using any config (colour.h).
#pragma once

#include <string>

namespace scrim {

/// The small ACES config as the text of an .ocio file, validated. Scene reference ACES2065-1, display
/// reference CIE-XYZ-D65.
///   Spaces    ACEScg (scene_linear, rendering), ACES2065-1 (aces_interchange), "Linear Rec.709 (sRGB)",
///             "sRGB - Texture", "Raw" (data), "CIE-XYZ-D65", "sRGB - Display".
///   Display   "sRGB" with the views "ACES 1.0 SDR" (default), "Un-tone-mapped", "Raw". The first compresses colours
///             outside of the display's gamut instead of clipping them.
/// Throws OpenColorIO's exceptions if the library lacks a built-in transform.
std::string acesConfigText();

}  // namespace scrim
