// SPDX-License-Identifier: Apache-2.0
// Scenes that are printed read back as the same scenes, whatever their keys and strings hold.
#include <scrim/scene/toml_text.h>

#include "unit/scene/read_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace scrim {
namespace {

using test::kCamera;
using test::read;

using Parameters = std::vector<std::pair<std::string, std::string>>;

Parameters sorted(Parameters parameters) {
    std::sort(parameters.begin(), parameters.end());
    return parameters;
}

/// A key or a string made of what a writer of TOML may get wrong.
std::string hostileText(std::mt19937& random, bool control = true) {
    static const std::vector<std::string> printable{
        "\"",     "\"\"\"", "'",         "'''", "\\", "\\u0041", "#", ".", "=",    "[",
        "]",      "{",      "}",         ",",   " ",  "a",       "-", "7", "true", "1.60000000000000009",
        "\u00e9", "\u2028", "\U0010ffff"};
    static const std::vector<std::string> others{"\t", "\n", "\r\n", "\b", "\x01", "\x1f", "\x7f"};
    std::string text;
    for (auto count = random() % 6; count > 0; --count) {
        const auto& pieces = control && random() % 3 == 0 ? others : printable;
        text += pieces[random() % pieces.size()];
    }
    return text;
}

/// A scene whose names, keys and strings are hostile. Its numbers are in `parameters`, too.
std::string hostileScene(std::mt19937& random, bool isInline) {
    const auto quoted = [&] { return tomlString(hostileText(random) + "x"); };
    std::string scene =
        kCamera + fmt::format("[variables]\n{0} = {1}\n[[light]]\nname = {2}\ntype = \"point\"\nposition = [0, 0, 5]\n",
                              quoted(), quoted(), tomlString(hostileText(random, false) + "x"));
    scene += fmt::format("[[volume]]\nname = {}\nsource = \"noise\"\n", tomlString(hostileText(random, false) + "x"));
    std::string parameters;
    for (int i = 0; i < 4; ++i)
        parameters += fmt::format("{} = {}{}", tomlString(fmt::format("{}{}", hostileText(random), i)),
                                  i == 3 ? "[0.1, 1e300, -7]" : quoted(), isInline ? ", " : "\n");
    parameters += "last = 1.6000000000000001";
    return scene + (isInline ? "parameters = { " + parameters + " }\n" : "[volume.parameters]\n" + parameters + "\n");
}

void expectSame(const Scene& printed, const Scene& direct, const std::string& text) {
    EXPECT_EQ(printed.volumes[0].name, direct.volumes[0].name) << text;
    EXPECT_EQ(sorted(printed.volumes[0].parameters), sorted(direct.volumes[0].parameters)) << text;
    EXPECT_EQ(printed.lights[0].name, direct.lights[0].name) << text;
    EXPECT_EQ(printed.output.path.pattern, direct.output.path.pattern) << text;
    EXPECT_EQ(printed.camera.fov, direct.camera.fov) << text;
}

TEST(TomlWriter, KeepsWhateverKeysAndStringsHold) {
    std::mt19937 random(7);
    for (int i = 0; i < 500 && !::testing::Test::HasFailure(); ++i) {
        const std::string scene = hostileScene(random, i % 2 == 0);
        const std::vector<std::string> overrides{
            "volume[0].parameters.\"a\nkey\tof\n\t'tabs'\"=" + tomlString(hostileText(random) + "y"),
            "output.file=" + tomlString(hostileText(random) + ".exr"), "camera.fov=20.1"};
        const Scene direct = read(scene, overrides);
        const std::string text = sceneAsToml({"scene.toml", "", scene}, overrides);
        ASSERT_NO_THROW(expectSame(read(text), direct, text)) << text;
        EXPECT_EQ(sceneAsToml({"scene.toml", "", text}, {"camera.fov=20.1"}), text);
    }
}

TEST(TomlWriter, KeepsInlineTablesAndGivesLongListsALineForEachItem) {
    std::string list, lines;
    for (int i = 0; i < 60; ++i) {
        list += fmt::format("[{}.0, 0.5], ", i);
        lines += fmt::format("    [{}.0, 0.5],\n", i);
    }
    const std::string scene = kCamera + "[[volume]]\nfile = \"z.vdb\"\ndensity = { ramp = [" + list +
                              "], scale = 2.0 }\n[volume.medium.octaves]\ncount = 3\n";
    EXPECT_EQ(sceneAsToml({"scene.toml", "", scene}, {"output.fps=25.0", "camera.a.b=1979-05-27T07:32:00Z"}),
              "[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\n\n[camera.a]\nb = 1979-05-27T07:32:00Z\n\n"
              "[output]\nfps = 25.0\n\n[[volume]]\ndensity = { ramp = [\n" +
                  lines + "], scale = 2.0 }\nfile = \"z.vdb\"\n\n[volume.medium.octaves]\ncount = 3\n");
}

}  // namespace
}  // namespace scrim
