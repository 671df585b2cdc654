// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_reader.h>

#include <scrim/image/clear_sky.h>

#include "unit/scene/read_scene.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

/// [[light]] is line 6, `lines` begin at line 7.
std::string sceneWith(const std::string& lines) {
    return kCamera + kVolume + "[[light]]\n" + lines;
}
Light light(const std::string& lines, double frame = 1) {
    return read(sceneWith(lines), {}, frame).lights.at(0);
}
std::string lightError(const std::string& lines) {
    return errorOf(sceneWith(lines));
}

TEST(SceneLight, DistantNeedsOnlyADirection) {
    const Light l = light("type = \"distant\"\ndirection = [0, -3, 0]\n");
    EXPECT_EQ(l.name, "light1");
    EXPECT_TRUE(l.distant());
    EXPECT_EQ(l.wsDirection, Vec3(0, -1, 0));
    EXPECT_EQ(l.intensity, Rgb(1));
    EXPECT_TRUE(l.shadows);
}

TEST(SceneLight, IntensityIsColourTimesIntensityTimesExposure) {
    const Light l = light(
        "type = \"distant\"\ndirection = [0, 0, -1]\ncolor = [1, 0.5, 0]\nintensity = 3\nexposure = "
        "2\nshadows = false\n");
    EXPECT_EQ(l.intensity, Rgb(12, 6, 0));
    EXPECT_FALSE(l.shadows);
}

TEST(SceneLight, ReadsEveryKeyOfASpot) {
    const Light l = light(
        "name = \"key\"\ntype = \"spot\"\nposition = [0, 5, 0]\ntarget = [3, 5, 0]\nradius = 0.25\ncone = "
        "60\nblend = 1\n"
        "decay = \"none\"\n");
    EXPECT_EQ(l.name, "key");
    ASSERT_TRUE(l.spot());
    EXPECT_EQ(l.wsPosition, Vec3(0, 5, 0));
    EXPECT_EQ(l.wsDirection, Vec3(1, 0, 0));
    EXPECT_EQ(l.point().radius, 0.25);
    EXPECT_EQ(std::get<Light::Spot>(l.kind).coneAngle, 60);
    EXPECT_EQ(std::get<Light::Spot>(l.kind).blend, 1);
    EXPECT_FALSE(l.point().decay);
    EXPECT_TRUE(light("type = \"point\"\nposition = [0, 5, 0]\ndecay = \"inverse-square\"\n").point().decay);
}

TEST(SceneLight, MayHaveALuminaireThatHangsUprightUnlessItIsAimed) {
    const std::string point = "type = \"point\"\nposition = [1, 2, 3]\nies = \"lamp.##.ies\"\n";
    const Light hanging = light(point, 7);
    ASSERT_TRUE(hanging.luminaire);
    EXPECT_EQ(hanging.luminaire->file, "/shots/lamp.07.ies");
    EXPECT_EQ(hanging.luminaire->where, "scene.toml:9:7");
    EXPECT_EQ(hanging.wsDirection, Vec3(0, -1, 0));
    const Light aimed = light(point + "target = [1, 2, 9]\nup = [2, 0, 0]\n");
    EXPECT_EQ(aimed.wsDirection, Vec3(0, 0, 1));
    EXPECT_EQ(aimed.wsUp, Vec3(1, 0, 0));
    const std::string spot = "type = \"spot\"\nposition = [0, 5, 0]\ndirection = [1, 0, 0]\nies = \"lamp.ies\"\n";
    EXPECT_EQ(light(spot).wsDirection, Vec3(1, 0, 0));
    EXPECT_TRUE(light(spot).luminaire);
    const Light circling = light("type = \"point\"\nies = \"a.ies\"\norbit = { center = [0, 0, 0], radius = 2 }\n");
    EXPECT_NEAR(glm::distance(circling.wsDirection, -0.5 * circling.wsPosition), 0, 1e-12);
    EXPECT_FALSE(light("type = \"point\"\nposition = [1, 2, 3]\n").luminaire);
    EXPECT_NE(lightError("type = \"distant\"\ndirection = [0, 0, -1]\nies = \"lamp.ies\"\n"), "");
}

TEST(SceneLight, MayBeKeyed) {
    const Light l = light(
        "type = \"spot\"\nposition = { keys = [[1, [0, 0, 0]], [3, [2, 0, 0]]] }\ntarget = [1, -1, 0]\n"
        "intensity = { keys = [[1, 0], [3, 4]] }\ncolor = { keys = [[1, [0, 0, 0]], [3, [2, 0, 0]]] }\n",
        2);
    EXPECT_EQ(l.wsPosition, Vec3(1, 0, 0));
    EXPECT_EQ(l.wsDirection, Vec3(0, -1, 0));
    EXPECT_EQ(l.intensity, Rgb(2, 0, 0));
}

