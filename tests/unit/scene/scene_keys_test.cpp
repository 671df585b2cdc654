// SPDX-License-Identifier: Apache-2.0
// The table of keys is what the reader reads, no more and no less, and what documents say.
#include "read_scene.h"

#include <scrim/scene/scene_help.h>
#include <scrim/scene/scene_keys.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

const std::string kLight = "[[light]]\ntype = \"distant\"\ndirection = [0, 0, -1]\n";
const std::string kBox = "[[light]]\ntype = \"area\"\nposition = [0, 0, 9]\n", kDome = "[[light]]\ntype = \"dome\"\n";
const std::string kMedium = kCamera + kVolume + "[volume.medium]\n";

/// Scenes to put a line of a section into, at "@"; one for every kind of it.
const std::map<std::string, std::vector<std::string>>& places() {
    static const std::map<std::string, std::vector<std::string>> all{
        {"scene", {"@" + kCamera + kVolume, "@" + kVolume, "@" + kCamera}},
        {"camera",
         {kCamera + "@" + kVolume, kCamera + "type = \"orthographic\"\n@" + kVolume,
          kCamera + "focal_length = 50\naperture = [36, 24]\n@" + kVolume, kCamera + "focal_length = 50\n@" + kVolume,
          kCamera + "aperture = 36\n@" + kVolume, "[camera]\nexr = \"a.exr\"\n@" + kVolume, "[camera]\n@" + kVolume,
          "[camera]\nposition = [0, 0, 9]\n@" + kVolume}},
        {"orbit", {"[camera]\n[camera.orbit]\n@" + kVolume, "[camera]\n[camera.orbit]\nradius = 2\n@" + kVolume}},
        {"volume",
         {kCamera + "[[volume]]\nfile = \"a.vdb\"\n@", kCamera + "[[volume]]\nsource = \"noise\"\n@",
          kCamera + "[[volume]]\n@"}},
        {"frame", {kCamera + kVolume + "[volume.frame]\n@"}},
        {"transform", {kCamera + kVolume + "[volume.transform]\n@"}},
        {"density", {kCamera + kVolume + "[volume.density]\n@"}},
        {"velocity",
         {kCamera + kVolume + "[volume.velocity]\ngrid = \"v\"\n@", kCamera + kVolume + "[volume.velocity]\n@"}},
        {"medium", {kMedium + "@"}},
        {"albedo", {kMedium + "[volume.medium.albedo]\ngrid = \"Cd\"\n@", kMedium + "[volume.medium.albedo]\n@"}},
        {"phase",
         {kMedium + "[volume.medium.phase]\n@", kMedium + "[volume.medium.phase]\ntype = \"hg\"\n@",
          kMedium + "[volume.medium.phase]\ntype = \"two-lobe\"\n@",
          kMedium + "[volume.medium.phase]\ntype = \"two-lobe\"\ng1 = 0\n@",
          kMedium + "[volume.medium.phase]\ntype = \"two-lobe\"\ng1 = 0\ng2 = 0\n@"}},
        {"octaves", {kMedium + "[volume.medium.octaves]\n@"}},
        {"emission", {kMedium + "[volume.medium.emission]\n@", kMedium + "[volume.medium.emission]\ngrid = \"f\"\n@"}},
        {"blackbody",
         {kMedium + "[volume.medium.blackbody]\n@", kMedium + "[volume.medium.blackbody]\ngrid = \"f\"\n@"}},
        {"classified",
         {kCamera + kVolume + "[volume.classified]\n@",
          kCamera + kVolume +
              "[volume.classified]\ntransfer = [{ value = 0, extinction = 0 }, { value = 1, extinction = 1 }]\n@"}},
        {"transfer",
         {kCamera + kVolume + "[volume.classified]\n[[volume.classified.transfer]]\n@",
          kCamera + kVolume + "[volume.classified]\n[[volume.classified.transfer]]\nvalue = 1\n@"}},
        {"mesh", {kCamera + kVolume + "[[mesh]]\nfile = \"a.obj\"\n@", kCamera + kVolume + "[[mesh]]\n@"}},
        {"light",
         {kCamera + kVolume + kLight + "@", kCamera + kVolume + "[[light]]\n@",
          kCamera + kVolume + "[[light]]\ntype = \"distant\"\n@", kCamera + kVolume + "[[light]]\ntype = \"point\"\n@",
          kCamera + kVolume + "[[light]]\ntype = \"spot\"\nposition = [0, 0, 9]\n@",
          kCamera + kVolume + "[[light]]\ntype = \"spot\"\nposition = [0, 0, 9]\ndirection = [0, 0, -1]\n@",
          kCamera + kVolume +
              "[[light]]\ntype = \"projector\"\nslide = { file = \"a.png\" }\nposition = [0, 0, 9]\ndirection = [0, 0, "
              "-1]\n@",
          kCamera + kVolume + kBox + "@", kCamera + kVolume + kBox + "shape = \"rectangle\"\n@",
          kCamera + kVolume + kBox + "shape = \"rectangle\"\nwidth = 1\n@",
          kCamera + kVolume + kBox + "shape = \"rectangle\"\nwidth = 1\nheight = 1\n@",
          kCamera + kVolume + kBox + "shape = \"rectangle\"\nwidth = 1\nheight = 1\ndirection = [0, 0, -1]\n@",
          kCamera + kVolume + kBox + "shape = \"disk\"\nradius = 1\ndirection = [0, 0, -1]\n@",
          kCamera + kVolume + kDome + "@"}},
        {"texture",
         {kCamera + kVolume + kDome + "[light.texture]\n@",
          kCamera + kVolume + kDome + "[light.texture]\nfile = \"a.exr\"\n@"}},
        {"slide",
         {kCamera + kVolume + kLight + "position = [0, 0, 0]\n[light.slide]\n@",
          kCamera + kVolume + kLight + "position = [0, 0, 0]\n[light.slide]\nfile = \"a.png\"\n@",
          kCamera + kVolume + kLight + "position = [0, 0, 0]\n[light.slide]\nfile = \"a.png\"\nwidth = 1\n@",
          kCamera + kVolume +
              "[[light]]\ntype = \"spot\"\nposition = [0, 0, 9]\ndirection = [0, 0, -1]\n[light.slide]\nfile = "
              "\"a.png\"\n@"}},
        {"ambient", {kCamera + kVolume + "[ambient]\n@"}},
        {"render", {kCamera + kVolume + "[render]\n@"}},
        {"output", {kCamera + kVolume + "[output]\n@"}},
        {"holdout",
         {kCamera + kVolume + "[output.holdout]\n@", kCamera + kVolume + "[output.holdout]\ndepth = \"z.exr\"\n@"}},
        {"preview",
         {kCamera + kVolume + "[output.preview]\n@", kCamera + kVolume + "[output.preview]\nfile = \"a.png\"\n@"}},
        {"keys", {kCamera + "[camera.fov]\n@" + kVolume, kCamera + "[camera.fov]\nkeys = [[1, 20]]\n@" + kVolume}},
        {"colour",
         {kCamera + kVolume + "[ambient.color]\n@", kCamera + kVolume + "[ambient.color]\nrgb = [1, 1, 1]\n@",
          kCamera + kVolume + "[ambient.color]\ncolorspace = \"ACEScg\"\n@"}},
    };
    return all;
}

