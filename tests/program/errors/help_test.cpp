// SPDX-License-Identifier: Apache-2.0
// What the program tells of itself: help, completion, man pages.
#include "support/program_test.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <regex>
#include <sstream>
#include <string>

namespace scrim::test {
namespace {

using Help = ProgramTest;

TEST_F(Help, KnowsCommandsSectionsAndKeys) {
    const std::string render = runWell({"help", "render"}).out;
    EXPECT_NE(render.find("--frames"), std::string::npos);
    EXPECT_NE(render.find("sheet_thickness"), std::string::npos);  // the section of that name, too
    EXPECT_NE(runWell({"help"}).out.find("blackbody"), std::string::npos);
    EXPECT_NE(runWell({"help", "light"}).out.find("irradiance"), std::string::npos);
    EXPECT_NE(runWell({"help", "camera.shift"}).out.find("aperture offset"), std::string::npos);
    EXPECT_EQ(runWell({"help", "--schema"}).out.front(), '{');
    const ProgramResult wrong = run({"help", "camra"});
    EXPECT_EQ(wrong.status, 2);
    EXPECT_NE(wrong.err.find("did you mean 'camera'?"), std::string::npos) << wrong.err;
}

TEST_F(Help, CompletesCommandsOptionsPathsAndWords) {
    write("complete.sh",
          "eval \"$(\"$1\" help --completion)\"\nask() { COMP_WORDS=(\"$@\"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); "
          "compopt() { "
          ":; }; _scrim; echo \"${COMPREPLY[*]}\"; }\nask scrim re\nask scrim render --ski\nask scrim render --set "
          "camera.fo\nask scrim render --quality u\nask scrim render --missing ''\n");
    ASSERT_EQ(std::system(("bash " + file("complete.sh") + " " + SCRIM_PROGRAM + " >" + file("out")).c_str()), 0);
    EXPECT_EQ(
        readBytes(file("out")),
        "render\n--skip-existing\ncamera.fov= camera.fov_axis= camera.focal_length= camera.focus_distance=\nultra\n"
        "error black skip\n");
}

/// A page as it is read: no fonts, no escapes. Fails where roff would take a line for a request that it is not.
std::string readAsText(const std::string& page) {
    static const std::regex kRequest("\\.(TH|SH|SS|TP|BR|br|nf|fi)( .*)?"), kFont("\\\\f[BIR]|\\\\&");
    std::istringstream lines(page);
    for (std::string line; std::getline(lines, line);)
        EXPECT_TRUE(!(line.starts_with(".") || line.starts_with("'")) || std::regex_match(line, kRequest)) << line;
    std::string text = std::regex_replace(page, kFont, "");
    text = std::regex_replace(text, std::regex("\\\\-"), "-");
    EXPECT_EQ(std::regex_replace(text, std::regex("\\\\e"), "").find('\\'), std::string::npos);
    return text;
}

TEST_F(Help, HasAManPageForEachCommandWithEachOfItsOptions) {
    const std::string overview = readAsText(runWell({"help", "--man"}).out);
    const std::regex option("--[a-z][a-z-]+");
    for (const std::string command : {"render", "plan", "study", "bake", "info", "make", "merge", "view", "help"}) {
        EXPECT_NE(overview.find("\n.TP\n" + command + "\n"), std::string::npos) << command;
        const std::string page = readAsText(runWell({"help", "--man", command}).out);
        EXPECT_TRUE(page.starts_with(".TH SCRIM-")) << page.substr(0, 40);
        const std::string help = runWell({command, "--help"}).out;
        int options = 0;
        for (std::sregex_iterator found(help.begin(), help.end(), option), end; found != end; ++found, ++options)
            EXPECT_NE(page.find(found->str()), std::string::npos) << command << " " << found->str();
        EXPECT_GT(options, 0) << command;
    }
    const ProgramResult wrong = run({"help", "--man", "rendr"});
    EXPECT_EQ(wrong.status, 2);
    EXPECT_EQ(wrong.err,
              "scrim: error: there is no man page on 'rendr'; did you mean 'render'?; expected 'scene', 'render', "
              "'plan', 'study', 'bake', 'info', 'make', 'merge', 'view' or 'help'\n");
}

TEST_F(Help, HasAManPageWithEveryKeyOfScenes) {
    const std::string page = readAsText(runWell({"help", "--man", "scene"}).out);
    const auto schema = nlohmann::json::parse(runWell({"help", "--schema"}).out);
    int keys = 0;
    for (const auto& [section, definition] : schema.at("$defs").items())
        for (const auto& [key, of] : definition.at("properties").items()) {
            EXPECT_NE(page.find("\n.TP\n" + key), std::string::npos) << section << "." << key;
            ++keys;
        }
    EXPECT_GT(keys, 100);
}

}  // namespace
}  // namespace scrim::test