TEST(SceneLight, ConvertsColoursIntoTheWorkingSpace) {
    const Light l = light(
        "type = \"distant\"\ndirection = [0, 0, -1]\ncolor = { rgb = [0.5, 0.5, 0.5], colorspace = \"sRGB\" "
        "}\n");
    // The sRGB curve: ((0.5 + 0.055) / 1.055)^2.4; grey stays grey.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(l.intensity[c], std::pow(0.555 / 1.055, 2.4), 1e-5);
    EXPECT_EQ(
        lightError("type = \"distant\"\ndirection = [0, 0, -1]\ncolor = { rgb = [1, 1, 1], colorspace = \"no\" }\n")
            .substr(0, 17),
        "scene.toml:9:41: ");
    EXPECT_EQ(lightError("type = \"distant\"\ndirection = [0, 0, -1]\ncolor = { rgb = [1, 1, 1] }\n"),
              "scene.toml:9:9: the colour 'color' lacks 'colorspace'; expected the name of a colour space");
    EXPECT_EQ(lightError("type = \"distant\"\ndirection = [0, 0, -1]\ncolor = [1, -1, 1]\n"),
              "scene.toml:9:13: 'color[1]' is -1; expected a number of at least 0");
    EXPECT_EQ(lightError("type = \"distant\"\ndirection = [0, 0, -1]\ncolor = \"red\"\n"),
              "scene.toml:9:9: 'color' is the string \"red\"; expected a colour [r, g, b], each of at least 0, or { "
              "rgb = [r, g, b], colorspace = \"...\" }");
}

TEST(SceneLight, KeysBelongToTypes) {
    EXPECT_EQ(
        lightError("type = \"distant\"\ndirection = [0, 0, -1]\nradius = 1\n"),
        "scene.toml:9:1: 'radius' is not known here ([[light]] 'light1' of type 'distant'); allowed: 'name', "
        "'group', 'type', 'direction', 'orbit', 'color', 'intensity', 'exposure', 'temperature', 'angle', 'samples', "
        "'slide', 'shadows' or 'shadow'");
    EXPECT_EQ(
        lightError("type = \"point\"\nposition = [0, 0, 0]\ncone = 30\n"),
        "scene.toml:9:1: 'cone' is not known here ([[light]] 'light1' of type 'point'); allowed: 'name', "
        "'group', 'type', "
        "'position', 'orbit', 'color', 'intensity', 'exposure', 'temperature', 'radius', 'decay', 'ies', 'slide', "
        "'shadows' or 'shadow'");
    EXPECT_EQ(lightError("type = \"cylinder\"\n"),
              "scene.toml:7:8: 'type' is the string \"cylinder\"; expected 'distant', 'point', 'spot', 'projector', "
              "'area' or 'dome'");
}

TEST(SceneLight, NeedsWhatItsTypeNeeds) {
    EXPECT_EQ(
        lightError("name = \"key\"\n"),
        "scene.toml:6:1: [[light]] 'key' lacks 'type'; expected 'distant', 'point', 'spot', 'projector', 'area' or "
        "'dome'");
    EXPECT_EQ(lightError("type = \"distant\"\n"),
              "scene.toml:6:1: [[light]] 'light1' of type 'distant' lacks 'direction'; expected a direction [x, y, z]");
    EXPECT_EQ(lightError("type = \"point\"\n"),
              "scene.toml:6:1: [[light]] 'light1' of type 'point' lacks 'position'; expected a point [x, y, z]");
    EXPECT_EQ(lightError("type = \"spot\"\nposition = [0, 0, 0]\n"),
              "scene.toml:6:1: [[light]] 'light1' of type 'spot' lacks 'direction'; expected a direction [x, y, z], or "
              "'target', a point [x, y, z]");
    EXPECT_EQ(lightError("type = \"spot\"\nposition = [0, 0, 0]\ndirection = [1, 0, 0]\ntarget = [1, 0, 0]\n"),
              "scene.toml:10:10: [[light]] has both 'direction' and 'target'; expected one of them");
    EXPECT_EQ(lightError("type = \"spot\"\nposition = [1, 0, 0]\ntarget = [1, 0, 0]\n"),
              "scene.toml:9:10: the light is at the same point as its 'target' at frame 1 (1, 0, 0)");
    EXPECT_EQ(lightError("type = \"distant\"\ndirection = [0, 0, 0]\n"),
              "scene.toml:8:13: 'direction' is 0, 0, 0 at frame 1; expected a direction");
}