/// What is said of "`name` = `value`" in the first place of the section where it is the value that is complained about.
std::string complaintAbout(const Section& section, const std::string& name, const std::string& value) {
    for (std::string scene : places().at(section.topic())) {
        scene.replace(scene.find('@'), 1, name + " = " + value + "\n");
        const std::string error = errorOf(scene);
        const auto says = [&](const std::string& text) { return error.find(text) != std::string::npos; };
        const bool elsewhere = says("is not known here") || says(" lacks ") || says("has both") || says("malformed") ||
                               says("since its light") || error == "no error";
        if (!elsewhere && (says("'" + name) || says("'keys[0]"))) return error;
    }
    return "";
}

TEST(SceneKeys, AreAllReadAndChecked) {
    for (const Section* section : sceneSections())
        for (const Key& key : section->keys()) {
            if (key.name == "albedo") continue;  // whose messages are those of the colour's components
            // A date is what no key takes.
            const std::string error = complaintAbout(*section, key.name, "1979-05-27");
            EXPECT_NE(error.find("a date or time; expected "), std::string::npos)
                << section->topic() << "." << key.name << ": " << error;
        }
}

TEST(SceneKeys, AreKeyedWhereTheTableSaysSoAndNowhereElse) {
    for (const Section* section : sceneSections())
        for (const Key& key : section->keys()) {
            if (key.inner != nullptr || key.name == "parameters" || key.name == "variables") continue;
            const std::string error = complaintAbout(*section, key.name, "{ keys = [[1, 1979-05-27]] }");
            // Keys are opened, and what is in them is wrong; or else a table is not what was expected.
            const bool opened = error.find("a date or time; expected") != std::string::npos;
            EXPECT_EQ(opened, key.isKeyed) << section->topic() << "." << key.name << ": " << error;
            EXPECT_TRUE(opened || key.type == Key::Type::colour ||
                        error.find("is a table; expected") != std::string::npos)
                << section->topic() << "." << key.name << ": " << error;
        }
}

