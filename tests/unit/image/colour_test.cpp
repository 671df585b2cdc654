// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/colour.h>

#include <scrim/base/error.h>
#include <scrim/image/aces_config.h>
#include <scrim/image/blackbody.h>

#include "support/temp_folder.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <optional>

namespace scrim {
namespace {

/// Sets or unsets $OCIO while it lives.
class OcioVariable {
  public:
    explicit OcioVariable(const char* value) {
        if (const char* old = std::getenv("OCIO")) m_old = old;
        value != nullptr ? ::setenv("OCIO", value, 1) : ::unsetenv("OCIO");
    }
    ~OcioVariable() { m_old ? ::setenv("OCIO", m_old->c_str(), 1) : ::unsetenv("OCIO"); }
    OcioVariable(const OcioVariable&) = delete;
    OcioVariable& operator=(const OcioVariable&) = delete;

  private:
    std::optional<std::string> m_old;
};

ColourConfig ownConfig() {
    const OcioVariable unset(nullptr);
    return ColourConfig::open("");
}

Image onePixel(float r, float g, float b, float a) {
    return {{0, 0, 1, 1}, {r, g, b, a}};
}

/// A config like those of OpenColorIO 1: long names, no aliases.
constexpr const char* kOldConfig = R"(ocio_profile_version: 1
roles: {scene_linear: ACES - ACEScg, default: ACES - ACEScg}
displays:
  monitor:
    - !<View> {name: film, colorspace: Utility - sRGB - Texture}
colorspaces:
  - !<ColorSpace> {name: ACES - ACEScg, to_reference: !<MatrixTransform> {matrix: [2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1]}}
  - !<ColorSpace> {name: Utility - sRGB - Texture}
  - !<ColorSpace> {name: House Log, from_reference: !<FileTransform> {src: missing.spi1d}}
)";

template <typename Call>
std::string errorOf(const Call& call) {
    try {
        call();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        return error.what();
    }
    return "no error";
}

TEST(ColourConfig, OwnConfigWorksInAcesCg) {
    const ColourConfig colour = ownConfig();
    EXPECT_EQ(colour.name(), "scrim-aces");
    EXPECT_EQ(colour.workingSpace(), "ACEScg");
    EXPECT_EQ(colour.resolve("scene_linear"), "ACEScg");
    EXPECT_EQ(colour.resolve("rendering"), "ACEScg");
    EXPECT_EQ(colour.resolve("aces_interchange"), "ACES2065-1");
    EXPECT_EQ(colour.resolve("cie_xyz_d65_interchange"), "CIE-XYZ-D65");
}

TEST(ColourConfig, ResolvesAliasesInteropIdsAndAnyLetterCase) {
    const ColourConfig colour = ownConfig();
    for (const char* name : {"Linear Rec.709 (sRGB)", "lin_rec709", "LIN_REC709", "lin_rec709_scene", "lin_srgb",
                             "Utility - Linear - Rec.709"})
        EXPECT_EQ(colour.resolve(name), "Linear Rec.709 (sRGB)") << name;
    for (const char* name : {"sRGB", "srgb_tx", "sRGB - Texture", "srgb_rec709_scene"})
        EXPECT_EQ(colour.resolve(name), "sRGB - Texture") << name;
    EXPECT_TRUE(colour.hasSpace("acescg"));
    EXPECT_FALSE(colour.hasSpace("lin_p3d65"));
}

TEST(ColourConfig, UnknownSpaceListsTheChoices) {
    EXPECT_EQ(errorOf([] { ownConfig().resolve("Rec709"); }),
              "unknown colour space 'Rec709' in the OpenColorIO config 'scrim-aces'; expected 'ACES2065-1', "
              "'ACEScg', 'Linear Rec.709 (sRGB)', 'sRGB - Texture', 'Raw', 'CIE-XYZ-D65' or 'sRGB - Display'");
}

TEST(ColourConfig, WhiteIsWhiteInEverySpace) {
    const ColourConfig colour = ownConfig();
    for (const char* space : {"lin_rec709", "ACES2065-1", "sRGB"}) {
        const Rgb white = colour.toWorking({1, 1, 1}, space);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(white[c], 1.0, 1e-6) << space;  // single precision through 3 steps
    }
    Image image = onePixel(1, 1, 1, 1);
    colour.convert(image, "ACEScg", "lin_rec709");
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(image.rgba[c], 1.0, 1e-6);
}

TEST(ColourConfig, WorkingSpaceColoursPassUnchanged) {
    const Rgb colour(0.1, 1e9, -0.3);
    EXPECT_EQ(ownConfig().toWorking(colour, "scene_linear"), colour);
}

TEST(ColourConfig, Rec709RedHasThePublishedAcesCgValues) {
    // The first column of the matrix Rec.709 -> AP1 with Bradford adaptation, as printed in the ACES
    // project's documents to 6 digits.
    const Rgb red = ownConfig().toWorking({1, 0, 0}, "lin_rec709");
    EXPECT_NEAR(red.r, 0.613097, 2e-6);
    EXPECT_NEAR(red.g, 0.070194, 2e-6);
    EXPECT_NEAR(red.b, 0.020616, 2e-6);
}

TEST(ColourConfig, LinearSpacesAreMatrices) {
    const ColourConfig colour = ownConfig();
    EXPECT_EQ(colour.workingFrom("ACEScg"), Mat3(1.0));
    EXPECT_EQ(colour.workingFrom("Raw"), Mat3(1.0)) << "data are taken as they are";
    for (const char* space : {"lin_rec709", "ACES2065-1"}) {
        const Rgb probe(0.3, 2, 0.01), found = colour.workingFrom(space) * probe;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], colour.toWorking(probe, space)[c], 2e-6) << space;
    }
}

