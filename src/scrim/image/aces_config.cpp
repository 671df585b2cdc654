// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/aces_config.h>

#include <OpenColorIO/OpenColorIO.h>

#include <algorithm>
#include <iterator>
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

/// Takes CIE XYZ of a display towards grey where it is outside of Rec.709, by the curve of ACES
/// 1.3's Reference Gamut Compression. Clipped, all fire below 1900 K that is not bright is pure
/// red. The compression that OpenColorIO has built in is that into AP1, in which all of the working
/// space is: 1000 K at 0.18 stays 188, 0, 11 in sRGB. Here, 189, 0, 0 becomes 189, 36, 24.
///
/// It follows the tone curve, which takes what is in AP1 to what is in AP1. Before the curve, it
/// would make bright fire white: the curve keeps a yellow only of what is saturated.
OCIO::TransformRcPtr compressToRec709() {
    // Distances from grey along cyan, magenta and yellow that become 1; distances from which on they change; the power
    // of the curve. Published for AP1 are 1.147, 1.264, 1.312; 0.815, 0.803, 0.880; 1.2. But in Rec.709, the farthest
    // colours of AP1 are at 1.545, 1.076 and 1.113; and colours of the ColorChecker, which the published thresholds are
    // to spare, at 0.87, 0.91 and 0.98. With these thresholds, those of its colours that sRGB has change by 7 of 255 at
    // most; with the published numbers, by 17.
    constexpr double kLimitsThresholdsPower[] = {1.56, 1.264, 1.13, 0.92, 0.90, 0.95, 1.2};
    const auto rec709FromXyz = [](OCIO::TransformDirection direction) {
        const bool forward = direction == OCIO::TRANSFORM_DIR_FORWARD;
        const auto back = forward ? OCIO::TRANSFORM_DIR_INVERSE : OCIO::TRANSFORM_DIR_FORWARD;
        std::vector<OCIO::TransformRcPtr> steps{builtin(kXyzFromAp0, back), builtin(kAp0FromAp1, back),
                                                builtin(kRec709FromAp1, direction)};
        if (!forward) std::reverse(steps.begin(), steps.end());
        return sequence(steps);
    };
    return sequence({rec709FromXyz(OCIO::TRANSFORM_DIR_FORWARD),
                     OCIO::FixedFunctionTransform::Create(OCIO::FIXED_FUNCTION_ACES_GAMUT_COMP_13,
                                                          kLimitsThresholdsPower, std::size(kLimitsThresholdsPower)),
                     rec709FromXyz(OCIO::TRANSFORM_DIR_INVERSE)});
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

    const auto addView = [&config](const char* name, const OCIO::TransformRcPtr& displayFromScene) {
        OCIO::ViewTransformRcPtr view = OCIO::ViewTransform::Create(OCIO::REFERENCE_SPACE_SCENE);
        view->setName(name);
        view->setTransform(displayFromScene, OCIO::VIEWTRANSFORM_DIR_FROM_REFERENCE);
        config.addViewTransform(view);
        config.addDisplayView("sRGB", name, name, "sRGB - Display", "", "", "");
    };
    addView("ACES 1.0 SDR", sequence({builtin(kSdrXyzFromAp0, OCIO::TRANSFORM_DIR_FORWARD), compressToRec709()}));
    addView("Un-tone-mapped", builtin(kXyzFromAp0, OCIO::TRANSFORM_DIR_FORWARD));
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
