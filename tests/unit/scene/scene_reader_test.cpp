// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_reader.h>

#include "support/temp_folder.h"
#include "unit/scene/read_scene.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <string>

namespace scrim {
namespace {

using namespace std::string_literals;

using test::errorOf;
using test::kCamera;
using test::kVolume;
using test::read;

const std::string kScene = kCamera + kVolume +
                           "[[light]]\nname = \"key\"\ntype = \"point\"\nposition = [0, 0, 5]\n"
                           "[[light]]\ntype = \"point\"\nposition = [0, 5, 5]\n";

std::string overrideError(const std::string& assignment) {
    return errorOf(kScene, {assignment});
}

TEST(SceneReader, KnowsWhetherAnythingMoves) {
    EXPECT_FALSE(read(kScene).moves);
    EXPECT_FALSE(read(kScene + "name = \"keys\"\n").moves);
    EXPECT_TRUE(read(kScene + "intensity = { keys = [[1, 2], [5, 3]] }\n").moves);
    EXPECT_TRUE(read(kScene, {"light.key.position={ keys = [[1, [0, 0, 5]], [5, [0, 5, 0]]] }"}).moves);
}

TEST(SceneOutput, HasDefaults) {
    const SceneOutput out = read(kScene).output;
    EXPECT_EQ(out.file, "");
    EXPECT_EQ(out.colorspace, "ACEScg");
    EXPECT_TRUE(out.half);
    EXPECT_EQ(out.compression, "zip");
    EXPECT_EQ(out.fps, 24);
    EXPECT_EQ(out.preview.file, "");
}

TEST(SceneOutput, ReadsEveryKey) {
    const SceneOutput out = read(kScene +
                                     "[output]\nfile = \"out/a.####.exr\"\ncolorspace = \"lin_rec709\"\ntype = "
                                     "\"float\"\ncompression = "
                                     "\"piz\"\nfps = 23.976\npreview = { file = \"a.##.png\", display = \"SRGB\" }\n",
                                 {}, 7)
                                .output;
    EXPECT_EQ(out.file, "/shots/out/a.0007.exr");
    EXPECT_TRUE(out.path.hasFrame());
    EXPECT_EQ(out.colorspace, test::ownColours().resolve("lin_rec709"));
    EXPECT_FALSE(out.half);
    EXPECT_EQ(out.compression, "piz");
    EXPECT_EQ(out.fps, 23.976);
    EXPECT_EQ(out.preview.file, "/shots/a.07.png");
    EXPECT_EQ(out.preview.display, "sRGB");
    EXPECT_EQ(read(kScene + "[output]\npreview = \"b.png\"\n").output.preview.file, "/shots/b.png");
}

TEST(SceneOutput, IsChecked) {
    const auto outputError = [](const std::string& lines) { return errorOf(kCamera + kVolume + "[output]\n" + lines); };
    EXPECT_EQ(outputError("compression = \"rle\"\n"),
              "scene.toml:7:15: 'compression' is the string \"rle\"; expected "
              "'zip', 'zips', 'piz', 'dwaa' or 'none'");
    EXPECT_EQ(outputError("type = \"double\"\n"),
              "scene.toml:7:8: 'type' is the string \"double\"; expected 'half' or "
              "'float'");
    EXPECT_EQ(outputError("fps = 0\n"),
              "scene.toml:7:7: 'fps' is 0; expected a number greater than 0 and of at most 1000000 frames a "
              "second");
    EXPECT_EQ(outputError("colorspace = \"none such\"\n").substr(0, 31), "scene.toml:7:14: 'colorspace': ");
    EXPECT_EQ(outputError("file = \"\"\n"),
              "scene.toml:7:8: 'file' is the string \"\"; expected a string that is not empty");
    EXPECT_EQ(outputError("preview = 3\n"),
              "scene.toml:7:11: 'preview' is 3; expected a path, or a table with 'file', "
              "'display', 'view', 'backplate' and 'annotate'");
    EXPECT_EQ(outputError("preview = { file = \"a.png\", view = \"film\" }\n").substr(0, 59),
              "scene.toml:7:36: 'view' is the string \"film\"; expected 'ACE");
}

TEST(SceneOutput, HasFurtherFilesInEitherForm) {
    const std::string main = "file = \"a.####.exr\"\ntype = \"float\"\nlayers = [\"light\"]\n";
    const std::string depth = "file = \"z.####.exr\"\nlayers = [\"volume\", \"depth\"]\ncompression = \"piz\"\n";
    const std::string copy = "file = \"copy.exr\"\npicture = true\ntype = \"half\"\ncolorspace = \"lin_rec709\"\n";
    const std::string inside = "[output]\n" + main + "[[output.files]]\n" + depth + "[[output.files]]\n" + copy;
    const std::string list = "[[output]]\n" + main + "[[output]]\n" + depth + "[[output]]\n" + copy;
    const std::string both = "[[output]]\n" + main + "[[output.files]]\n" + depth + "[[output]]\n" + copy;
    for (const std::string& text : {inside, list, both}) {
        const SceneOutput out = read(kScene + text, {"output.compression=zips"}, 7).output;
        EXPECT_EQ(out.file, "/shots/a.0007.exr");
        EXPECT_EQ(out.layers, std::vector<Layer>{Layer::light});
        EXPECT_TRUE(out.picture);
        ASSERT_EQ(out.files.size(), 2u);
        EXPECT_EQ(out.files[0].file, "/shots/z.0007.exr");
        EXPECT_EQ(out.files[0].layers, (std::vector{Layer::depth, Layer::volume}));
        EXPECT_FALSE(out.files[0].picture);
        EXPECT_FALSE(out.files[0].half) << "as the picture's";
        EXPECT_EQ(out.files[0].compression, "piz");
        EXPECT_EQ(out.files[1].compression, "zips") << "as the picture's";
        EXPECT_TRUE(out.files[1].half && out.files[1].picture);
        EXPECT_EQ(out.files[1].colorspace, scrim::test::ownColours().resolve("lin_rec709"));
        EXPECT_EQ(out.allLayers(), (std::vector{Layer::light, Layer::depth, Layer::volume}));
    }
}

TEST(SceneOutput, SaysWhatIsWrongWithFurtherFiles) {
    const auto fileError = [](const std::string& lines) {
        return errorOf(kCamera + kVolume + "[output]\n[[output.files]]\n" + lines);
    };
    EXPECT_EQ(fileError("layers = [\"depth\"]\n"),
              "scene.toml:7:1: [[files]] lacks 'file'; expected a path such as \"plume.z.####.exr\"");
    EXPECT_EQ(fileError("file = \"z.exr\"\n"),
              "scene.toml:7:1: [[files]] would hold nothing; expected 'layers', or 'picture' = true");
    EXPECT_EQ(fileError("file = \"z.png\"\nlayers = [\"depth\"]\n"),
              "scene.toml:8:8: 'file' is 'z.png'; expected a name that ends in '.exr'");
    EXPECT_EQ(fileError("file = \"z.exr\"\nlayers = [\"depth\"]\nfps = 3\n").substr(0, 20), "scene.toml:10:1: 'fp");
}

TEST(SceneOutput, DeepPicturesAreReadAndChecked) {
    const SceneDeep none = read(kScene).output.deep;
    EXPECT_EQ(none.file, "");
    const SceneDeep deep = read(kScene + "[output]\ndeep = \"d.####.exr\"\n", {}, 7).output.deep;
    EXPECT_EQ(deep.file, "/shots/d.0007.exr");
    EXPECT_EQ(deep.tolerance, 0.01);
    EXPECT_TRUE(deep.half);
    const SceneDeep other =
        read(kScene + "[output]\ndeep = \"d.exr\"\ndeep_tolerance = 0\ndeep_type = \"float\"\n").output.deep;
    EXPECT_EQ(other.tolerance, 0);
    EXPECT_FALSE(other.half);

    const auto outputError = [](const std::string& lines) { return errorOf(kCamera + kVolume + "[output]\n" + lines); };
    EXPECT_EQ(outputError("deep = 3\n"), "scene.toml:7:8: 'deep' is 3; expected a string that is not empty");
    EXPECT_EQ(outputError("deep = \"d.png\"\n"),
              "scene.toml:7:8: 'deep' is 'd.png'; expected a name that ends in '.exr'");
    EXPECT_EQ(outputError("deep = \"d.exr\"\ndeep_tolerance = 2\n"),
              "scene.toml:8:18: 'deep_tolerance' is 2; expected a number from 0 to 1");
    EXPECT_EQ(outputError("deep = \"d.exr\"\ndeep_type = \"double\"\n"),
              "scene.toml:8:13: 'deep_type' is the string \"double\"; expected 'half' or 'float'");
    EXPECT_EQ(outputError("deep_tolerance = 0.1\n"),
              "scene.toml:7:18: 'deep_tolerance' is set without 'deep'; expected the path of the deep picture, too");
    // A program may name the picture.
    SceneText text{"scene.toml", "", kScene + "[output]\ndeep_type = \"float\"\n"};
    text.deepFromCode = true;
    EXPECT_FALSE(readScene(text, 1, {}, test::ownColours()).output.deep.half);
}

TEST(SceneOutput, LayersAreInTheOrderOfTheEnumeration) {
    const auto layers = [](const std::string& list) {
        return read(kScene + "[output]\nlayers = " + list).output.layers;
    };
    EXPECT_TRUE(read(kScene).output.layers.empty());
    EXPECT_TRUE(layers("[]").empty());
    EXPECT_EQ(layers("[\"depth\", \"light\"]"), (std::vector<Layer>{Layer::light, Layer::depth}));
    EXPECT_EQ(layers("[\"transmittance\", \"depth\", \"albedo\", \"emission\", \"ambient\", \"light\"]"),
              (std::vector<Layer>{Layer::light, Layer::ambient, Layer::emission, Layer::albedo, Layer::depth,
                                  Layer::transmittance}));
}

// What is seen besides volumes can be taken out of the picture again.
TEST(SceneOutput, HasALayerOfWhatIsSeenBesidesVolumes) {
    const std::string sky = "[[light]]\nname = \"sky\"\ntype = \"dome\"\n";
    const std::string mesh = "[[mesh]]\nfile = \"a.obj\"\n", color = "color = [0.5, 0.4, 0.3]\n";
    const auto layers = [](const std::string& lines) { return read(kScene + lines).output.layers; };
    EXPECT_TRUE(layers(sky + mesh).empty());
    EXPECT_EQ(layers(sky + "visible = true\n"), std::vector{Layer::backdrop});
    EXPECT_EQ(
        layers("[[light]]\ntype = \"area\"\nshape = \"sphere\"\nradius = 1\nposition = [0, 9, 0]\nvisible = true\n"),
        std::vector{Layer::backdrop});
    EXPECT_EQ(layers(mesh + color), std::vector{Layer::backdrop});
    EXPECT_EQ(layers(mesh + color + "[output]\nlayers = [\"backdrop\", \"depth\"]\n"),
              (std::vector{Layer::depth, Layer::backdrop}));
    const auto tells = [](const std::string& lines, const std::string& text) {
        const std::string error = errorOf(kScene + lines);
        EXPECT_NE(error.find(text), std::string::npos) << error;
    };
    tells(mesh + color + "holdout = false\n", "'color' shows a mesh that does not hide what is behind it");
    tells(mesh + "color = [0.5, 1.4, 0.3]\n", "'color' is 0.5, 1.4, 0.3");
    tells(sky + "visible = true\n[output.holdout]\ndepth = \"z.exr\"\n", "has a backdrop of its own");
}

TEST(SceneOutput, LayersAreChecked) {
    const auto layersError = [](const std::string& lines) { return errorOf(kCamera + kVolume + "[output]\n" + lines); };
    EXPECT_EQ(layersError("layers = [\"depth\", \"normals\"]\n"),
              "scene.toml:7:20: 'layers[1]' is the string \"normals\"; expected 'light', 'direct', 'indirect', "
              "'ambient', 'emission', 'albedo', "
              "'depth', 'transmittance', 'shadow', 'volume', 'motion', 'cryptomatte' or 'backdrop'");
    EXPECT_EQ(layersError("layers = [\"depth\", \"depth\"]\n"),
              "scene.toml:7:20: 'layers[1]' repeats 'depth'; expected each layer once");
    EXPECT_EQ(
        layersError("layers = \"depth\"\n"),
        "scene.toml:7:10: 'layers' is the string \"depth\"; expected a list of layers: 'light', 'direct', "
        "'indirect', 'ambient', "
        "'emission', 'albedo', 'depth', 'transmittance', 'shadow', 'volume', 'motion', 'cryptomatte' or 'backdrop'");
}

TEST(SceneOutput, AcesContainersTakeNoLayers) {
    const auto containerError = [](const std::string& lines) {
        return errorOf(kCamera + kVolume + "[output]\ncolorspace = \"lin_ap0\"\n" + lines);
    };
    EXPECT_EQ(containerError("layers = [\"depth\"]\n"),
              "scene.toml:8:10: 'layers' cannot be written to an ACES container (half floats in ACES2065-1); expected "
              "another 'colorspace', or type = \"float\"");
    EXPECT_EQ(containerError("layers = []\n"), "no error");
    EXPECT_EQ(containerError("type = \"float\"\nlayers = [\"depth\"]\n"), "no error");
}

TEST(SceneRender, DialsOverrideTheQuality) {
    const Scene scene =
        read(kScene + "[render]\nquality = \"high\"\ntexel = 0.75\nshadow_filter = \"nearest\"\nantialias = 2\n");
    EXPECT_EQ(scene.quality, "high");
    EXPECT_EQ(scene.dials.sheetThickness, 1);
    EXPECT_EQ(scene.dials.texel, 0.75);
    EXPECT_EQ(scene.dials.shadowFilter, ShadowFilter::nearest);
    EXPECT_EQ(scene.dials.antialias, 2);
    EXPECT_EQ(read(kScene).quality, "standard");
    EXPECT_EQ(read(kScene).dials.footprintSteps, 8);
}

TEST(SceneRender, IsChecked) {
    const auto renderError = [](const std::string& lines) { return errorOf(kCamera + kVolume + "[render]\n" + lines); };
    EXPECT_EQ(renderError("quality = \"best\"\n"),
              "scene.toml:7:11: 'quality' is the string \"best\"; expected 'draft', "
              "'standard', 'high' or 'ultra'");
    EXPECT_EQ(renderError("texel = -1\n"), "scene.toml:7:9: 'texel' is -1; expected a number from 0.05 to 64 (voxels)");
    EXPECT_EQ(renderError("texel = inf\n"), "scene.toml:7:9: 'texel' is inf; expected a number");
    EXPECT_EQ(renderError("texel = []\n"), "scene.toml:7:9: 'texel' is a list of 0; expected a number from 0.05 to 64");
    EXPECT_EQ(renderError("tolerance = -0.005\n"),
              "scene.toml:7:13: 'tolerance' is -0.005; expected a number from 0 to 1 as relative RMSE; 0 for none");
    EXPECT_EQ(renderError("tolerance = 0.005\nsheet_thickness = 1\n"),
              "scene.toml:8:19: 'sheet_thickness' cannot be combined with 'tolerance', which chooses it");
    EXPECT_EQ(renderError("tolerance = 0.005\nmax_slant = 30\n"), "no error");
}

TEST(SceneReader, NeedsACameraAndAVolume) {
    EXPECT_EQ(errorOf(kVolume), "scene.toml:1:1: the scene's top level lacks 'camera'; expected a table [camera]");
    EXPECT_EQ(errorOf(kCamera),
              "scene.toml:1:1: the scene's top level lacks 'volume'; expected at least one [[volume]]");
    EXPECT_EQ(errorOf("volume = []\n" + kCamera),
              "scene.toml:1:10: 'volume' is a list of 0; expected at least one [[volume]]");
    EXPECT_EQ(errorOf(kScene + "[lihgt]\n").substr(0, 89),
              "scene.toml:13:2: 'lihgt' is not known here (the scene's top level); did you mean 'light'?");
}

TEST(SceneReader, AMarkOfUtf8IsNoPartOfTheScene) {
    const std::string mark = "\xef\xbb\xbf";
    EXPECT_EQ(read(mark + kScene).lights.size(), 2u);
    EXPECT_EQ(errorOf(mark + "camera = 3\n"), "scene.toml:1:10: 'camera' is 3; expected a table");
}

TEST(SceneReader, LocatesMalformedTomlWithClippedText) {
    EXPECT_EQ(errorOf("[camera\n").substr(0, 35), "scene.toml:1:8: malformed TOML: Err");
    EXPECT_EQ(errorOf("a = 1\na = 2\n").substr(0, 33), "scene.toml:2:5: malformed TOML: Error"s.substr(0, 33));
    const std::string garbage = errorOf("a = " + std::string(100000, 'x'));
    EXPECT_LT(garbage.size(), 300u);
    EXPECT_EQ(errorOf("a = \"\xff\xfe\"\n").substr(0, 11), "scene.toml:");
}

TEST(SceneReader, RefusesDeepNestingBeforeItParses) {
    const std::string brackets = ": more than 32 brackets are open; a scene needs no more than a few";
    const std::string parts = ": a key has more than 16 parts; a scene needs no more than a few";
    EXPECT_EQ(errorOf("\na = " + std::string(1000000, '[')), "scene.toml:2:1" + brackets);
    std::string dotted = "a";
    for (int i = 0; i < 100000; ++i) dotted += ".a";
    EXPECT_EQ(errorOf(dotted + " = 1\n"), "scene.toml:1:1" + parts);
    EXPECT_EQ(errorOf("# [[[\n[" + dotted + "]\n"), "scene.toml:2:1" + parts);
    std::string tables = "a = ";
    for (int i = 0; i < 100000; ++i) tables += "{a = ";
    EXPECT_EQ(errorOf(tables), "scene.toml:1:1" + brackets);
    EXPECT_EQ(overrideError("camera.fov=" + std::string(1000000, '[')), "--set camera.fov" + brackets);
    EXPECT_EQ(overrideError(dotted + "=1").substr(0, 8), "--set a.");
}

TEST(SceneReader, DotsAndBracketsInStringsAndCommentsDoNotNest) {
    const std::string many(100, '['), dots(100, '.');
    EXPECT_EQ(errorOf("# " + many + "\n" + kCamera + "[[volume]]\nname = \"" + many + "\\\"" + dots + "\"\nfile = '" +
                      dots + many + "'\n[variables]\na = \"\"\"" + many + "\n\" '" + dots + "\"\"\"\nb = '''" + many +
                      "\n'" + dots + "'''\n"),
              "no error");
}

TEST(SceneReader, RefusesFramesBeyondAnyClock) {
    EXPECT_EQ(errorOf(kScene, {}, 1e10), "scene.toml: frame 10000000000 is beyond 1000000000");
    EXPECT_EQ(errorOf(kScene, {}, std::numeric_limits<double>::quiet_NaN()),
              "scene.toml: frame nan is beyond 1000000000");
}

TEST(SceneOverride, ReplacesAddsAndSelects) {
    const Scene scene = read(kScene, {"camera.fov=20", "light.key.intensity = 3", "light[1].intensity=4",
                                      "light.light2.name=rim", "camera.position[1]=2.5", "render.quality=high",
                                      "output.file=out.####.exr", "volume[0].density.scale=7",
                                      "light.key.color=[1, 0, 0]", "ambient={ intensity = 2 }", "camera.\"near\"=0.5"});
    EXPECT_EQ(scene.camera.fov, 20);
    EXPECT_EQ(scene.camera.near, 0.5);
    EXPECT_EQ(scene.camera.wsPosition, Vec3(0, 2.5, 9));
    EXPECT_EQ(scene.lights[0].intensity, Rgb(3, 0, 0));
    EXPECT_EQ(scene.lights[1].intensity, Rgb(4));
    EXPECT_EQ(scene.lights[1].name, "rim");
    EXPECT_EQ(scene.quality, "high");
    EXPECT_EQ(scene.output.file, "/shots/out.0001.exr");
    EXPECT_EQ(scene.volumes[0].densityScale, 7);
    EXPECT_EQ(scene.ambient, Rgb(2));
}

TEST(SceneOverride, TheLastOneWins) {
    EXPECT_EQ(read(kScene, {"camera.fov=20", "camera.fov=30"}).camera.fov, 30);
}

TEST(SceneOverride, BareWordsAreStrings) {
    for (const char* value : {"####.exr", "12####.exr", "a b.exr", "1.2.exr", "#.exr"})
        EXPECT_TRUE(read(kScene, {std::string("output.file=") + value}).output.path.pattern == value) << value;
    EXPECT_EQ(read(kScene, {"camera.fov=.75"}).camera.fov, 0.75);
    EXPECT_EQ(read(kScene, {"output.file=\"q # x.exr\""}).output.path.pattern, "q # x.exr");
    EXPECT_EQ(read(kScene, {"output.file=C:\\\"a\""}).output.path.pattern, "C:\\\"a\"");
}

TEST(SceneOverride, ErrorsNameTheOverride) {
    EXPECT_EQ(overrideError("camera.fov=200"),
              "--set camera.fov: 'fov' is 200; expected a number greater than 0 and less than 180 degrees");
    EXPECT_EQ(overrideError("camera.fov=wide").substr(0, 60),
              "--set camera.fov: 'fov' is the string \"wide\"; expected a num"s.substr(0, 60));
    EXPECT_EQ(overrideError("camera.fvo=20").substr(0, 55),
              "--set camera.fvo: 'fvo' is not known here ([camera] of t"s.substr(0, 55));
    EXPECT_EQ(overrideError("light[0].radius=-1"),
              "--set light[0].radius: 'radius' is -1; expected a number from 0 to 1e+15 world units");
    EXPECT_EQ(overrideError("camera.position[2]=far"),
              "--set camera.position[2]: 'position[2]' is the string \"far\"; expected a number from -1e+15 "
              "to 1e+15 world units");
    EXPECT_EQ(overrideError("camra.fov=20").substr(0, 73),
              "--set camra.fov: 'camra' is not known here (the scene's top level); did y");
}

TEST(SceneOverride, PathsAreChecked) {
    EXPECT_EQ(overrideError("camera.fov"), "--set camera.fov: there is no '='; expected key.path=value");
    EXPECT_EQ(overrideError("=3"),
              "--set : '' is not a key; expected letters, digits, '-' and '_', or anything in quotes");
    EXPECT_EQ(overrideError("camera..fov=3"),
              "--set camera..fov: '' is not a key; expected letters, digits, '-' and '_', or anything in quotes");
    EXPECT_EQ(overrideError("camera.=3"),
              "--set camera.: '' is not a key; expected letters, digits, '-' and '_', or anything in quotes");
    EXPECT_EQ(overrideError("camera.f v=3"),
              "--set camera.f v: 'f v' is not a key; expected letters, digits, '-' and '_', or anything in quotes");
    EXPECT_EQ(overrideError("light[2].intensity=3"),
              "--set light[2].intensity: 'light' has 2 elements, counted from 0");
    EXPECT_EQ(overrideError("light[x].intensity=3"),
              "--set light[x].intensity: '[' is not followed by an index (from 0) and ']'");
    EXPECT_EQ(overrideError("light[0.intensity=3"),
              "--set light[0.intensity: '[' is not followed by an index (from 0) and ']'");
    EXPECT_EQ(overrideError("light[0]x=3"), "--set light[0]x: a part of the path is not followed by '.' or '['");
    EXPECT_EQ(overrideError("light.kee.intensity=3"),
              "--set light.kee.intensity: there is no light 'kee'; expected 'key' or "
              "'light2'");
    EXPECT_EQ(overrideError("light.key=3"), "--set light.key: the path ends at a table; add the key to set");
    EXPECT_EQ(overrideError("camera[0].fov=3"), "--set camera[0].fov: 'camera' is not a list");
    EXPECT_EQ(overrideError("none[0]=3"), "--set none[0]: there is no list 'none'");
    EXPECT_EQ(overrideError("none.a[0]=3"), "--set none.a[0]: there is no list 'a'");
    EXPECT_EQ(overrideError("camera.position.x=3"),
              "--set camera.position.x: 'position' is a list; write position[0] for its first element");
    EXPECT_EQ(overrideError("light.key.type.x=3"), "--set light.key.type.x: 'type' is not a table");
    EXPECT_EQ(overrideError("camera.\"fov=3"), "--set camera.\"fov=3: there is no '='; expected key.path=value");
}

TEST(SceneOverride, ValuesAreOneValue) {
    EXPECT_EQ(overrideError("camera.fov=[1, 2").substr(0, 33), "--set camera.fov: malformed TOML:");
    EXPECT_EQ(overrideError("fov=20\ncamera.near = 1"), "--set fov: there is more than one value");
    EXPECT_EQ(overrideError("camera.fov=").substr(0, 46),
              "--set camera.fov: 'fov' is the string \"\"; expect"s.substr(0, 46));
}

TEST(SceneAsToml, IsTheTextItselfWithoutOverrides) {
    EXPECT_EQ(sceneAsToml({"scene.toml", "", "# hello\n" + kScene}, {}), "# hello\n" + kScene);
}

TEST(SceneAsToml, HoldsTheOverridesAndReadsTheSame) {
    const std::vector<std::string> overrides{"camera.fov=20.1",
                                             "light.key.color={ rgb = [0.1, 0.2, 0.3], colorspace = \"sRGB\" }",
                                             "variables.A=x\"y", "camera.near=1e-7"};
    const std::string text = sceneAsToml({"scene.toml", "", kScene}, overrides);
    const Scene direct = read(kScene, overrides), printed = read(text);
    EXPECT_EQ(printed.camera.fov, 20.1) << text;
    EXPECT_EQ(printed.camera.near, 1e-7);
    EXPECT_EQ(printed.lights[0].intensity, direct.lights[0].intensity);
    EXPECT_EQ(printed.lights[1].name, direct.lights[1].name);
    EXPECT_EQ(sceneAsToml({"scene.toml", "", text}, {"camera.fov=20.1"}), text);
}

TEST(SceneAsToml, KeepsNumbersAsTheyWereSaid) {
    const std::string text =
        sceneAsToml({"scene.toml", "", kCamera + "near = 1.6\n" + kVolume + "density = { scale = 0.1 }\n"},
                    {"volume[0].name='1.6000000000000001 \"x'", "camera.fov=35.3", "camera.height=1e-7"});
    EXPECT_NE(text.find("near = 1.6\n"), std::string::npos) << text;
    EXPECT_NE(text.find("fov = 35.3\n"), std::string::npos) << text;
    EXPECT_NE(text.find("scale = 0.1 "), std::string::npos) << text;
    EXPECT_NE(text.find("1.6000000000000001 \\\"x"), std::string::npos) << text;
    EXPECT_EQ(text.find("30000000"), std::string::npos) << text;
}

class SceneTextTest : public ::testing::Test {
  protected:
    std::string errorOf(const std::string& path) {
        try {
            loadSceneText(path);
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::input);
            return error.what();
        }
        return "no error";
    }
    test::TempFolder m_folder;
};

TEST_F(SceneTextTest, KnowsItsFolder) {
    const std::string path = m_folder.file("a.toml");
    std::ofstream(path) << kScene;
    const SceneText text = loadSceneText(path);
    EXPECT_EQ(text.file, path);
    EXPECT_EQ(text.folder, m_folder.path());
    EXPECT_EQ(text.text, kScene);
}

TEST_F(SceneTextTest, SaysWhyItCannotBeRead) {
    EXPECT_EQ(errorOf(m_folder.file("none.toml")), m_folder.file("none.toml") + ": there is no such scene file");
    EXPECT_EQ(errorOf(m_folder.path()), m_folder.path() + ": not a regular file; expected a scene (TOML)");
    const std::string big = m_folder.file("big.toml");
    std::ofstream(big) << std::string((std::size_t{16} << 20) + 1, '\n');
    EXPECT_EQ(errorOf(big), big + ": the scene file is larger than 16 MB");
}

}  // namespace
}  // namespace scrim