TEST(ColourConfig, EncodedSpacesAreNoMatrices) {
    EXPECT_EQ(errorOf([] { ownConfig().workingFrom("sRGB"); }),
              "the colour space 'sRGB - Texture' is not linear; expected one that a matrix takes to 'ACEScg'");
}

TEST(ColourConfig, SrgbTexturesDecodeByTheStandardsCurve) {
    const ColourConfig colour = ownConfig();
    for (const double encoded : {0.0, 0.02, 0.04045, 0.5, 0.9}) {
        // IEC 61966-2-1; its rounded constants and OpenColorIO's exact ones differ by less than 1e-6 here.
        const double linear = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
        EXPECT_NEAR(colour.toWorking(Rgb(encoded), "sRGB").g, linear, 2e-6) << encoded;
    }
}

TEST(ColourConfig, RoundTripsEveryLinearSpace) {
    const ColourConfig colour = ownConfig();
    for (const char* space : {"ACEScg", "ACES2065-1", "lin_rec709"}) {
        Image image{{-5, -5, 195, 95}, {}};  // more pixels than one task converts
        for (std::size_t i = 0; i < 4 * image.window.pixelCount(); ++i)
            image.rgba.push_back(static_cast<float>(i % 977) / 97.0f - 1.0f);
        const std::vector<float> before = image.rgba;
        colour.convert(image, "ACEScg", space);
        colour.convert(image, space, "ACEScg");
        for (std::size_t i = 0; i < before.size(); ++i) {
            if (i % 4 == 3)
                ASSERT_EQ(image.rgba[i], before[i]) << "alpha touched, " << space;
            else
                ASSERT_NEAR(image.rgba[i], before[i], 1e-5) << space << " value " << i;  // 10 x float epsilon x 10
        }
    }
}

TEST(ColourConfig, LinearConversionCommutesWithPremultiplication) {
    const ColourConfig colour = ownConfig();
    Image straight = onePixel(0.8f, 0.4f, 0.1f, 0.25f);
    Image premultiplied = onePixel(0.2f, 0.1f, 0.025f, 0.25f);
    colour.convert(straight, "ACEScg", "lin_rec709");
    colour.convert(premultiplied, "ACEScg", "lin_rec709");
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(0.25f * straight.rgba[c], premultiplied.rgba[c], 1e-7);
    EXPECT_EQ(premultiplied.rgba[3], 0.25f);
}

TEST(ColourConfig, MiddleGreyThroughTheSdrViewIsAsAcesHasIt) {
    // 0.356 in sRGB: measured with OpenColorIO's own tools on ACEScg 0.18; to 8 bits 91.
    const DisplayImage picture = ownConfig().displayImage(onePixel(0.18f, 0.18f, 0.18f, 0.5f), "", "");
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(picture.rgba[c], 0.356 * 255, 1);
    EXPECT_EQ(picture.rgba[3], 128) << "alpha is kept, rounded";
}