TEST(SceneKeys, StandInTheTableAndNotInTheReader) {
    std::set<std::string> names;
    for (const Section* section : sceneSections())
        for (const Key& key : section->keys()) names.insert(key.name);
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(SCRIM_SOURCE_DIR "/src/scrim/scene")) {
        const std::string file = entry.path().filename();
        if (!(file.starts_with("read_") || file.starts_with("scene_reader")) || !file.ends_with(".cpp")) continue;
        ++files;
        std::ifstream in(entry.path());
        std::ostringstream text;
        text << in.rdbuf();
        for (const std::string& name : names)
            for (const char quote : {'"', '\''})
                EXPECT_EQ(text.str().find(quote + name + quote), std::string::npos) << file << ": " << name;
    }
    EXPECT_GE(files, 9u);
}

TEST(SceneKeys, HaveTheDefaultsOfScenesThatAreBuiltInCode) {
    const CameraKeys& c = keysOf<CameraKeys>();
    EXPECT_EQ(*c.fov.value, Camera().fov);
    EXPECT_EQ(*c.near.value, Camera().near);
    EXPECT_EQ(*c.pixelAspect.value, Camera().pixelAspect);
    EXPECT_EQ(c.resolution.fallback, "[512, 512]");
    EXPECT_EQ(Camera().resolution, Int2(512, 512));
    const LightKeys& l = keysOf<LightKeys>();
    EXPECT_EQ(*l.cone.value, Light::Spot().coneAngle);
    EXPECT_EQ(*l.blend.value, Light::Spot().blend);
    EXPECT_EQ(*l.radius.value, Light::Spot().radius);
    EXPECT_EQ(*keysOf<SlideKeys>().fov.value, Slide().fov);
    EXPECT_EQ(keysOf<MediumKeys>().albedo.fallback, "[0.9, 0.9, 0.9]");
    EXPECT_EQ(Medium().albedo, Rgb(0.9));
    EXPECT_EQ(*keysOf<PhaseKeys>().blend.value, Phase().blend);
    EXPECT_EQ(*keysOf<OctavesKeys>().extinction.value, Octaves().extinction);
    EXPECT_EQ(*keysOf<OctavesKeys>().contribution.value, Octaves().contribution);
    EXPECT_EQ(*keysOf<OctavesKeys>().phase.value, Octaves().phase);
    const ClassifiedKeys& s = keysOf<ClassifiedKeys>();
    EXPECT_EQ(*s.ambient.value, Classified().ambient);
    EXPECT_EQ(*s.diffuse.value, Classified().diffuse);
    EXPECT_EQ(*s.specular.value, Classified().specular);
    EXPECT_EQ(*s.exponent.value, Classified().exponent);
    EXPECT_EQ(*s.twoSided.value != 0, Classified().twoSided);
    EXPECT_EQ(*keysOf<OutputKeys>().fps.value, SceneOutput().fps);
    EXPECT_EQ(keysOf<OutputKeys>().compression.fallback, '"' + SceneOutput().compression + '"');
    EXPECT_EQ(keysOf<RenderKeys>().quality.fallback, '"' + Scene().quality + '"');
}

TEST(SceneHelp, IsTheDocument) {
    std::ifstream file(SCRIM_SOURCE_DIR "/examples/SCENES.md");
    std::ostringstream text;
    text << file.rdbuf();
    EXPECT_EQ(text.str(), scenesAsMarkdown()) << "scrim help --markdown > examples/SCENES.md";
}

TEST(SceneHelp, ExplainsSectionsAndKeys) {
    for (const std::string& topic : sceneTopics()) EXPECT_GT(sceneHelp(topic).size(), 100u) << topic;
    EXPECT_NE(sceneHelp("camera.fov").find("0 and below 180 degrees"), std::string::npos) << sceneHelp("camera.fov");
    // Of the camera and of slides.
    EXPECT_NE(sceneHelp("fov").find("slide = "), std::string::npos);
    EXPECT_EQ(sceneHelp("camera.fov").find("slide = "), std::string::npos);
    EXPECT_EQ(sceneHelp("fvo"), "");
    EXPECT_EQ(sceneHelp("light.fvo"), "");
}

TEST(SceneHelp, SchemaHasEveryKeyAndRefersToWhatIsThere) {
    const nlohmann::json schema = nlohmann::json::parse(sceneSchema());
    for (const Section* section : sceneSections()) {
        const nlohmann::json& part =
            section == sceneSections().front() ? schema : schema.at("$defs").at(section->topic());
        EXPECT_EQ(part.at("additionalProperties"), false);
        for (const Key& key : section->keys())
            EXPECT_NE(part.at("properties").at(key.name).at("description"), "") << key.name;
        EXPECT_EQ(part.at("properties").size(), section->keys().size());
    }
    const std::string text = schema.dump();
    for (std::size_t at = 0; (at = text.find("#/$defs/", at)) != std::string::npos; ++at) {
        const std::size_t begin = at + 8, end = text.find('"', begin);
        EXPECT_TRUE(schema.at("$defs").contains(text.substr(begin, end - begin))) << text.substr(begin, end - begin);
    }
}

}  // namespace
}  // namespace scrim::test