TEST(SceneLight, RangesAreChecked) {
    EXPECT_EQ(lightError("type = \"spot\"\nposition = [0, 0, 0]\ndirection = [1, 0, 0]\ncone = 181\n"),
              "scene.toml:10:8: 'cone' is 181; expected a number greater than 0 and of at most 180 degrees");
    EXPECT_EQ(lightError("type = \"spot\"\nposition = [0, 0, 0]\ndirection = [1, 0, 0]\nblend = 1.1\n"),
              "scene.toml:10:9: 'blend' is 1.1; expected a number from 0 to 1");
    EXPECT_EQ(lightError("type = \"point\"\nposition = [0, 0, 0]\nintensity = -1\n"),
              "scene.toml:9:13: 'intensity' is -1; expected a number from 0 to 1e+30");
    EXPECT_EQ(lightError("type = \"point\"\nposition = [0, 0, 0]\nexposure = 100\n"),
              "scene.toml:9:12: 'exposure' is 100; expected a number from -64 to 64 stops");
    EXPECT_EQ(lightError("type = \"point\"\nposition = [0, 0, 0]\nshadows = 1\n"),
              "scene.toml:9:11: 'shadows' is 1; expected true or false");
}

TEST(SceneLight, NamesAreUnique) {
    const std::string two =
        "name = \"a\"\ntype = \"point\"\nposition = [0, 0, 0]\n[[light]]\nname = \"a\"\ntype = "
        "\"point\"\nposition = [0, 0, 0]\n";
    EXPECT_EQ(lightError(two),
              "scene.toml:10:1: [[light]] number 2 is called 'a', and so is number 1; expected different names");
    EXPECT_EQ(lightError("name = \"a\\u0007\"\ntype = \"point\"\nposition = [0, 0, 0]\n"),
              "scene.toml:7:8: 'name' is the string \"a?\"; expected a name without control characters");
}

TEST(SceneLight, ATableIsNoList) {
    EXPECT_EQ(errorOf(kCamera + kVolume + "[light]\ntype = \"point\"\n"),
              "scene.toml:6:1: 'light' is a table; expected a list of tables, each written [[light]]");
}

TEST(SceneAmbient, IsColourTimesIntensity) {
    const auto ambient = [](const std::string& lines) { return read(kCamera + kVolume + lines).ambient; };
    EXPECT_EQ(ambient(""), Rgb(0));
    EXPECT_EQ(ambient("[ambient]\n"), Rgb(0));
    EXPECT_EQ(ambient("[ambient]\ncolor = [0.1, 0.2, 0.3]\n"), Rgb(0.1, 0.2, 0.3));
    EXPECT_EQ(ambient("[ambient]\nintensity = 0.5\n"), Rgb(0.5));
    EXPECT_EQ(ambient("[ambient]\ncolor = [1, 2, 4]\nintensity = 0.5\n"), Rgb(0.5, 1, 2));
    EXPECT_EQ(errorOf(kCamera + kVolume + "[ambient]\ncolour = [1, 1, 1]\n"),
              "scene.toml:7:1: 'colour' is not known here ([ambient]); did you mean 'color'?; allowed: 'color' or "
              "'intensity'");
}

const std::string kBox = "type = \"area\"\nposition = [1, 2, 3]\ntarget = [1, 2, 0]\n";

TEST(SceneLight, ReadsEveryAreaLight) {
    const Light box = light(kBox +
                            "shape = \"rectangle\"\nwidth = 4\nheight = 0.5\nup = [1, 0, 0]\nintensity = 3\n"
                            "exposure = 1\nsamples = 12\n");
    ASSERT_TRUE(box.area() && box.extended());
    EXPECT_EQ(box.area()->shape, AreaShape::rectangle);
    EXPECT_EQ(box.area()->width, 4);
    EXPECT_EQ(box.area()->height, 0.5);
    EXPECT_EQ(box.area()->area(), 2);
    EXPECT_EQ(box.wsPosition, Vec3(1, 2, 3));
    EXPECT_EQ(box.wsDirection, Vec3(0, 0, -1));
    EXPECT_EQ(box.wsUp, Vec3(1, 0, 0));
    EXPECT_EQ(box.intensity, Rgb(6));
    EXPECT_EQ(box.samples, 12);
    const Light tube = light(kBox + "shape = \"cylinder\"\nwidth = 3\nradius = 0.1\n");
    EXPECT_EQ(tube.area()->shape, AreaShape::cylinder);
    EXPECT_NEAR(tube.area()->area(), 2 * std::acos(-1.0) * 0.1 * 3, 1e-12);
    EXPECT_EQ(light(kBox + "shape = \"disk\"\nradius = 2\nspread = 40\n").area()->spread, 40);
    EXPECT_NE(lightError(kBox + "shape = \"cylinder\"\nwidth = 3\nradius = 1\nspread = 40\n").find("'spread'"),
              std::string::npos);
    const Light disk = light(kBox + "shape = \"disk\"\nradius = 2\nsamples = \"auto\"\n");
    EXPECT_NEAR(disk.area()->area(), 4 * std::acos(-1.0), 1e-12);
    EXPECT_EQ(disk.samples, 0);
    const Light sphere = light("type = \"area\"\nposition = [1, 2, 3]\nshape = \"sphere\"\nradius = 2\n");
    EXPECT_NEAR(sphere.area()->area(), 16 * std::acos(-1.0), 1e-12);
}