TEST(ColourConfig, ViewsClampAndDropNaN) {
    const ColourConfig colour = ownConfig();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    const DisplayImage raw =
        colour.displayImage({{0, 0, 2, 1}, {-1, 2, nan, 1, infinity, -infinity, 0.5f, 7}}, "sRGB", "Raw");
    EXPECT_EQ(raw.rgba, (std::vector<std::uint8_t>{0, 255, 0, 255, 255, 0, raw.rgba[6], 255}));
    EXPECT_NEAR(raw.rgba[6], 127.5, 0.5);
    const DisplayImage bright = colour.displayImage(onePixel(100, 100, 100, 1), "sRGB", "Un-tone-mapped");
    EXPECT_EQ(bright.rgba, (std::vector<std::uint8_t>{255, 255, 255, 255}));
}

TEST(ColourConfig, SlowGradientsKeepTheirMeanAndEndsStayExact) {
    // Four steps of 8 bits over 512 pixels, in a view that changes no numbers.
    constexpr int kWidth = 512, kHeight = 16, kCell = 16;
    Image image = emptyImage({-3, 5, kWidth - 3, 5 + kHeight});
    for (std::size_t i = 0; i < image.rgba.size() / 4; ++i)
        for (std::size_t c = 0; c < 4; ++c)
            image.rgba[4 * i + c] = (100.0f + 4.0f * static_cast<float>(i % kWidth) / kWidth) / 255;
    const DisplayImage shown = ownConfig().displayImage(image, "sRGB", "Raw");
    for (int x0 = 0; x0 < kWidth; x0 += kCell) {
        double mean = 0, wanted = 0;
        for (int y = 0; y < kHeight; ++y)
            for (int x = x0; x < x0 + kCell; ++x) {
                const auto at = static_cast<std::size_t>(4 * (y * kWidth + x));
                mean += shown.rgba[at];
                wanted += 255 * double(image.rgba[at]);
                EXPECT_LE(std::abs(shown.rgba[at] - 255 * image.rgba[at]), 1.01f) << x;
            }
        EXPECT_NEAR(mean / (kCell * kHeight), wanted / (kCell * kHeight), 0.1) << x0;
    }
    // What is a step already stays, black and white among them; a crop has the same pixels.
    for (const int step : {0, 1, 128, 254, 255}) {
        std::fill(image.rgba.begin(), image.rgba.end(), static_cast<float>(step) / 255);
        for (const std::uint8_t byte : ownConfig().displayImage(image, "sRGB", "Raw").rgba) ASSERT_EQ(byte, step);
    }
    std::fill(image.rgba.begin(), image.rgba.end(), 0.3019f);
    const DisplayImage whole = ownConfig().displayImage(image, "sRGB", "Raw");
    const DisplayImage crop = ownConfig().displayImage(reframed(image, {10, 7, 20, 9}), "sRGB", "Raw");
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 10; ++x)
            EXPECT_EQ(crop.rgba[static_cast<std::size_t>(4 * (10 * y + x))],
                      whole.rgba[static_cast<std::size_t>(4 * (kWidth * (y + 2) + x + 13))]);
}

/// What the view of `ownConfig` makes of a colour of the working space, display-encoded and not clamped.
Rgb seen(const Rgb& rgb, const std::string& view = "") {
    const auto f = [](double x) { return static_cast<float>(x); };
    const Image image = ownConfig().displayed(onePixel(f(rgb.r), f(rgb.g), f(rgb.b), 1), "", view);
    return {image.rgba[0], image.rgba[1], image.rgba[2]};
}

TEST(GamutCompression, ShowsEveryColourOfTheWorkingSpaceWithoutClippingItAtBlack) {
    // The greens of AP1 are farthest out; -0.47 in linear Rec.709 without compression.
    constexpr double kRounding = 1e-5;
    const double values[] = {0, 1e-4, 1e-3, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 100};
    for (const double r : values)
        for (const double g : values)
            for (const double b : values) {
                const Rgb shown = seen({r, g, b});
                ASSERT_GE(std::min({shown.r, shown.g, shown.b}), -kRounding) << r << ' ' << g << ' ' << b;
            }
}

