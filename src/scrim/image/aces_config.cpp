// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/aces_config.h>

#include <OpenColorIO/OpenColorIO.h>

#include <sstream>
#include <vector>

namespace OCIO = OCIO_NAMESPACE;

namespace scrim {

namespace {

constexpr const char* kAp0FromAp1 = "ACEScg_to_ACES2065-1";
constexpr const char* kRec709FromAp1 = "UTILITY - ACES-AP1_to_LINEAR-REC709_BFD";
constexpr const char* kXyzFromAp0 = "UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD";
constexpr const char* kSdrXyzFromAp0 = "ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0";
constexpr const char* kSrgbFromXyz = "DISPLAY - CIE-XYZ-D65_to_sRGB";

OCIO::TransformRcPtr builtin(const char* style, OCIO::TransformDirection direction) {
    OCIO::BuiltinTransformRcPtr transform = OCIO::BuiltinTransform::Create();
    transform->setStyle(style);
    transform->setDirection(direction);
    return transform;
}

OCIO::TransformRcPtr sequence(const std::vector<OCIO::TransformRcPtr>& steps) {
    OCIO::GroupTransformRcPtr group = OCIO::GroupTransform::Create();
    for (const OCIO::TransformRcPtr& step : steps) group->appendTransform(step);
    return group;
}

/// The decoding curve of IEC 61966-2-1. OpenColorIO 2.1 has no built-in style for the curve alone.
OCIO::TransformRcPtr srgbDecode() {
    constexpr double kExponent[4] = {2.4, 2.4, 2.4, 1.0};
    constexpr double kOffset[4] = {0.055, 0.055, 0.055, 0.0};
    OCIO::ExponentWithLinearTransformRcPtr curve = OCIO::ExponentWithLinearTransform::Create();
    curve->setGamma(kExponent);
    curve->setOffset(kOffset);
    return curve;
}

struct SpaceText {
    const char* name;
    const char* family;
    const char* encoding;
    std::vector<const char*> aliases;
};

OCIO::ColorSpaceRcPtr space(OCIO::ReferenceSpaceType reference, const SpaceText& text) {
    OCIO::ColorSpaceRcPtr made = OCIO::ColorSpace::Create(reference);
    made->setName(text.name);
    made->setFamily(text.family);
    made->setEncoding(text.encoding);
    made->setBitDepth(OCIO::BIT_DEPTH_F32);
    for (const char* alias : text.aliases) made->addAlias(alias);
    return made;
}

void addSceneSpaces(OCIO::Config& config) {
    const auto scene = OCIO::REFERENCE_SPACE_SCENE;
    const auto toReference = OCIO::COLORSPACE_DIR_TO_REFERENCE;
    const auto ap0FromAp1 = [] { return builtin(kAp0FromAp1, OCIO::TRANSFORM_DIR_FORWARD); };
    const auto ap1FromRec709 = [] { return builtin(kRec709FromAp1, OCIO::TRANSFORM_DIR_INVERSE); };

    config.addColorSpace(space(scene, {"ACES2065-1", "ACES", "scene-linear", {"lin_ap0", "ACES - ACES2065-1"}}));

    OCIO::ColorSpaceRcPtr acesCg = space(scene, {"ACEScg", "ACES", "scene-linear", {"lin_ap1"}});
    acesCg->addAlias("ACES - ACEScg");
    acesCg->setTransform(ap0FromAp1(), toReference);
    config.addColorSpace(acesCg);

    OCIO::ColorSpaceRcPtr rec709 =
        space(scene, {"Linear Rec.709 (sRGB)", "Utility", "scene-linear", {"lin_rec709", "lin_srgb"}});
    rec709->setTransform(sequence({ap1FromRec709(), ap0FromAp1()}), toReference);
    config.addColorSpace(rec709);

    OCIO::ColorSpaceRcPtr srgb =
        space(scene, {"sRGB - Texture", "Utility", "sdr-video", {"sRGB", "srgb_tx", "srgb_texture"}});
    srgb->setTransform(sequence({srgbDecode(), ap1FromRec709(), ap0FromAp1()}), toReference);
    config.addColorSpace(srgb);

    OCIO::ColorSpaceRcPtr raw = space(scene, {"Raw", "Utility", "data", {}});
    raw->setIsData(true);
    config.addColorSpace(raw);
}

void addDisplay(OCIO::Config& config) {
    config.addColorSpace(
        space(OCIO::REFERENCE_SPACE_DISPLAY, {"CIE-XYZ-D65", "Display", "display-linear", {"cie_xyz_d65"}}));

    OCIO::ColorSpaceRcPtr srgb =
        space(OCIO::REFERENCE_SPACE_DISPLAY, {"sRGB - Display", "Display", "sdr-video", {"srgb_display"}});
    srgb->setTransform(builtin(kSrgbFromXyz, OCIO::TRANSFORM_DIR_FORWARD), OCIO::COLORSPACE_DIR_FROM_REFERENCE);
    config.addColorSpace(srgb);

    const auto addView = [&config](const char* name, const char* style) {
        OCIO::ViewTransformRcPtr view = OCIO::ViewTransform::Create(OCIO::REFERENCE_SPACE_SCENE);
        view->setName(name);
        view->setTransform(builtin(style, OCIO::TRANSFORM_DIR_FORWARD), OCIO::VIEWTRANSFORM_DIR_FROM_REFERENCE);
        config.addViewTransform(view);
        config.addDisplayView("sRGB", name, name, "sRGB - Display", "", "", "");
    };
    addView("ACES 1.0 SDR", kSdrXyzFromAp0);
    addView("Un-tone-mapped", kXyzFromAp0);
    config.addDisplayView("sRGB", "Raw", "Raw", "");
    config.setDefaultViewTransformName("Un-tone-mapped");
}

}  // namespace

std::string acesConfigText() {
    OCIO::ConfigRcPtr config = OCIO::Config::Create();
    config->setVersion(2, 1);
    config->setDescription("Scrim's own small ACES config, built from OpenColorIO's built-in transforms");
    addSceneSpaces(*config);
    addDisplay(*config);
    config->setRole(OCIO::ROLE_SCENE_LINEAR, "ACEScg");
    config->setRole(OCIO::ROLE_RENDERING, "ACEScg");
    config->setRole(OCIO::ROLE_DATA, "Raw");
    config->setRole(OCIO::ROLE_DEFAULT, "Raw");
    config->setRole(OCIO::ROLE_INTERCHANGE_SCENE, "ACES2065-1");
    config->setRole(OCIO::ROLE_INTERCHANGE_DISPLAY, "CIE-XYZ-D65");
    config->validate();
    std::ostringstream text;
    config->serialize(text);
    return text.str();
}

}  // namespace scrim
