// SPDX-License-Identifier: Apache-2.0
// Commands that documents show are run as they stand there, in the order of their document: on a small smoke.vdb,
// head.nrrd and a folder of DICOM files, and smaller where that is all that a substitution changes. A command that the
// program refuses fails, and so does a line of a shell block that is neither run here nor listed with whoever runs it.
#include "support/program_test.h"

#include "support/data.h"
#include "support/dicom_files.h"
#include "support/tiff_files.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

namespace scrim::test {
namespace {

namespace fs = std::filesystem;

/// Lines of shell blocks that this test does not run, each by its beginning.
const std::vector<std::pair<std::string, std::string>> kRunElsewhere = {
    {"examples/quickstart.sh", "by tests/bare/run.sh, which runs the front page's first two commands"},
    {"tests/run.sh", "by tests/bare/run.sh"},
    {"src/cmake/install_packages.sh python3-venv python3-dev", "by tests/run.sh, with more packages"},
    {"src/cmake/packages.sh build", "by .ci/full"},
    {"apt-get install ./build/packages/", "by tests/program/packages/run.sh"},
    {"scrim-submit ", "by tests/plugins/farm/run.sh"},
    {"openjd run ", "by tests/plugins/farm/run.sh"},
    {"/usr/bin/python3 -m venv venv", "by .ci/full: it compiles all of Scrim once more"},
    {"venv/bin/pip install '.[usd]'", "by hand, too"},
    {"venv/bin/pip install '.[view]'", "by hand, too"},
    {"scrim view ", "by tests/plugins/python/test_view_server.py: it serves until it is ended"},
    {"export SCRIM_PYTHON=venv/bin/python", "by tests/plugins/python/test_usd_settings.py"},
};

/// What makes a command small enough, or names a file that is there.
const std::map<std::string, std::string> kInstead = {
    {"--verify 400", "--verify 10"},
    {"--verify 100", "--verify 10"},
    {"--tolerance 0.005", "--tolerance 0.05"},  // the volume is a box with hard edges
    {"--budget 120", "--budget 1"},
    {"--frames 1-48 ", "--frames 1-48x16 "},
    {"--frames 1-48x8", "--frames 1-48x24"},
    {"--res 1920x1080 --crop 0,0,960,1080", "--crop 0,0,16,32"},
    {"--res 1920x1080 --crop 960,0,1920,1080", "--crop 16,0,32,32"},
    {"--turntable 24", "--turntable 3"},
    {" --display-server localhost:14158", ""},  // a viewer is there in tests/plugins/python/test_display.py
    {"variables.PICTURE=/path/to/picture.png", "variables.PICTURE=../paper/slides/rings.png"},
};

struct Command {
    std::string where;               // file:line
    std::string text;                // as it stands there
    std::vector<std::string> words;  // without the program
    std::string output;              // the file that stdout goes to, or empty
};

std::string trimmed(const std::string& text) {
    const std::size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
    return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

bool startsWith(const std::string& text, const std::string& start) {
    return text.rfind(start, 0) == 0;
}

/// As a shell parts them: single quotes hold a word together, and # begins a comment where a word could begin.
std::vector<std::string> shellWords(const std::string& line) {
    std::vector<std::string> words;
    bool inWord = false, quoted = false;
    for (const char c : line) {
        if (!quoted && c == ' ') {
            inWord = false;
            continue;
        }
        if (!inWord && c == '#') break;
        if (!inWord) words.emplace_back();
        inWord = true;
        if (c == '\'')
            quoted = !quoted;
        else
            words.back() += c;
    }
    return words;
}

bool isCommand(const std::string& line) {
    if (startsWith(line, "scrim view ")) return false;  // it does not end by itself
    return startsWith(line, "scrim ") || startsWith(line, "build/bin/scrim ");
}

Command commandFrom(const std::string& where, const std::string& line) {
    std::string smaller = line;
    for (const auto& [text, instead] : kInstead)
        if (const std::size_t at = smaller.find(text); at != std::string::npos)
            smaller.replace(at, text.size(), instead);
    Command command{.where = where, .text = line, .words = shellWords(smaller), .output = ""};
    command.words.erase(command.words.begin());
    const auto arrow = std::find(command.words.begin(), command.words.end(), ">");
    if (arrow != command.words.end()) {
        command.output = *(arrow + 1);
        command.words.erase(arrow, arrow + 2);
    }
    return command;
}

struct Line {
    std::string where, text;
};

/// Those of a file; those that end with \ are joined with what follows. `prefix` is taken away, and lines without it
/// are empty.
std::vector<Line> linesOf(const std::string& name, const std::string& prefix = "") {
    std::ifstream file(SCRIM_REPOSITORY "/" + name);
    EXPECT_TRUE(file.good()) << name;
    std::vector<Line> lines;
    bool joins = false;
    int number = 0;
    for (std::string text; std::getline(file, text);) {
        ++number;
        text = startsWith(text, prefix) ? text.substr(prefix.size()) : "";
        const bool continues = !text.empty() && text.back() == '\\';
        if (continues) text.pop_back();
        if (joins)
            lines.back().text += trimmed(text);
        else
            lines.push_back({name + ":" + std::to_string(number), text});
        joins = continues;
    }
    return lines;
}

/// Of the shell blocks of a page, of its sessions ("$ scrim ..." in a block) and of code in a line that renders a
/// scene. `strange` gets the lines of shell blocks that are no commands of Scrim's.
std::vector<Command> commandsOfPage(const std::string& name, std::vector<std::string>& strange) {
    std::vector<Command> commands;
    std::string block;  // the fence of the block we are in, or empty
    for (const Line& line : linesOf(name)) {
        if (startsWith(line.text, "```")) {
            block = block.empty() ? line.text : "";
            continue;
        }
        const std::string text = trimmed(line.text);
        if (block == "```sh" && isCommand(text))
            commands.push_back(commandFrom(line.where, text));
        else if (block == "```sh" && !text.empty())
            strange.push_back(line.where + ": " + text);
        else if (!block.empty() && startsWith(text, "$ scrim "))
            commands.push_back(commandFrom(line.where, text.substr(2)));
        else if (block.empty()) {
            const std::string start = "`scrim render examples/";
            for (std::size_t at = text.find(start); at != std::string::npos; at = text.find(start, at + 1))
                commands.push_back(commandFrom(line.where, text.substr(at + 1, text.find('`', at + 1) - at - 1)));
        }
    }
    return commands;
}

/// Of the comments that a scene begins with.
std::vector<Command> commandsOfScene(const std::string& name) {
    std::vector<Command> commands;
    for (const Line& line : linesOf(name, "#     "))
        if (isCommand(line.text)) commands.push_back(commandFrom(line.where, line.text));
    return commands;
}

std::vector<std::string> filesOf(const std::string& folder, const std::string& extension) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(SCRIM_REPOSITORY "/" + folder))
        if (entry.path().extension() == extension) names.push_back(folder + "/" + entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

std::vector<std::string> pages() {
    std::vector<std::string> names{"README.md"};
    for (const char* folder : {"examples", "examples/guide"})
        for (const std::string& name : filesOf(folder, ".md")) names.push_back(name);
    return names;
}

/// Is it about a stage of OpenUSD, or what one needs? tests/plugins/python/test_usd_settings.py runs those.
bool needsPython(const Command& command) {
    return std::any_of(command.words.begin(), command.words.end(), [](const std::string& word) {
        return fs::path(word).extension() == ".usda" || word == "examples/scenes/plume.vdb";
    });
}

/// Does it render a scene that reads a scan of the data folder?
bool needsData(const Command& command) {
    return std::any_of(command.words.begin(), command.words.end(), [](const std::string& word) {
        if (!startsWith(word, "examples/") || fs::path(word).extension() != ".toml") return false;
        std::ostringstream text;
        text << std::ifstream(SCRIM_REPOSITORY "/" + word).rdbuf();
        return text.str().find("${SCRIM_DATA}") != std::string::npos;
    });
}

class Documents : public ProgramTest {
  protected:
    void SetUp() override {
        ProgramTest::SetUp();
        fs::create_directory_symlink(SCRIM_REPOSITORY "/examples", file("examples"));
        std::string samples(16 * 16 * 16, '\0');
        for (std::size_t i = 0; i < samples.size(); ++i)  // a box of 200 within 0
            if (i % 16 / 4 % 3 != 0 && i / 16 % 16 / 4 % 3 != 0 && i / 256 / 4 % 3 != 0)
                samples[i] = static_cast<char>(200);
        fs::create_directory(file("ct"));
        for (int z = 0; z < 16; ++z) write(fmt::format("ct/{:02}.dcm", z), bodySlice(z).bytes());
        write("cells.tif", ballPages().bytes());
        fs::create_directory(file("slices"));
        for (std::size_t z = 0; z < 16; ++z) write(fmt::format("slices/cell_C1_{}.tif", z), ballSlice(z).bytes());
        write("head.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 16 16 16\nencoding: raw\n\n" + samples);
    }

    /// Pictures of 32 x 32 pixels, and scenes in `examples` with coarse dials.
    void expectWorks(const Command& command) const {
        std::vector<std::string> words = command.words;
        const auto says = [&](const std::string& part) { return command.text.find(part) != std::string::npos; };
        if (words[0] == "render" && !says("--print-scene")) {
            words.insert(words.end(), {"--res", "32x32"});
            if (says("examples/"))
                words.insert(words.end(), {"--set", "render.texel=4", "--set", "render.sheet_thickness=8"});
            else if (!says("--tolerance") && !says("--budget") && !says("--set render."))
                words.insert(words.end(), {"--quality", "draft"});
        }
        const ProgramResult result = run(words, {.environment = {{"SCRIM_DATA", dataFolder()}}});
        EXPECT_EQ(result.status, 0) << command.where << ": " << command.text << "\n" << result.err;
        if (!command.output.empty()) write(command.output, result.out);
        const auto named = std::find(words.begin(), words.end(), "-o");
        if (named != words.end() && (named + 1)->find('#') == std::string::npos) {
            EXPECT_TRUE(exists(*(named + 1))) << command.where << ": " << command.text;
        }
    }

    std::set<std::string> m_done;  // the same command in a table and in its scene is run once
    void expectWorkOnce(const std::vector<Command>& commands, bool withData) {
        for (const Command& command : commands)
            if (needsData(command) == withData && !needsPython(command) && m_done.insert(command.text).second)
                expectWorks(command);
    }
};

TEST_F(Documents, EveryCommandOfAPageAndASceneWorks) {
    std::vector<std::string> strange;
    for (const std::string& page : pages()) expectWorkOnce(commandsOfPage(page, strange), false);
    for (const std::string& scene : filesOf("examples/scenes", ".toml")) {
        const std::vector<Command> commands = commandsOfScene(scene);
        EXPECT_FALSE(commands.empty()) << scene << " does not say how it is rendered";
        expectWorkOnce(commands, false);
    }
    EXPECT_GT(m_done.size(), 15U) << "so few were found?";
    for (const std::string& line : strange)
        EXPECT_TRUE(std::any_of(kRunElsewhere.begin(), kRunElsewhere.end(),
                                [&](const auto& known) { return line.find(": " + known.first) != std::string::npos; }))
            << line << "\nis no command of Scrim's, nor listed with what runs it";
}

TEST_F(Documents, EveryCommandThatReadsAScanWorks) {
    SCRIM_NEEDS_DATA("scan/bonsai_256.nrrd");
    std::vector<std::string> strange;
    for (const std::string& page : pages()) expectWorkOnce(commandsOfPage(page, strange), true);
    for (const std::string& scene : filesOf("examples/scenes", ".toml")) expectWorkOnce(commandsOfScene(scene), true);
    EXPECT_FALSE(m_done.empty());
}

TEST_F(Documents, CommandsOfThePaperAreRead) {
    for (const std::string& scene : filesOf("examples/paper", ".toml"))
        for (const Command& command : commandsOfScene(scene)) {
            // The pictures are rendered by the tests of the figures; here their commands are planned.
            if (needsData(command) && !fs::exists(dataFolder())) continue;
            std::vector<std::string> words{"plan"};
            for (std::size_t i = 1; i < command.words.size(); ++i) {
                const std::string& word = command.words[i];
                if (word == "-o" || word == "--preview")
                    ++i;
                else
                    words.push_back(word);
            }
            const ProgramResult result = run(words, {.environment = {{"SCRIM_DATA", dataFolder()}}});
            EXPECT_EQ(result.status, 0) << command.where << ": " << command.text << "\n" << result.err;
        }
}

}  // namespace
}  // namespace scrim::test