TEST(GamutCompression, ShowsCoolFireRedOrangeAndInOrderOfItsLight) {
    const ColourConfig colour = ownConfig();
    const Rgb cool = Blackbody(colour).colour(1000);
    double last = 0;
    for (double light = 0.01; light < 20; light *= 1.25) {
        const Rgb shown = glm::min(seen(light * cool), Rgb(1));
        EXPECT_GT(shown.g, shown.b) << light;
        EXPECT_GT(shown.b, 0) << light;
        const double luma = glm::dot(shown, Rgb(0.2126, 0.7152, 0.0722));
        EXPECT_GT(luma, last) << light;
        last = luma;
    }
    // Clipped, it is 189, 0, 0.
    const Rgb shown = 255.0 * seen(0.18 * cool);
    EXPECT_NEAR(shown.r, 189, 1);
    EXPECT_NEAR(shown.g, 36, 1);
    EXPECT_NEAR(shown.b, 24, 1);
    // The curve's yellow of hot gas stays.
    const Rgb bright = 255.0 * glm::min(seen(8.0 * cool), Rgb(1));
    EXPECT_NEAR(bright.g, 239, 1);
    EXPECT_NEAR(bright.b, 143, 1);
}

TEST(GamutCompression, KeepsColoursThatTheDisplayHas) {
    // Numbers of ACES's own transform.
    const ColourConfig colour = ownConfig();
    const auto shown = [&](const Rgb& rec709) { return 255.0 * seen(colour.toWorking(rec709, "lin_rec709")); };
    const auto expectNear = [](const Rgb& is, const Rgb& wanted) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(is[c], wanted[c], 0.1);
    };
    expectNear(shown(Rgb(0.18)), Rgb(90.8));
    expectNear(shown({1, 0.6, 0.2}), {209.3, 179.4, 113.2});
    // The moderate red of the ColorChecker.
    expectNear(shown({0.5333, 0.1022, 0.1248}), {157.0, 63.7, 71.5});
    // Nor are other views changed.
    EXPECT_LT(seen({0, 1, 0}, "Un-tone-mapped").r, 0);
    EXPECT_EQ(seen({0, 1, 0}, "Raw"), Rgb(0, 1, 0));
}

TEST(ColourConfig, UnTonemappedViewIsTheSrgbCurve) {
    const DisplayImage picture = ownConfig().displayImage(onePixel(0.18f, 0.18f, 0.18f, 1), "sRGB", "Un-tone-mapped");
    EXPECT_NEAR(picture.rgba[1], 117.6, 1);  // 255 * (1.055 * 0.18^(1/2.4) - 0.055)
}

TEST(ColourConfig, ListsDisplaysAndViews) {
    const ColourConfig colour = ownConfig();
    EXPECT_EQ(colour.displays(), std::vector<std::string>{"sRGB"});
    EXPECT_EQ(colour.views("sRGB"), (std::vector<std::string>{"ACES 1.0 SDR", "Un-tone-mapped", "Raw"}));
    EXPECT_EQ(colour.defaultDisplay(), "sRGB");
    EXPECT_EQ(colour.defaultView("sRGB"), "ACES 1.0 SDR");
}

TEST(ColourConfig, UnknownDisplayAndViewListTheChoices) {
    const ColourConfig colour = ownConfig();
    const Image image = onePixel(0, 0, 0, 0);
    EXPECT_EQ(errorOf([&] { colour.displayImage(image, "P3", ""); }),
              "unknown display 'P3' in the OpenColorIO config 'scrim-aces'; expected 'sRGB'");
    EXPECT_EQ(errorOf([&] { colour.displayImage(image, "srgb", "Film"); }),
              "unknown view 'Film' of display 'sRGB' in the OpenColorIO config 'scrim-aces'; expected "
              "'ACES 1.0 SDR', 'Un-tone-mapped' or 'Raw'");
}