TEST(SceneLight, OfAMeshHasItsName) {
    const std::string tube = "[[mesh]]\nname = \"tube\"\nfile = \"tube.obj\"\n",
                      area = "type = \"area\"\nshape = \"mesh\"\n";
    const Light lamp = light(area + "mesh = \"tube\"\nintensity = 3\nnormalize = true\n" + tube);
    EXPECT_EQ(lamp.area()->mesh, "tube");
    EXPECT_EQ(lamp.intensity, Rgb(3)) << "divided once the mesh is there";
    EXPECT_NE(lightError(area + tube).find(" lacks 'mesh'"), std::string::npos) << lightError(area + tube);
    EXPECT_NE(lightError(area + "mesh = \"tub\"\n" + tube)
                  .find(": there is no mesh 'tub'; did you mean 'tube'?; expected 'tube'"),
              std::string::npos);
    EXPECT_NE(lightError(area + "mesh = \"tube\"\nposition = [0, 0, 0]\n" + tube).find("'position' is not known here"),
              std::string::npos);
    EXPECT_NE(lightError(area + "mesh = \"tube\"\nslide = { file = \"a.png\" }\n" + tube)
                  .find("only a rectangle can have one"),
              std::string::npos);
}

// UsdLux' meaning: the power stays, whatever the size.
TEST(SceneLight, IsDividedByItsAreaWhereNormalized) {
    EXPECT_EQ(
        light(kBox + "shape = \"rectangle\"\nwidth = 4\nheight = 2\nintensity = 24\nnormalize = true\n").intensity,
        Rgb(3));
    EXPECT_NEAR(light(kBox + "shape = \"disk\"\nradius = 3\nintensity = 9\nnormalize = true\n").intensity.x,
                1 / std::acos(-1.0), 1e-12);
}

TEST(SceneLight, ReadsASunWithAnAngle) {
    const Light sun = light("type = \"distant\"\ndirection = [0, -1, 0]\nangle = 0.53\n");
    EXPECT_TRUE(sun.distant() && sun.extended());
    EXPECT_EQ(std::get<Light::Distant>(sun.kind).angle, 0.53);
    EXPECT_FALSE(light("type = \"distant\"\ndirection = [0, -1, 0]\n").extended());
}

TEST(SceneLight, ReadsADomeWithAColourOrAPicture) {
    const Light sky = light("type = \"dome\"\ncolor = [0.5, 1, 2]\nintensity = 2\nrotation = 30\nup = [0, 0, 1]\n");
    ASSERT_TRUE(sky.dome());
    EXPECT_EQ(sky.dome()->rotation, 30);
    EXPECT_EQ(sky.intensity, Rgb(1, 2, 4));
    EXPECT_EQ(sky.wsUp, Vec3(0, 0, 1));
    EXPECT_FALSE(sky.slide);
    const Light picture = light("type = \"dome\"\ntexture = { file = \"sky.exr\", colorspace = \"ACEScg\" }\n");
    ASSERT_TRUE(picture.slide);
    EXPECT_NE(picture.slide->file.find("sky.exr"), std::string::npos);
    EXPECT_EQ(picture.slide->colorspace, "ACEScg");
}

