// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/known_spaces.h>

#include <scrim/base/letter_case.h>

namespace scrim {

namespace {

// SMPTE ST 2065-1 and the ACES specification S-2014-004; ITU-R BT.709 and BT.2020; SMPTE EG 432-1; Adobe RGB (1998).
constexpr Chromaticities kAp0{0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.077f, 0.32168f, 0.33767f};
constexpr Chromaticities kAp1{0.713f, 0.293f, 0.165f, 0.83f, 0.128f, 0.044f, 0.32168f, 0.33767f};
constexpr Chromaticities kRec709{0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
constexpr Chromaticities kP3D65{0.68f, 0.32f, 0.265f, 0.69f, 0.15f, 0.06f, 0.3127f, 0.329f};
constexpr Chromaticities kRec2020{0.708f, 0.292f, 0.17f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.329f};
constexpr Chromaticities kAdobeRgb{0.64f, 0.33f, 0.21f, 0.71f, 0.15f, 0.06f, 0.3127f, 0.329f};

/// Identifiers: ASWF Color Interop Forum, "Color Space Encodings for Texture Assets and CG Rendering".
/// Names: the ACES configs for OpenColorIO 1.x and 2.x, and Blender's.
const std::vector<KnownSpace>& knownSpaces() {
    static const std::vector<KnownSpace> spaces = {
        {"lin_ap1_scene", {"ACEScg", "lin_ap1", "ACES - ACEScg"}, kAp1},
        {"lin_ap0_scene", {"ACES2065-1", "lin_ap0", "aces2065_1", "ACES - ACES2065-1"}, kAp0},
        {"lin_rec709_scene",
         {"Linear Rec.709 (sRGB)", "lin_rec709", "lin_rec709_srgb", "lin_srgb", "Linear Rec.709",
          "Utility - Linear - Rec.709", "Utility - Linear - sRGB"},
         kRec709},
        {"lin_p3d65_scene", {"Linear P3-D65", "lin_p3d65", "Utility - Linear - P3-D65"}, kP3D65},
        {"lin_rec2020_scene", {"Linear Rec.2020", "lin_rec2020", "Utility - Linear - Rec.2020"}, kRec2020},
        {"lin_adobergb_scene", {"Linear AdobeRGB", "lin_adobergb", "Utility - Linear - Adobe RGB"}, kAdobeRgb},
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