TEST(ColourConfig, KnowsInteropIds) {
    const ColourConfig colour = ownConfig();
    EXPECT_EQ(colour.interopId("ACEScg"), "lin_ap1_scene");
    EXPECT_EQ(colour.interopId("aces_interchange"), "lin_ap0_scene");
    EXPECT_EQ(colour.interopId("lin_rec709"), "lin_rec709_scene");
    EXPECT_EQ(colour.interopId("sRGB"), "srgb_rec709_scene");
    EXPECT_EQ(colour.interopId("Raw"), "data");
    EXPECT_EQ(colour.interopId("CIE-XYZ-D65"), "");
    EXPECT_TRUE(colour.isAces2065("lin_ap0"));
    EXPECT_FALSE(colour.isAces2065("ACEScg"));
}

TEST(ColourConfig, KnowsWhatIsLinear) {
    const ColourConfig colour = ownConfig();
    for (const char* space : {"ACEScg", "ACES2065-1", "lin_rec709"}) EXPECT_TRUE(colour.isLinear(space)) << space;
    EXPECT_TRUE(colour.isLinear("Raw")) << "data";
    EXPECT_FALSE(colour.isLinear("sRGB"));
}

TEST(ColourConfig, OptionComesBeforeTheEnvironmentBeforeTheOwnConfig) {
    const test::TempFolder folder;
    std::ofstream(folder.file("old.ocio")) << kOldConfig;
    std::ofstream(folder.file("own.ocio")) << acesConfigText();
    const OcioVariable set(folder.file("old.ocio").c_str());
    EXPECT_EQ(ColourConfig::open("").name(), folder.file("old.ocio"));
    EXPECT_EQ(ColourConfig::open(folder.file("own.ocio")).workingSpace(), "ACEScg");
    const OcioVariable empty("");
    EXPECT_EQ(ColourConfig::open("").name(), "scrim-aces");
}

TEST(ColourConfig, FindsKnownSpacesUnderOlderNames) {
    const test::TempFolder folder;
    std::ofstream(folder.file("old.ocio")) << kOldConfig;
    const ColourConfig colour = ColourConfig::open(folder.file("old.ocio"));
    EXPECT_EQ(colour.workingSpace(), "ACES - ACEScg");
    EXPECT_EQ(colour.resolve("ACEScg"), "ACES - ACEScg");
    EXPECT_EQ(colour.resolve("sRGB"), "Utility - sRGB - Texture");
    EXPECT_EQ(colour.interopId("scene_linear"), "lin_ap1_scene");
    EXPECT_EQ(colour.interopId("House Log"), "");
    EXPECT_NEAR(colour.toWorking(Rgb(1), "sRGB").r, 0.5, 1e-7);
}

TEST(ColourConfig, MissingConfigIsAnErrorThatSaysWhereItWasNamed) {
    const std::string given = errorOf([] { ColourConfig::open("/no/such.ocio"); });
    EXPECT_EQ(given.rfind("cannot read the OpenColorIO config '/no/such.ocio': ", 0), 0u) << given;
    const OcioVariable set("/no/other.ocio");
    const std::string inherited = errorOf([] { ColourConfig::open(""); });
    EXPECT_EQ(inherited.rfind("cannot read the OpenColorIO config '/no/other.ocio' (named by $OCIO): ", 0), 0u)
        << inherited;
}

TEST(ColourConfig, DamagedConfigIsAnErrorOfBoundedLength) {
    const test::TempFolder folder;
    std::ofstream(folder.file("bad.ocio")) << "ocio_profile_version: 2\ncolorspaces: [" << std::string(5000, '{');
    const std::string text = errorOf([&] { ColourConfig::open(folder.file("bad.ocio")); });
    EXPECT_EQ(text.rfind("cannot read the OpenColorIO config '" + folder.file("bad.ocio") + "': ", 0), 0u) << text;
    EXPECT_LT(text.size(), 500u);
}

TEST(ColourConfig, ConfigWithoutSceneLinearIsAnError) {
    const test::TempFolder folder;
    std::ofstream(folder.file("norole.ocio"))
        << "ocio_profile_version: 1\nroles: {default: a}\n"
           "displays: {d: [!<View> {name: v, colorspace: a}]}\ncolorspaces: [!<ColorSpace> {name: a}]\n";
    EXPECT_EQ(errorOf([&] { ColourConfig::open(folder.file("norole.ocio")); }),
              "the OpenColorIO config '" + folder.file("norole.ocio") +
                  "' has no role 'scene_linear', which names the working space");
}

