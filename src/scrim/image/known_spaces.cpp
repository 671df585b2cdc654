// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/known_spaces.h>

#include <scrim/base/letter_case.h>

namespace scrim {

namespace {

/// Identifiers: ASWF Color Interop Forum, "Color Space Encodings for Texture Assets and CG Rendering".
/// Names: the ACES configs for OpenColorIO 1.x and 2.x, and Blender's.
const std::vector<KnownSpace>& knownSpaces() {
    static const std::vector<KnownSpace> spaces = {
        {"lin_ap1_scene", {"ACEScg", "lin_ap1", "ACES - ACEScg"}},
        {"lin_ap0_scene", {"ACES2065-1", "lin_ap0", "aces2065_1", "ACES - ACES2065-1"}},
        {"lin_rec709_scene",
         {"Linear Rec.709 (sRGB)", "lin_rec709", "lin_rec709_srgb", "lin_srgb", "Linear Rec.709",
          "Utility - Linear - Rec.709", "Utility - Linear - sRGB"}},
        {"lin_p3d65_scene", {"Linear P3-D65", "lin_p3d65", "Utility - Linear - P3-D65"}},
        {"lin_rec2020_scene", {"Linear Rec.2020", "lin_rec2020", "Utility - Linear - Rec.2020"}},
        {"lin_adobergb_scene", {"Linear AdobeRGB", "lin_adobergb", "Utility - Linear - Adobe RGB"}},
        {"srgb_rec709_scene",
         {"sRGB - Texture", "sRGB", "srgb_tx", "srgb_texture", "sRGB Encoded Rec.709 (sRGB)",
          "Utility - sRGB - Texture"}},
        {"g22_rec709_scene", {"Gamma 2.2 Rec.709 - Texture", "g22_rec709", "g22_rec709_tx"}},
        {"g18_rec709_scene", {"Gamma 1.8 Rec.709 - Texture", "g18_rec709", "g18_rec709_tx"}},
        {"srgb_ap1_scene", {"sRGB Encoded AP1 - Texture", "srgb_ap1", "srgb_ap1_tx"}},
        {"srgb_p3d65_scene", {"sRGB Encoded P3-D65 - Texture", "srgb_p3d65", "srgb_p3d65_tx"}},
    };
    return spaces;
}

}  // namespace

const KnownSpace* findKnownSpace(std::string_view name) {
    for (const KnownSpace& space : knownSpaces()) {
        if (equalIgnoringCase(name, space.interopId)) return &space;
        for (const std::string_view known : space.names)
            if (equalIgnoringCase(name, known)) return &space;
    }
    return nullptr;
}

}  // namespace scrim
