// SPDX-License-Identifier: Apache-2.0
// The table of keys is what the reader reads, no more and no less, and what documents say.
#include "read_scene.h"

#include <scrim/base/error.h>
#include <scrim/scene/check_scene.h>
#include <scrim/scene/scene_help.h>
#include <scrim/scene/scene_keys.h>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
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
        {"grids", {kCamera + "[[volume]]\n[volume.grids.density]\n@"}},
        {"remap", {kCamera + kVolume + "[volume.density.remap]\n@"}},
        {"mask",
         {kCamera + kVolume + "[volume.density.mask]\ngrid = \"m\"\n@",
          kCamera + kVolume + "[volume.density.mask]\n@"}},
        {"noise", {kCamera + kVolume + "[volume.density.noise]\n@"}},
        {"frame", {kCamera + kVolume + "[volume.frame]\n@"}},
        {"transform", {kCamera + kVolume + "[volume.transform]\n@"}},
        {"density", {kCamera + kVolume + "[volume.density]\n@"}},
        {"points", {kCamera + kVolume + "[volume.points]\n@"}},
        {"velocity",
         {kCamera + kVolume + "[volume.velocity]\ngrid = \"v\"\n@", kCamera + kVolume + "[volume.velocity]\n@"}},
        {"medium", {kMedium + "@"}},
        {"albedo", {kMedium + "[volume.medium.albedo]\ngrid = \"Cd\"\n@", kMedium + "[volume.medium.albedo]\n@"}},
        {"phase",
         {kMedium + "[volume.medium.phase]\n@", kMedium + "[volume.medium.phase]\ntype = \"hg\"\n@",
          kMedium + "[volume.medium.phase]\ntype = \"two-lobe\"\n@",
          kMedium + "[volume.medium.phase]\ntype = \"two-lobe\"\ng1 = 0\n@",
          kMedium + "[volume.medium.phase]\ntype = \"two-lobe\"\ng1 = 0\ng2 = 0\n@",
          kMedium + "[volume.medium.phase]\ntype = \"draine\"\ng = 0\n@",
          kMedium + "[volume.medium.phase]\ntype = \"droplets\"\n@"}},
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
          kCamera + kVolume + "[[light]]\ntype = \"area\"\nshape = \"mesh\"\n@", kCamera + kVolume + kDome + "@"}},
        {"texture",
         {kCamera + kVolume + kDome + "[light.texture]\n@",
          kCamera + kVolume + kDome + "[light.texture]\nfile = \"a.exr\"\n@"}},
        {"sky", {kCamera + kVolume + kDome + "[light.sky]\n@"}},
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
        {"files",
         {kCamera + kVolume + "[output]\n[[output.files]]\n@",
          kCamera + kVolume + "[output]\n[[output.files]]\nfile = \"z.exr\"\n@"}},
        {"holdout",
         {kCamera + kVolume + "[output.holdout]\n@", kCamera + kVolume + "[output.holdout]\ndepth = \"z.exr\"\n@"}},
        {"preview",
         {kCamera + kVolume + "[output.preview]\n@", kCamera + kVolume + "[output.preview]\nfile = \"a.png\"\n@",
          kCamera + kVolume + "[output.preview]\nfile = \"a.png\"\nbackplate = \"b.exr\"\n@"}},
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

// Defaults of keys that set a member are those of the member. These keys set none.
TEST(SceneKeys, HaveTheDefaultsOfScenesThatAreBuiltInCode) {
    EXPECT_EQ(keysOf<CameraKeys>().resolution.fallback, "[512, 512]");
    EXPECT_EQ(Camera().resolution, Int2(512, 512));
    const LightKeys& l = keysOf<LightKeys>();
    EXPECT_EQ(*l.cone.value, Light::Spot().coneAngle);
    EXPECT_EQ(*l.blend.value, Light::Spot().blend);
    EXPECT_EQ(*l.radius.value, Light::Spot().radius);
    EXPECT_EQ(*keysOf<SlideKeys>().fov.value, Slide().fov);
    EXPECT_EQ(keysOf<MediumKeys>().albedo.fallback, "[0.9, 0.9, 0.9]");
    EXPECT_EQ(Medium().albedo, Rgb(0.9));
    EXPECT_EQ(keysOf<ClassifiedKeys>().albedo.fallback, "[0.9, 0.9, 0.9]");
    EXPECT_EQ(Classified().albedo, Rgb(0.9));
    EXPECT_EQ(keysOf<OutputKeys>().compression.fallback, '"' + SceneOutput().compression + '"');
    EXPECT_EQ(keysOf<RenderKeys>().quality.fallback, '"' + Scene().quality + '"');
}