TEST(ColourConfig, MissingLookUpFileIsAnError) {
    const test::TempFolder folder;
    std::ofstream(folder.file("old.ocio")) << kOldConfig;
    const ColourConfig colour = ColourConfig::open(folder.file("old.ocio"));
    Image image = onePixel(1, 1, 1, 1);
    const std::string text = errorOf([&] { colour.convert(image, "ACEScg", "House Log"); });
    EXPECT_EQ(text.rfind("cannot convert from 'ACES - ACEScg' to 'House Log': ", 0), 0u) << text;
    EXPECT_NE(text.find("missing.spi1d"), std::string::npos) << text;
}

/// A config of a few spaces, looks and views, and of the YAML that a test adds.
struct ConfigParts {
    std::string spaces = {}, looks = {}, named = {};
    std::string viewTransform = "!<MatrixTransform> {}";
    std::string shown = "lin";  ///< the space of the view

    std::string text() const {
        return "ocio_profile_version: 2\nenvironment: {SPACE: a}\n"
               "roles: {scene_linear: lin, default: lin, other: a}\n"
               "displays:\n  d:\n    - !<View> {name: v, colorspace: " +
               shown +
               ", looks: good}\n    - !<View> {name: through, view_transform: t, display_colorspace: disp}\n"
               "looks:\n  - !<Look> {name: good, process_space: lin, transform: !<MatrixTransform> {}}\n" +
               looks + "view_transforms:\n  - !<ViewTransform> {name: t, from_scene_reference: " + viewTransform +
               "}\n" + named +
               "display_colorspaces:\n  - !<ColorSpace> {name: disp}\n"
               "colorspaces:\n  - !<ColorSpace> {name: lin}\n" +
               spaces;
    }
};

std::string ocioSpace(const std::string& name, const std::string& from) {
    return "  - !<ColorSpace> {name: " + name + ", from_scene_reference: " + from + "}\n";
}

std::string ocioStep(const std::string& from, const std::string& to) {
    return "!<ColorSpaceTransform> {src: " + from + ", dst: " + to + "}";
}

/// What showing a pixel in a view of `parts` says, without the config's name.
std::string errorOfView(const ConfigParts& parts, const std::string& view) {
    const test::TempFolder folder;
    std::ofstream(folder.file("c.ocio")) << parts.text();
    const ColourConfig colour = ColourConfig::open(folder.file("c.ocio"));
    const std::string text = errorOf([&] { colour.displayImage(onePixel(1, 1, 1, 1), "d", view); });
    EXPECT_EQ(errorOf([&] { colour.requireView("d", view); }), text);
    const std::string start = "cannot make the view '" + view + "' of display 'd': in the OpenColorIO config '" +
                              folder.file("c.ocio") + "' ";
    return text.rfind(start, 0) == 0 ? text.substr(start.size()) : text;
}

TEST(ColourConfig, SpacesThatReferToThemselvesAreNamed) {
    const std::string itself = "the colour space 'a' refers to itself";
    const std::string group =
        "!<GroupTransform> {children: [!<GroupTransform> {children: [" + ocioStep("lin", "a") + "]}]}";
    const std::string looked = "!<LookTransform> {src: lin, dst: lin, looks: ";
    const std::string lookOfA = "  - !<Look> {name: l, process_space: a, transform: !<MatrixTransform> {}}\n";
    for (const std::string& from : {ocioStep("lin", "a"), ocioStep("a", "lin"), ocioStep("a", "a"),
                                    ocioStep("lin", "A"), ocioStep("lin", "other"), ocioStep("lin", "$SPACE"), group,
                                    std::string("!<LookTransform> {src: lin, dst: a, looks: good}"), looked + "l}",
                                    looked + "\"missing, +l\"}", looked + "\"good | -l\"}", looked + "\"good:l\"}",
                                    std::string("!<DisplayViewTransform> {src: lin, display: d, view: v}")})
        EXPECT_EQ(errorOfView({.spaces = ocioSpace("a", from), .looks = lookOfA, .shown = "a"}, "v"), itself) << from;
    EXPECT_EQ(errorOfView({.spaces = "  - !<ColorSpace> {name: a, from_scene_reference: !<MatrixTransform> {}, "
                                     "to_scene_reference: " +
                                     ocioStep("a", "lin") + "}\n",
                           .shown = "a"},
                          "v"),
              itself);
    EXPECT_EQ(errorOfView({.spaces = ocioSpace("a", ocioStep("lin", "b")) + ocioSpace("b", ocioStep("lin", "c")) +
                                     ocioSpace("c", ocioStep("lin", "a")),
                           .shown = "a"},
                          "v"),
              "the colour space 'a' refers to itself by way of the colour space 'b', the colour space 'c'");
}