TEST(SceneLight, ReadsADomeWithAClearSky) {
    const std::string dome = "type = \"dome\"\n";
    const Light plain = light(dome + "sky = {}\n");
    ASSERT_TRUE(plain.dome() && plain.slide && plain.slide->sky);
    EXPECT_EQ(*plain.slide->sky, ClearSky());
    EXPECT_TRUE(plain.slide->file.empty());
    EXPECT_EQ(plain.slide->where, "scene.toml:8:7");
    const std::string keyed =
        "sky = { sun_elevation = { keys = [[1, 30], [11, 10]] }, altitude = 1500, air_density = "
        "1.5, dust_density = 2, ozone_density = 3, ground_albedo = 0.4, sun_disc = false, "
        "sun_size = 1, sun_intensity = 0.25 }\n";
    const ClearSky sky = *light(dome + keyed, 6).slide->sky;
    EXPECT_EQ(sky, (ClearSky{20, 1500, 1.5, 2, 3, 0.4, false, 1, 0.25}));
    EXPECT_NE(sky, *light(dome + keyed, 7).slide->sky);
}

TEST(SceneLight, SaysWhatIsWrongWithAClearSky) {
    const std::string dome = "type = \"dome\"\n";
    EXPECT_EQ(lightError(dome + "sky = { sun_elevation = 95 }\n"),
              "scene.toml:8:25: 'sun_elevation' is 95; expected a number from -90 to 90 degrees");
    EXPECT_EQ(lightError(dome + "sky = { dust_density = -1 }\n"),
              "scene.toml:8:24: 'dust_density' is -1; expected a number from 0 to 10");
    EXPECT_EQ(lightError(dome + "sky = { turbidity = 3 }\n"),
              "scene.toml:8:9: 'turbidity' is not known here ('sky' of [[light]] 'light1' of type 'dome'); allowed: "
              "'sun_elevation', 'altitude', 'air_density', 'dust_density', 'ozone_density', 'ground_albedo', "
              "'sun_disc', 'sun_size' or 'sun_intensity'");
    EXPECT_EQ(lightError(dome + "sky = {}\ntexture = { file = \"a.exr\" }\n"),
              "scene.toml:9:11: [[light]] has both 'sky' and 'texture'; expected one of them");
    EXPECT_NE(lightError("type = \"point\"\nposition = [0, 0, 0]\nsky = {}\n").find("'sky'"), std::string::npos);
}

// 6500 K is near white, and candles are red; both have the luminance of [1, 1, 1].
TEST(SceneLight, HasTheColourOfItsTemperature) {
    const std::string sun = "type = \"distant\"\ndirection = [0, -1, 0]\n";
    const Rgb warm = light(sun + "temperature = 2000\n").intensity,
              cool = light(sun + "temperature = 6500\n").intensity;
    EXPECT_GT(warm.x, 1.5);
    EXPECT_GT(warm.x, 3 * warm.z);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(cool[c], 1, 0.1);
    const Rgb tinted = light(sun + "temperature = 2000\ncolor = [1, 0.5, 0]\nintensity = 2\n").intensity;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(tinted[c], warm[c] * Rgb(2, 1, 0)[c], 1e-12);
    EXPECT_NE(lightError(sun + "temperature = -5\n").find(": 'temperature' is -5; expected a number from 800 to 40000"),
              std::string::npos);
    EXPECT_EQ(lightError(sun + "temperature = -5\n").rfind("'temperature'"),
              lightError(sun + "temperature = -5\n").find("'temperature'"));
}

TEST(SceneLight, SaysWhatAnAreaLightOrDomeLacks) {
    EXPECT_NE(
        lightError(kBox + "shape = \"cone\"\n").find("expected 'rectangle', 'disk', 'sphere', 'cylinder' or 'mesh'"),
        std::string::npos);
    EXPECT_NE(lightError(kBox).find("'shape'"), std::string::npos);
    EXPECT_NE(lightError(kBox + "shape = \"rectangle\"\nwidth = 1\n").find("'height'"), std::string::npos);
    EXPECT_NE(lightError(kBox + "shape = \"disk\"\nradius = 0\n").find("expected a length above 0"), std::string::npos);
    EXPECT_NE(lightError(kBox + "shape = \"disk\"\nradius = 1\nslide = { file = \"a.png\" }\n")
                  .find("only a rectangle can have one"),
              std::string::npos);
    EXPECT_NE(
        lightError("type = \"distant\"\ndirection = [0, -1, 0]\nposition = [0, 0, 0]\nangle = 3\nslide = { file = "
                   "\"a.png\", width = 1 }\n")
            .find("the light of a slide is parallel"),
        std::string::npos);
    EXPECT_NE(lightError("type = \"dome\"\nnormalize = true\n").find("'normalize'"), std::string::npos);
    EXPECT_NE(lightError("type = \"dome\"\nsamples = \"many\"\n").find("whole number"), std::string::npos);
    EXPECT_NE(lightError("type = \"point\"\nposition = [0, 0, 0]\nsamples = 3\n").find("'samples'"), std::string::npos);
}

}  // namespace
}  // namespace scrim::test
