// SPDX-License-Identifier: Apache-2.0
// What the program makes of assets and scans without a scene.
#include "support/program_test.h"

#include "support/data.h"
#include "support/dicom_files.h"
#include "support/tiff_files.h"

#include <scrim/image/exr_read.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

namespace scrim::test {
namespace {

constexpr int kUsage = 2, kInput = 3;

class Asset : public ProgramTest {
  protected:
    std::string printed(const std::vector<std::string>& arguments) const {
        std::vector<std::string> all{"render", "--print-scene", "-q"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        return runWell(all).out;
    }
    /// 16 slices of DICOM (bodySlice) in a folder; their names are against their order.
    void makeBody(const std::string& folder) const {
        std::filesystem::create_directories(file(folder));
        for (int z = 0; z < 16; ++z) write(fmt::format("{}/{:02}.dcm", folder, 16 - z), bodySlice(z).bytes());
    }
    /// The number of pixels that the scan `ct` covers by more than half, through a window.
    std::ptrdiff_t coveredThrough(const std::string& window) const {
        runWell({"render", "ct", "--set", "volume.ct.classified.window=" + window, "-o", "x.exr", "--res", "64x64",
                 "--quality", "draft"});
        const std::vector<float> rgba = readExr(file("x.exr")).rgba;
        std::ptrdiff_t count = 0;
        for (std::size_t i = 3; i < rgba.size(); i += 4) count += rgba[i] > 0.5f;
        return count;
    }
    /// 16^3 samples: air 0, a ball of tissue 100 with a core of 200.
    void makeScan(const std::string& name, int offset = 0, const std::string& fields = "") const {
        std::string bytes;
        for (int z = 0; z < 16; ++z)
            for (int y = 0; y < 16; ++y)
                for (int x = 0; x < 16; ++x) {
                    const double r = std::hypot(x - 7.5, y - 7.5, z - 7.5);
                    const auto v = static_cast<std::int16_t>((r < 3 ? 200 : r < 6 ? 100 : (x + y + z) % 3) + offset);
                    bytes += static_cast<char>(v & 0xff);
                    bytes += static_cast<char>(v >> 8 & 0xff);
                }
        write(name, "NRRD0004\ntype: int16\ndimension: 3\nsizes: 16 16 16\nendian: little\nencoding: raw\n" + fields +
                        "\n" + bytes);
    }
};

TEST_F(Asset, TheVolumeIsNamedAfterItsFile) {
    makeVdb(file("a b$1.0007.vdb"), {{.voxels = box({0, 0, 0}, {3, 3, 3}, 1)}});
    EXPECT_TRUE(contains(printed({"smoke.vdb"}), "name = \"smoke\"\n"));
    EXPECT_TRUE(contains(printed({"a b$$1.####.vdb"}), "name = \"a_b_1\"\n")) << printed({"a b$$1.####.vdb"});
    const std::string changed = printed({"smoke.vdb", "--set", "volume.smoke.medium.albedo=[1, 0, 0]"});
    EXPECT_TRUE(contains(changed, "albedo = [1, 0, 0]")) << changed;
}

TEST_F(Asset, SaysWhatIsUpAndWhatIsNotUsed) {
    makeVdb(file("v.vdb"), {{.voxels = box({0, 0, 0}, {3, 3, 3}, 1)},
                            {.name = "fuel", .voxels = box({0, 0, 0}, {3, 3, 3}, 1)},
                            {.name = "v", .type = "vec3s", .voxels = {{{0, 0, 0}, 1}}}});
    EXPECT_EQ(
        runWell({"render", "v.vdb", "--print-scene"}).err,
        "scrim: v.vdb also holds fuel, v (not used)\nscrim: v.vdb: y is taken as the up axis; --up z changes this\n");
    const ProgramResult turned = runWell({"render", "v.vdb", "--print-scene", "--up", "z"});
    EXPECT_TRUE(contains(turned.out, "up = [0, 0, 1]\n")) << turned.out;
    EXPECT_FALSE(contains(turned.err, "up")) << turned.err;
    expectFailure({"render", "v.vdb", "--up", "w"}, kUsage, "--up 'w': expected 'x', 'y', 'z', '-x', '-y' or '-z'");
    expectFailure({"render", "scene.toml", "--up", "z"}, kUsage,
                  "scene.toml: --up is for assets; for a scene use --set camera.up=[0,0,1]");
}

TEST_F(Asset, WhatASimulationLeftBehindIsNotShownInSilence) {
    makeVdb(file("rest.vdb"), {{.voxels = box({0, 0, 0}, {3, 3, 3}, 1.5e-18)}});
    const ProgramResult rest = runWell({"render", "rest.vdb", "--print-scene"});
    EXPECT_TRUE(contains(rest.err,
                         "warning: rest.vdb: grid 'density' has no value above 1.5e-18, which may be only the residue "
                         "of a simulation; density.scale was chosen to make it visible\n"))
        << rest.err;
    makeVdb(file("much.vdb"), {{.voxels = box({0, 0, 0}, {3, 3, 3}, 2e21)}});
    EXPECT_TRUE(contains(runWell({"render", "much.vdb", "--print-scene"}).err,
                         "warning: much.vdb: grid 'density' has values up to 2e+21, which is more than densities "
                         "usually have"));
    auto around = box({-9, -9, -9}, {9, 9, 9}, 1e-12);
    for (const auto& voxel : box({0, 0, 0}, {3, 3, 3}, 1)) around.push_back(voxel);
    makeVdb(file("around.vdb"), {{.voxels = around}});
    const ProgramResult beside = runWell({"render", "around.vdb", "--print-scene"});
    EXPECT_TRUE(contains(beside.err,
                         "around.vdb: grid 'density' has 99 % of its voxels below 0.0001, which show "
                         "nothing beside the others; the camera and density.scale were chosen without "
                         "them\n"))
        << beside.err;
    makeVdb(file("only.vdb"), {{.voxels = box({0, 0, 0}, {3, 3, 3}, 1)}});
    const std::string onlyScene = printed({"only.vdb"});
    const auto after = [](const std::string& text) { return text.substr(text.find("[camera]"), 120); };
    EXPECT_EQ(after(beside.out), after(onlyScene)) << "the same camera";
    const auto place = [](const std::string& text) {
        const std::size_t at = text.find("position = ");
        return text.substr(at, text.find(']', at) - at);
    };
    const std::string wide = printed({"only.vdb", "--res", "96x24"});
    EXPECT_NE(place(wide), place(onlyScene)) << "further away, to fit";
    EXPECT_EQ(place(printed({"only.vdb", "--set", "camera.resolution=[96, 24]"})), place(wide));
    makeVdb(file("thin.vdb"), {{.voxels = box({0, 0, 0}, {3, 3, 3}, 1e-5)}});
    EXPECT_FALSE(contains(runWell({"render", "thin.vdb", "--print-scene"}).err, "simulation"));
}

TEST_F(Asset, FireGlowsAndOutshinesTheLights) {
    const auto ball = box({-6, -6, -6}, {6, 6, 6}, 0.2), core = box({-3, -3, -3}, {3, 3, 3}, 4.0);
    makeVdb(file("fire.vdb"), {{.voxels = ball}, {.name = "Temperature", .voxels = core}});
    const std::string scene = printed({"fire.vdb"});
    EXPECT_TRUE(contains(scene, "blackbody = { grid = \"Temperature\", kelvin = [0, 475], intensity = ")) << scene;
    runWell({"render", "fire.vdb", "-o", "fire.exr", "--res", "48x48", "--quality", "draft"});
    const Image image = readExr(file("fire.exr"));
    double red = 0, blue = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        red = std::max<double>(red, image.rgba[i]);
        blue = std::max<double>(blue, image.rgba[i + 2]);
    }
    EXPECT_GT(red, 1);
    EXPECT_LT(blue, 0.5 * red);
    // Kelvin are left as they are, and flames are as good as temperatures.
    makeVdb(file("k.vdb"), {{.voxels = ball}, {.name = "flame", .voxels = box({-3, -3, -3}, {3, 3, 3}, 1500)}});
    EXPECT_TRUE(contains(printed({"k.vdb"}), "blackbody = { grid = \"flame\", scale = 1, intensity = "));
    // Where the flames have gone out, warm smoke is smoke.
    makeVdb(file("out.vdb"), {{.voxels = ball}, {.name = "temperature", .voxels = core}, {.name = "flame"}});
    const ProgramResult out = runWell({"render", "out.vdb", "--print-scene"});
    EXPECT_FALSE(contains(out.out, "blackbody")) << out.out;
    EXPECT_TRUE(contains(out.err, "out.vdb: nothing burns, since its grid 'flame' is empty")) << out.err;
    // Fire alone is a volume, too.
    makeVdb(file("f.vdb"), {{.name = "flame", .voxels = core}});
    runWell({"render", "f.vdb", "-o", "f.exr", "--res", "24x24", "--quality", "draft"});
}

TEST_F(Asset, SmokeRisesFromItsFire) {
    makeVdb(file("z.vdb"),
            {{.voxels = box({0, 0, 0}, {6, 6, 30}, 0.2)}, {.name = "heat", .voxels = box({0, 0, 0}, {6, 6, 9}, 1)}});
    const ProgramResult result = runWell({"render", "z.vdb", "--print-scene"});
    EXPECT_EQ(result.err,
              "scrim: z.vdb: z is taken as the up axis, where its smoke goes from its fire; --up y changes this\n");
    EXPECT_TRUE(contains(result.out, "up = [0, 0, 1]\n"));
}

TEST_F(Asset, InterpolationIsReadAndChecked) {
    write("i.toml",
          "[camera]\nposition = [0, 0, 40]\ntarget = [0, 0, 0]\nfov = 35\nresolution = [32, 32]\n"
          "[[volume]]\nname = \"v\"\nfile = \"smoke.vdb\"\ninterpolation = \"linear\"\n"
          "[ambient]\ncolor = [1, 1, 1]\n");
    const auto picture = [&](const std::string& word) {
        runWell({"render", "i.toml", "-o", word + ".exr", "--set", "volume.v.interpolation=\"" + word + "\""});
        return readExr(file(word + ".exr")).rgba;
    };
    EXPECT_EQ(picture("auto"), picture("linear"));
    EXPECT_NE(picture("smooth"), picture("linear"));
    expectFailure(
        {"render", "i.toml", "--set", "volume.v.interpolation=\"cubic\""}, kInput,
        "--set volume.v.interpolation: 'interpolation' is the string \"cubic\"; expected 'auto', 'linear' or 'smooth'");
}

TEST_F(Asset, FluidCachesOfBlenderStandUpright) {
    const auto cube = box({0, 0, 0}, {3, 3, 3}, 1);
    makeVdb(file("fluid.vdb"), {{.voxels = cube},
                                {.name = "shadow", .voxels = cube},
                                {.name = "velocity", .type = "vec3s", .voxels = {{{0, 0, 0}, 1}}}});
    const ProgramResult result = runWell({"render", "fluid.vdb", "--print-scene"});
    EXPECT_TRUE(contains(result.err, "z is taken as the up axis, as in Blender, which wrote it")) << result.err;
    EXPECT_TRUE(contains(result.out, "up = [0, 0, 1]\n"));
}

TEST_F(Asset, FireThatComesAndGoesIsNotUsed) {
    const auto ball = box({-6, -6, -6}, {6, 6, 6}, 0.2);
    makeVdb(file("s.1.vdb"), {{.voxels = ball}});
    makeVdb(file("s.2.vdb"), {{.voxels = ball}, {.name = "heat", .voxels = ball}});
    const ProgramResult result = runWell({"render", "s.#.vdb", "--frames", "1-2", "--print-scene"});
    EXPECT_FALSE(contains(result.out, "blackbody")) << result.out;
}

TEST_F(Asset, AColourGridIsTheAlbedo) {
    makeVdb(file("c.vdb"), {{.voxels = box({0, 0, 0}, {3, 3, 3}, 1)},
                            {.name = "Cd", .type = "vec3s", .colours = {{{0, 0, 0}, {1, 0, 0}}}}});
    EXPECT_TRUE(contains(printed({"c.vdb"}), "albedo = { grid = \"Cd\" }\n"));
}

TEST_F(Asset, ATurntableGoesOnceAround) {
    runWell({"render", "smoke.vdb", "--turntable", "4", "--res", "24x24", "--quality", "draft"});
    for (const char* name : {"smoke.0001.exr", "smoke.0002.exr", "smoke.0003.exr", "smoke.0004.exr"})
        EXPECT_TRUE(exists(name)) << name;
    EXPECT_NE(readExr(file("smoke.0001.exr")).rgba, readExr(file("smoke.0003.exr")).rgba);
    runWell({"render", "scene.toml", "--turntable", "3", "--frames", "2", "-o", "t.exr"});
    EXPECT_TRUE(exists("t.exr"));
    expectFailure({"render", "scene.toml", "--turntable", "3", "-o", "x.exr"}, kUsage,
                  "all 3 frames would be written to 'x.exr'; put the frame into its name: x.####.exr");
    expectFailure({"render", "scene.toml", "--turntable", "1"}, kUsage,
                  "--turntable 1: expected a whole number of frames from 2 to 10000");
}

TEST_F(Asset, PreviewsTakeAViewAndAnExposure) {
    runWell({"render", "scene.toml", "--preview", "a.ppm"});
    runWell({"render", "scene.toml", "--preview", "b.ppm", "--exposure", "-20"});
    runWell({"render", "scene.toml", "--preview", "c.ppm", "--view", "raw", "-o", "c.exr"});
    const auto brightest = [&](const std::string& name) {
        const std::string bytes = readBytes(file(name)).substr(20);
        return static_cast<unsigned char>(
            *std::max_element(bytes.begin(), bytes.end(), [](unsigned char x, unsigned char y) { return x < y; }));
    };
    EXPECT_GT(brightest("a.ppm"), 20);
    EXPECT_LE(brightest("b.ppm"), 1);
    EXPECT_NE(readBytes(file("a.ppm")), readBytes(file("c.ppm")));
    EXPECT_EQ(readExr(file("scene.exr")).rgba, readExr(file("c.exr")).rgba) << "the picture does not change";
    expectFailure({"render", "scene.toml", "--view", "Film", "--preview", "d.png"}, kUsage,
                  "--view 'Film': expected 'ACES 1.0 SDR', 'Un-tone-mapped' or 'Raw'");
    expectFailure({"render", "scene.toml", "--exposure", "1"}, kUsage,
                  "--exposure: there is no preview to apply it to; --preview FILE.png writes one");
    expectFailure({"render", "scene.toml", "--exposure", "bright", "--preview", "d.png"}, kUsage,
                  "--exposure bright: expected stops from -30 to 30");
    expectFailure({"render", "scene.toml", "--annotate"}, kUsage,
                  "--annotate: there is no preview to apply it to; --preview FILE.png writes one");
    // The same marks on a preview that is made of the picture afterwards.
    const std::vector<std::string> annotated{"render", "scene.toml", "--annotate", "--preview", "e.ppm"};
    runWell(annotated);
    const std::string marked = readBytes(file("e.ppm"));
    EXPECT_NE(marked, readBytes(file("a.ppm")));
    std::filesystem::remove(file("e.ppm"));
    std::vector<std::string> again = annotated;
    again.push_back("--skip-existing");
    runWell(again);
    EXPECT_EQ(readBytes(file("e.ppm")).size(), marked.size());
    std::size_t differ = 0;
    const std::string later = readBytes(file("e.ppm"));
    for (std::size_t i = 0; i < marked.size(); ++i)
        differ += std::abs(int(static_cast<unsigned char>(later[i])) - int(static_cast<unsigned char>(marked[i]))) > 3;
    EXPECT_EQ(differ, 0u) << "but for the picture's rounding to half";
}

// A plate of one colour shows beside the smoke and not in the picture, and in a preview that is made afterwards.
TEST_F(Asset, PreviewsLieOverABackplate) {
    write("plate.ppm", "P6\n2 1\n255\n" + std::string("\x10\xf0\x10\x10\xf0\x10"));
    const std::vector<std::string> command{"render", "scene.toml", "--set",
                                           "output.preview={file=\"p.ppm\", backplate=\"plate.ppm\", view=\"Raw\"}"};
    runWell(command);
    runWell({"render", "scene.toml", "-o", "without.exr"});
    EXPECT_EQ(readExr(file("scene.exr")).rgba, readExr(file("without.exr")).rgba);
    const std::string over = readBytes(file("p.ppm")), corner = over.substr(over.size() - 3);
    EXPECT_GT(static_cast<unsigned char>(corner[1]), 2 * static_cast<unsigned char>(corner[0]));
    std::filesystem::remove(file("p.ppm"));
    std::vector<std::string> again = command;
    again.push_back("--skip-existing");
    runWell(again);
    EXPECT_EQ(readBytes(file("p.ppm")).substr(over.size() - 3), corner);
    expectFailure({"render", "scene.toml", "--set", "output.preview={file=\"p.ppm\", backplate=\"none.png\"}"}, kInput,
                  "--set output.preview: the backplate of the preview: there is no file 'none.png'");
}

TEST_F(Asset, AScanIsFramedAndLit) {
    makeScan("head.nrrd", 0, "spacings: 1 1 2\n");
    const std::string scene = printed({"head.nrrd"});
    for (const char* part : {"name = \"head\"\n", "source = \"scan\"\n", "file = \"head.nrrd\"\n", "units = \"scan\"\n",
                             "up = [0, 0, 1]\n", "value = "})
        EXPECT_TRUE(contains(scene, part)) << part << "\n" << scene;
    runWell({"render", "head.nrrd", "-o", "head.exr", "--res", "32x32", "--quality", "draft"});
    const Image image = readExr(file("head.exr"));
    double most = 0;
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) most = std::max<double>(most, image.rgba[i]);
    EXPECT_GT(most, 0.95) << "the core is a surface";
    // Where materials begin below 0 a window makes them visible.
    makeScan("low.nrrd", -300, "spacings: 1 1 2\n");
    EXPECT_TRUE(contains(printed({"low.nrrd"}), "window = \"")) << printed({"low.nrrd"});
    runWell({"render", "low.nrrd", "-o", "low.exr", "--res", "32x32", "--quality", "draft"});
    const Image low = readExr(file("low.exr"));
    most = 0;
    for (std::size_t i = 3; i < low.rgba.size(); i += 4) most = std::max<double>(most, low.rgba[i]);
    EXPECT_GT(most, 0.95);
    // Framed by values that begin at another place, and so not quite alike.
    EXPECT_NEAR(low.window.width(), image.window.width(), 3);
    EXPECT_NEAR(low.window.height(), image.window.height(), 3);
}

TEST_F(Asset, AScanOfOneValueIsNoError) {
    for (const char* value : {"0", "7"}) {
        std::string samples;
        for (int i = 0; i < 64; ++i) samples += std::string(value) + " ";
        write("flat.nrrd", "NRRD0004\ntype: float\ndimension: 3\nsizes: 4 4 4\nencoding: ascii\n\n" + samples);
        runWell({"render", "flat.nrrd", "-o", "flat.exr", "--res", "16x16", "--quality", "draft"});
        runWell({"info", "flat.nrrd"});
    }
}

TEST_F(Asset, HounsfieldUnitsAreKnown) {
    makeScan("ct.nrrd", -1000);
    std::string bytes = readBytes(file("ct.nrrd"));
    bytes[bytes.size() - 2] = static_cast<char>(0xd0);  // 2000
    bytes[bytes.size() - 1] = 7;
    write("ct.nrrd", bytes);
    const std::string scene = printed({"ct.nrrd"});
    EXPECT_TRUE(contains(scene, "# In Hounsfield units")) << scene;
    EXPECT_TRUE(contains(runWell({"info", "ct.nrrd"}).out, "-1000 to 2000, probably Hounsfield units"));
}

TEST_F(Asset, InfoShowsAScan) {
    makeScan("head.nrrd", 0, "spacings: 1 1 2\n");
    const std::string text = runWell({"info", "head.nrrd"}).out;
    for (const char* part : {"16 x 16 x 16 of int16", "[1, 1, 2]", "0 to 200", "█", "veil from", "surface from",
                             "scrim render head.nrrd -o picture.exr"})
        EXPECT_TRUE(contains(text, part)) << part << "\n" << text;
    const auto json = nlohmann::json::parse(runWell({"info", "head.nrrd", "--json"}).out);
    EXPECT_EQ(json.at("size"), (std::vector{16, 16, 16}));
    // Core, shell, and three values of air; each a bin of its own.
    const auto counts = json.at("histogram").at("counts").get<std::vector<double>>();
    ASSERT_EQ(counts.size(), 201u);
    double all = 0;
    for (const double count : counts) all += count;
    EXPECT_EQ(all, 16 * 16 * 16);
    EXPECT_GT(counts[100], counts[200]);
    EXPECT_GT(counts[200], 0);
    // Between air, shell and core.
    EXPECT_NEAR(json.at("soft").get<double>(), 51, 2);
    EXPECT_NEAR(json.at("solid").get<double>(), 150, 2);
}

TEST_F(Asset, TiffStacksAndSlicesAreShownAndRendered) {
    std::filesystem::create_directories(file("slices"));
    for (std::size_t z = 0; z < 16; ++z) write(fmt::format("slices/ball_{}.tif", z), ballSlice(z).bytes());
    write("cells.tif", ballPages().bytes());
    const std::string text = runWell({"info", "cells.tif"}).out;
    for (const char* part : {"16 x 16 x 16 of uint8\n", "[1, 1, 2] micron", "0 to 200", "veil from"})
        EXPECT_TRUE(contains(text, part)) << part << "\n" << text;
    EXPECT_EQ(nlohmann::json::parse(runWell({"info", "cells.tif", "--json"}).out).at("unit"), "micron");
    for (const char* name : {"slices", "slices/ball_*.tif"}) {
        const std::string slices = runWell({"info", name}).out;
        for (const std::string& part :
             {std::string("16 x 16 x 16 of uint8\n"), std::string("[1, 1, 1], since the file does not say\n"),
              fmt::format(" {}\n", 16 * ballSlice(0).bytes().size())})
            EXPECT_TRUE(contains(slices, part)) << part << "\n" << slices;
        runWell({"render", name, "-o", "ball.exr", "--res", "16x16", "--quality", "draft"});
    }
    EXPECT_TRUE(contains(printed({"slices/ball_*.tif"}), "name = \"ball\"\n"));
}

TEST_F(Asset, ColoursOfAScanAreTheAlbedoOfItsMedium) {
    TiffPages pages;  // the left half is red, the right half green
    pages.columns = pages.rows = 16;
    pages.parts = 3;
    pages.colours = 2;
    for (int z = 0; z < 16; ++z) {
        pages.pages.emplace_back();
        for (int i = 0; i < 256; ++i) pages.pages.back() += i % 16 < 8 ? "\xff\x01\x01" : "\x01\xff\x01";
    }
    write("cells.tif", pages.bytes());
    const std::string text = runWell({"info", "cells.tif"}).out;
    for (const char* part :
         {"16 x 16 x 16 of RGB of uint8\n", "albedo = { grid = \"color\", colorspace = \"lin_rec709\" } takes them"})
        EXPECT_TRUE(contains(text, part)) << part << "\n" << text;
    write("scene.toml",
          kCamera +
              "[[volume]]\nname = \"cells\"\nsource = \"scan\"\nparameters = { file = \"cells.tif\", center = "
              "true, window = \"0, 255\" }\nmedium = { albedo = { grid = \"color\" } }\n" +
              kLight);
    runWell({"render", "scene.toml", "-o", "cells.exr", "--quality", "draft"});
    const auto picture = readExr(file("cells.exr"));
    const auto at = [&](int x, std::size_t channel) { return picture.rgba[picture.indexOf(x, 12) + channel]; };
    EXPECT_GT(at(13, 0), 20 * at(13, 1)) << "red on the left";
    EXPECT_GT(at(19, 1), 20 * at(19, 0)) << "green on the right";
    EXPECT_GT(at(19, 1), 0.01f);
}

TEST_F(Asset, FormatsThatAreNotReadAreNamed) {
    write("x.vtk", "# vtk DataFile Version 3.0\n");
    const std::string reason =
        "x.vtk: is a legacy VTK file (.vtk), which is not read; convert it to NRRD or NIfTI (3D Slicer, ITK and "
        "ParaView do)";
    expectFailure({"render", "x.vtk"}, kInput, reason);
    expectFailure({"info", "x.vtk"}, kInput, reason);
    expectFailure({"make", "scan", "file=x.vtk", "-o", "x.vdb"}, kInput, "source 'scan': " + reason);
    expectFailure({"info", "nowhere.DCM"}, kInput, "source 'scan': nowhere.DCM: there is no such file");
}

TEST_F(Asset, AFolderOfDicomIsAScan) {
    makeBody("ct");
    for (const char* name : {"ct", "ct/", "ct/03.dcm"}) {
        const ProgramResult info = runWell({"info", name});
        EXPECT_TRUE(contains(info.out, "samples          16 x 16 x 16 of int16\n")) << info.out;
        EXPECT_TRUE(contains(info.out, "values           -1000 to 900")) << info.out;
        runWell({"render", name, "-o", "x.exr", "--res", "16x16", "--quality", "draft"});
    }
    const std::string made = runWell({"render", "ct", "--print-scene"}).out;
    EXPECT_TRUE(contains(made, "name = \"ct\"")) << made;
    std::filesystem::remove(file("ct/09.dcm"));
    expectFailure({"info", "ct"}, kInput,
                  "source 'scan': ct: a slice is missing between '10.dcm' and '08.dcm': they are 2 mm apart, others 1");
}

TEST_F(Asset, WindowsOfScansAreGivenByName) {
    makeBody("ct");
    const auto bone = coveredThrough("bone"), flesh = coveredThrough("soft tissue");
    EXPECT_GT(bone, 50);
    // A radius of 3 in one of 6, each within half a voxel: (2.5 / 6.5)^2 to (3.5 / 5.5)^2.
    EXPECT_GT(double(bone), 0.14 * double(flesh));
    EXPECT_LT(double(bone), 0.41 * double(flesh));
    EXPECT_NEAR(double(coveredThrough("vessels")), double(bone), 0.4 * double(bone));
    // Air is kept, too, so that the camera stands further away.
    const auto range = coveredThrough("[600, 400]");
    EXPECT_GT(range, 50);
    EXPECT_LT(range, bone);
    EXPECT_EQ(coveredThrough("[2000, 100]"), 0);
    // Skin, whose voxels hold air in part, is a veil of values of lungs.
    EXPECT_LT(coveredThrough("lung"), flesh);
    const std::string made =
        runWell({"render", "ct", "--set", "volume.ct.classified.window=bone", "--print-scene"}).out;
    EXPECT_TRUE(contains(made, "window = \"bone\"") || contains(made, "window = 'bone'")) << made;
    EXPECT_FALSE(contains(made, "transfer =")) << made;
    EXPECT_TRUE(contains(made, "hounsfield")) << made;
    expectFailure(
        {"render", "ct", "--set", "volume.ct.classified.window=bones", "-o", "x.exr"}, kInput,
        "--set volume.ct.classified.window: 'window' is the string \"bones\"; expected 'bone', 'soft tissue', "
        "'lung' or 'vessels'");
}

TEST_F(Asset, AScanWithoutHounsfieldUnitsHasWindowsInItsOwn) {
    makeScan("ball.nrrd");
    expectFailure({"render", "ball.nrrd", "--set", "volume.ball.classified.window=bone", "-o", "x.exr"}, kInput,
                  "ball.nrrd: has values from 0 to 200, which are not Hounsfield units, as the window bone needs them; "
                  "expected [centre, width] in the scan's own units, or a scene with 'rescale' among its parameters");
    runWell({"render", "ball.nrrd", "--set", "volume.ball.classified.window=[100, 60]", "-o", "x.exr", "--res", "16x16",
             "--quality", "draft"});
}

TEST_F(Asset, InfoSumsUpASequence) {
    makeVdb(file("s.01.vdb"), {{.voxels = box({0, 0, 0}, {1, 1, 1}, 0.5), .voxelSize = 2, .translate = {10, 0, 0}}});
    makeVdb(file("s.02.vdb"), {{.voxels = box({0, 0, 0}, {3, 1, 1}, 1.5), .voxelSize = 2, .translate = {10, 0, 0}},
                               {.name = "heat", .voxels = {{{0, 0, 0}, 9}}}});
    const std::string both = runWell({"info", "s.##.vdb"}).out;
    for (const char* part :
         {"s.##.vdb\n  files            2, frames 1 to 2\n", "active voxels  8 to 16\n",
          "values         0.5 (frame 1) to 1.5 (frame 2)\n", "world bounds   [9, -1, -1] to [17, 3, 3] (8 x 4 x 4)\n",
          "grid 'heat'\n    type           float\n    in             1 of 2 files\n"})
        EXPECT_TRUE(contains(both, part)) << part << "\n" << both;
    const std::string one = runWell({"info", "s.##.vdb", "--frames", "2"}).out;
    for (const char* part : {"world bounds   [9, -1, -1] to [17, 3, 3] (8 x 4 x 4)\n", "translation    [10, 0, 0]\n"})
        EXPECT_TRUE(contains(one, part)) << part << "\n" << one;
    EXPECT_EQ(nlohmann::json::parse(runWell({"info", "s.##.vdb", "--json"}).out).size(), 2u);
    expectFailure({"info", "none.##.vdb"}, kInput, "none.##.vdb: the sequence has no files");
}

TEST_F(Asset, PointsWithAForeignCodecAreNotDamage) {
    makeVdb(file("p.vdb"), {{.voxels = box({0, 0, 0}, {3, 3, 3}, 1)},
                            {.name = "points", .type = "points", .voxels = {{{0, 0, 0}, 1}}}});
    std::string bytes = readBytes(file("p.vdb"));
    const std::string codec("\4\0\0\0null", 8);
    std::size_t found = 0;
    for (std::size_t at = bytes.find(codec); at != std::string::npos; at = bytes.find(codec, at + 1), ++found)
        bytes.replace(at, codec.size(), std::string("\4\0\0\0mine", 8));
    ASSERT_GT(found, 0u);
    write("p.vdb", bytes);
    const std::string text = runWell({"info", "p.vdb"}).out;
    EXPECT_TRUE(contains(text, "grid 'density'\n    type           float\n")) << text;
    EXPECT_TRUE(contains(text, "not read       its points have an attribute of the type and codec 'vec3s_mine'"))
        << text;
    EXPECT_FALSE(contains(text, "damaged")) << text;
    runWell({"render", "p.vdb", "-o", "p.exr", "--res", "16x16", "--quality", "draft"});
}

// OpenVDB prints a warning about such files, which the confined process must not.
TEST_F(Asset, FilesOfNewerVersionsAreReadWithAWord) {
    std::string bytes = readBytes(file("smoke.vdb"));
    bytes[8] = static_cast<char>(225);
    write("new.vdb", bytes);
    EXPECT_TRUE(contains(runWell({"info", "new.vdb"}).out, "225"));
    const ProgramResult result = runWell({"render", "new.vdb", "-o", "new.exr", "--res", "16x16"});
    EXPECT_TRUE(contains(result.err, "new.vdb: file version 225 is newer than OpenVDB ")) << result.err;
    // Its half grids: a type with a shorter name.
    const std::string name = "density", type = "Tree_float_5_4_3", half = "Tree_half_5_4_3";
    const auto text = [](const std::string& t) { return std::string{static_cast<char>(t.size()), 0, 0, 0} + t; };
    const std::size_t at = bytes.find(text(name) + text(type));
    ASSERT_NE(at, std::string::npos);
    bytes.replace(at, 8 + name.size() + type.size(), text("density2") + text(half));
    write("half.vdb", bytes);
    EXPECT_TRUE(contains(runWell({"info", "half.vdb"}).out, "Tree_half_5_4_3")) << runWell({"info", "half.vdb"}).out;
    expectFailure({"render", "half.vdb", "-o", "half.exr"}, 3,
                  "half.vdb: holds no scalar grid, only 'density2' (half); half grids of OpenVDB 13 are "
                  "not read, save it as a float grid (in half precision, if you like)");
}

TEST_F(Asset, RealScansAreShown) {
    SCRIM_NEEDS_DATA("scan/bonsai_256.nrrd");
    const std::string scan = dataFile("scan/bonsai_256.nrrd");
    EXPECT_TRUE(contains(runWell({"info", scan}).out, "256 x 256 x 256 of uint8"));
    runWell({"render", scan, "-o", "b.exr", "--res", "32x32", "--up", "y", "--set", "render.texel=1", "--set",
             "render.sheet_thickness=1"});
}

TEST_F(Asset, ATreeStandsOnItsPotAndAToothOnItsRoots) {
    SCRIM_NEEDS_DATA("scan/bonsai_256.nrrd");
    const ProgramResult tree = runWell({"render", dataFile("scan/bonsai_256.nrrd"), "--print-scene"});
    EXPECT_TRUE(contains(tree.out, "up = [0, 1, 0]\n")) << tree.out;
    EXPECT_TRUE(contains(tree.err, "y is taken as the up axis, away from its heavy end; --up z changes this"));
    for (const char* name : {"scan/tooth.nhdr", "scan/stent.nrrd", "scan/ch2bet.nii.gz"})
        EXPECT_TRUE(contains(runWell({"render", dataFile(name), "--print-scene"}).out, "up = [0, 0, 1]\n")) << name;
}

}  // namespace
}  // namespace scrim::test