TEST(ColourConfig, LooksAndTransformsThatReferToThemselvesAreNamed) {
    const std::string look = "!<LookTransform> {src: lin, dst: lin, looks: l}";
    EXPECT_EQ(errorOfView({.spaces = ocioSpace("a", look),
                           .looks = "  - !<Look> {name: l, process_space: lin, inverse_transform: " + look + "}\n",
                           .shown = "a"},
                          "v"),
              "the look 'l' refers to itself");
    EXPECT_EQ(
        errorOfView(
            {.spaces = ocioSpace("a", ocioStep("n", "lin")),
             .named = "named_transforms:\n  - !<NamedTransform> {name: n, transform: " + ocioStep("n", "lin") + "}\n",
             .shown = "a"},
            "v"),
        "the named transform 'n' refers to itself");
    const std::string shows = "!<DisplayViewTransform> {src: lin, display: d, view: through}";
    for (const std::string& transform : {ocioStep("lin", "disp"), shows})
        EXPECT_EQ(errorOfView({.viewTransform = transform}, "through"), "the view transform 't' refers to itself");
    // The one space is of the scene, the other of the display: OpenColorIO takes the view transform between them.
    EXPECT_EQ(errorOfView({.viewTransform = ocioStep("lin", "disp"), .shown = "disp"}, "v"),
              "the view transform 't' refers to itself");
}

TEST(ColourConfig, ChainsOfSpacesEndBeforeTheStackDoes) {
    const auto chain = [](int count) {
        std::string spaces;
        for (int i = 0; i < count; ++i)
            spaces += ocioSpace("c" + std::to_string(i), ocioStep("lin", "c" + std::to_string(i + 1)));
        return ConfigParts{.spaces = spaces + "  - !<ColorSpace> {name: c" + std::to_string(count) + "}\n",
                           .shown = "c0"};
    };
    EXPECT_EQ(errorOfView(chain(900), "v"), "no error");
    EXPECT_EQ(errorOfView(chain(1100), "v"), "the colour space 'c0' leads through more than 1000 spaces and looks");
}

TEST(ColourConfig, RingsBesideTheWayOfAConversionDoNotMatter) {
    EXPECT_EQ(errorOfView({.spaces = ocioSpace("a", ocioStep("lin", "a"))}, "v"), "no error");
    // Two ways to one space are no ring.
    EXPECT_EQ(errorOfView({.spaces = ocioSpace("a", "!<GroupTransform> {children: [" + ocioStep("lin", "b") + ", " +
                                                        ocioStep("b", "lin") + "]}") +
                                     ocioSpace("b", "!<MatrixTransform> {}"),
                           .shown = "a"},
                          "v"),
              "no error");
}

TEST(ColourConfig, ConversionsIntoARingAreRefused) {
    const test::TempFolder folder;
    std::ofstream(folder.file("c.ocio")) << ConfigParts{.spaces = ocioSpace("a", ocioStep("lin", "a"))}.text();
    const ColourConfig colour = ColourConfig::open(folder.file("c.ocio"));
    Image image = onePixel(1, 1, 1, 1);
    const std::string problem =
        "': in the OpenColorIO config '" + folder.file("c.ocio") + "' the colour space 'a' refers to itself";
    EXPECT_EQ(errorOf([&] { colour.convert(image, "lin", "a"); }), "cannot convert from 'lin' to 'a" + problem);
    EXPECT_EQ(errorOf([&] { colour.requireConversion("a"); }), "cannot convert from 'lin' to 'a" + problem);
    EXPECT_EQ(errorOf([&] { colour.toWorking(Rgb(1), "a"); }), "cannot convert from 'a' to 'lin" + problem);
}

}  // namespace
}  // namespace scrim