TEST(SceneKeys, StateTheDefaultsOfTheirMembers) {
    EXPECT_EQ(*keysOf<CameraKeys>().fov.value, 35);
    EXPECT_EQ(keysOf<OutputKeys>().type.fallback, "\"half\"");
    EXPECT_EQ(keysOf<VelocityKeys>().unit.fallback, "\"second\"");
    EXPECT_EQ(keysOf<HoldoutKeys>().kind.fallback, "\"z\"");
    EXPECT_EQ(keysOf<MeshKeys>().holdout.fallback, "true");
    EXPECT_EQ(*keysOf<OctavesKeys>().count.value, 8) << "a table of octaves asks for some, a medium without one has 1";
    EXPECT_FALSE(keysOf<PhaseKeys>().g.value) << "it is needed";
}

TEST(SceneKeys, SetTheirMembersAndNoOthers) {
    SceneOutput output;
    const OutputKeys& k = keysOf<OutputKeys>();
    k.type.member.set(output, 1);
    k.fps.member.set(output, 30);
    EXPECT_FALSE(output.half);
    EXPECT_EQ(k.type.member.get(output), 1);
    EXPECT_EQ(output.fps, 30);
    EXPECT_TRUE(output.deep.half);
    SceneVolume volume;
    keysOf<FrameKeys>().outside.member.set(volume, 2);
    EXPECT_EQ(volume.outside, OutsidePolicy::black);
    EXPECT_THROW(k.fps.member.set(volume, 30), std::logic_error) << "a key of [output] set a member of a volume";
    EXPECT_FALSE(k.file.member);
}

/// Expects that a scene in code is held to every key of `section` that sets a member, as a file is: by the key's name
/// and its range. `part` finds in a scene what the section describes.
template <typename Object, typename Part>
void expectHeldTo(const SectionOf<Object>& section, const Part& part) {
    for (const Key& key : section.keys()) {
        if (!key.member || !key.only.empty() || key.type == Key::Type::boolean) continue;
        for (const double value : {key.range.low - 1, key.range.high + 1, double(key.words.size())}) {
            const bool isChoice = key.type == Key::Type::choice;
            if (isChoice ? value != double(key.words.size()) || key.words.size() == 2 : key.range.holds(value))
                continue;
            if (key.type == Key::Type::integer && !std::isfinite(value)) continue;
            Scene scene;
            scene.volumes.emplace_back();
            key.member.set(part(scene), value);
            try {
                checkScene(scene);
                ADD_FAILURE() << section.title() << ": " << key.name << " = " << value;
            } catch (const Error& error) {
                const std::string text = error.what(), name = fmt::format("{} is ", key);
                EXPECT_NE(text.find(name), std::string::npos) << text;
                EXPECT_NE(text.find(isChoice ? choices(key.words) : key.range.text()), std::string::npos) << text;
            }
        }
    }
}

TEST(SceneKeys, HoldScenesInCodeToWhatTheyAllowInFiles) {
    const auto scene = [](Scene& s) -> Scene& { return s; };
    const auto volume = [](Scene& s) -> SceneVolume& { return s.volumes[0]; };
    expectHeldTo(keysOf<CameraKeys>(), scene);
    expectHeldTo(keysOf<RenderKeys>(), scene);
    expectHeldTo(keysOf<FrameKeys>(), volume);
    expectHeldTo(keysOf<DensityKeys>(), volume);
    expectHeldTo(keysOf<RemapKeys>(), [](Scene& s) -> Remap& { return s.volumes[0].shading.remap.emplace(); });
    expectHeldTo(keysOf<NoiseKeys>(), [](Scene& s) -> Noise& { return s.volumes[0].displacement.emplace(); });
    expectHeldTo(keysOf<VelocityKeys>(), [](Scene& s) -> Velocity& { return s.volumes[0].velocity.emplace(); });
    expectHeldTo(keysOf<AlbedoGridKeys>(), [](Scene& s) -> ColourGrid& { return s.volumes[0].albedoGrid.emplace(); });
    expectHeldTo(keysOf<OctavesKeys>(), [](Scene& s) -> Octaves& { return s.volumes[0].medium.octaves; });
    expectHeldTo(keysOf<EmissionKeys>(), [](Scene& s) -> Emission& { return s.volumes[0].emission.emplace_back(); });
    expectHeldTo(keysOf<OutputKeys>(), [](Scene& s) -> SceneOutput& { return s.output; });
    expectHeldTo(keysOf<HoldoutKeys>(), [](Scene& s) -> SceneHoldout& { return s.output.holdout; });
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
