// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/quality.h>

#include <scrim/base/error.h>

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace scrim {
namespace {

std::string errorOf(const std::string& name, const DialValue& value) {
    Dials dials;
    try {
        setDial(dials, name, value, "scene.toml:9:1");
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        return error.what();
    }
    return "no error";
}

TEST(Quality, TableNamesEveryDialOnceWithAllThereIsToSay) {
    std::set<std::string> names;
    for (const DialInfo& dial : dialTable()) {
        EXPECT_TRUE(names.insert(dial.name).second) << dial.name;
        EXPECT_FALSE(dial.allowed.empty()) << dial.name;
        EXPECT_FALSE(dial.meaning.empty()) << dial.name;
        EXPECT_FALSE(dial.defaultText.empty()) << dial.name;
    }
    for (const char* name : {"sheet_thickness", "texel", "splat", "shade", "kernel", "footprint_steps", "shadow_texel",
                             "shadow_filter", "sheets", "max_slant", "opacity_cutoff", "lod", "antialias", "simd"})
        EXPECT_EQ(names.count(name), 1u) << name;
}

TEST(Quality, DefaultsAreAllowed) {
    for (const DialInfo& dial : dialTable()) {
        Dials dials;
        setDialFromText(dials, dial.name, dial.defaultText, "here");
        EXPECT_EQ(dialText(dials, dial.name), dial.defaultText);
    }
}

TEST(Quality, SetsEveryDial) {
    Dials dials;
    setDial(dials, "sheet_thickness", 0.5, "here");
    setDial(dials, "texel", 0.75, "here");
    setDial(dials, "splat", "shared", "here");
    setDial(dials, "shade", "pixel", "here");
    setDial(dials, "kernel", "bspline", "here");
    setDial(dials, "footprint_steps", 32.0, "here");
    setDial(dials, "shadow_texel", 2.0, "here");
    setDial(dials, "shadow_filter", "nearest", "here");
    setDial(dials, "sheets", "image-aligned", "here");
    setDial(dials, "max_slant", 45.0, "here");
    setDial(dials, "opacity_cutoff", 0.0, "here");
    setDial(dials, "lod", 1.0, "here");
    setDialFromText(dials, "antialias", "4", "here");
    setDialFromText(dials, "simd", "avx2", "here");
    EXPECT_EQ(dials.sheetThickness, 0.5);
    EXPECT_EQ(dials.texel, 0.75);
    EXPECT_EQ(dials.shade, ShadeMode::pixel);
    EXPECT_EQ(dials.kernel, Kernel::bspline);
    EXPECT_EQ(dials.footprintSteps, 32);
    EXPECT_EQ(dials.shadowTexel, 2);
    EXPECT_EQ(dials.shadowFilter, ShadowFilter::nearest);
    EXPECT_EQ(dials.sheets, SheetAxis::imageAligned);
    EXPECT_EQ(dials.maxSlant, 45);
    EXPECT_EQ(dials.opacityCutoff, 0);
    EXPECT_EQ(dials.lod, 1);
    EXPECT_EQ(dials.antialias, 4);
    EXPECT_EQ(dials.simd, "avx2");
    EXPECT_EQ(dialText(dials, "shadow_filter"), "nearest");
    EXPECT_EQ(dialText(dials, "kernel"), "bspline");
}

TEST(Quality, SaysWhatIsAllowed) {
    EXPECT_EQ(errorOf("texel", 0.0), "scene.toml:9:1: 'texel' is 0; expected a number from 0.05 to 64 (voxels)");
    EXPECT_EQ(errorOf("texel", std::nan("")),
              "scene.toml:9:1: 'texel' is nan; expected a number from 0.05 to 64 (voxels)");
    EXPECT_EQ(errorOf("texel", "fine"),
              "scene.toml:9:1: 'texel' is 'fine'; expected a number from 0.05 to 64 (voxels)");
    EXPECT_EQ(errorOf("footprint_steps", 12.0),
              "scene.toml:9:1: 'footprint_steps' is 12; expected a power of two from 2 to 128 (steps a voxel)");
    EXPECT_EQ(errorOf("antialias", 1.5),
              "scene.toml:9:1: 'antialias' is 1.5; expected a whole number from 1 to 16 (rays a pixel's edge)");
    EXPECT_EQ(errorOf("kernel", "box"),
              "scene.toml:9:1: 'kernel' is 'box'; expected 'linear', 'gaussian' or 'bspline'");
    EXPECT_EQ(errorOf("kernel", 1.0), "scene.toml:9:1: 'kernel' is 1; expected 'linear', 'gaussian' or 'bspline'");
    EXPECT_EQ(errorOf("splat", "both"), "scene.toml:9:1: 'splat' is 'both'; expected 'shared' or 'per-view'");
    EXPECT_EQ(errorOf("texle", 1.0).substr(0, 68),
              "scene.toml:9:1: there is no dial 'texle'; did you mean 'texel'?; exp");
}

TEST(Quality, PresetsGoFromFastToAccurate) {
    EXPECT_EQ(presetNames(), (std::vector<std::string>{"draft", "standard", "high", "ultra"}));
    double thickness = 100;
    for (const std::string& name : presetNames()) {
        const auto dials = presetDials(name);
        ASSERT_TRUE(dials);
        EXPECT_LT(dials->sheetThickness, thickness);
        thickness = dials->sheetThickness;
        for (const DialInfo& dial : dialTable()) {
            Dials same;
            setDialFromText(same, dial.name, dialText(*dials, dial.name), name);  // in range
        }
    }
    EXPECT_EQ(presetDials("standard")->texel, Dials().texel);
    EXPECT_FALSE(presetDials("best"));
}

}  // namespace
}  // namespace scrim
