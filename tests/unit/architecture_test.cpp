// SPDX-License-Identifier: Apache-2.0
// The house rules of design/architecture.md and design/style.md that a program can check: who may include whom, how
// long files get, and what library code never does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#ifndef SCRIM_SOURCE_DIR
#error "define SCRIM_SOURCE_DIR as the path of the repository, as a string"
#endif

namespace scrim::test {
namespace {

// From the bottom up: a file includes its own folder and those before it. The last one is no folder: it is the header
// that includes all that is public.
const std::vector<std::string> kLayers{"base",  "geometry", "image",  "solid", "volume", "guard",
                                       "scene", "engine",   "verify", "shot",  "study",  "scrim.h"};

// The rooms of the engine, likewise. Files of the engine itself stand above all of them; what is compiled anew for
// every instruction set stands below.
const std::vector<std::string> kRooms{"simd-inl.h", "model", "cells", "lamps", "passes",    "solve",
                                      "splat",      "light", "shade", "balls", "composite", "plan"};

constexpr int kMostLines = 600, kManyLines = 400, kMedianLines = 150;

struct SourceFile {
    std::string path;    // below the repository
    std::string folder;  // of the library's files: the layer
    std::string text;
    std::string code;  // without comments and string literals

    bool header() const { return path.ends_with(".h"); }
    int lines() const { return static_cast<int>(std::count(text.begin(), text.end(), '\n')); }
};

// Comments, texts and characters become blanks; lines stay.
std::string withoutComments(const std::string& text) {
    std::string out = text;
    const auto blank = [&](std::size_t from, std::size_t to) {
        for (std::size_t i = from; i < std::min(to, out.size()); ++i)
            if (out[i] != '\n') out[i] = ' ';
        return to;
    };
    // The place after what begins at `from` and ends with `end`; the end of the text where it does not.
    const auto after = [&](const std::string& end, std::size_t from) {
        const auto at = text.find(end, from);
        return at == std::string::npos ? text.size() : at + end.size();
    };
    // An apostrophe within a number separates digits.
    const auto digitBefore = [&](std::size_t i) {
        return i > 0 && std::isxdigit(static_cast<unsigned char>(text[i - 1]));
    };
    for (std::size_t i = 0; i < text.size();) {
        const std::string two = text.substr(i, 2);
        if (two == "//") {
            i = blank(i, std::min(text.find('\n', i), text.size()));
        } else if (two == "/*") {
            i = blank(i, after("*/", i + 2));
        } else if (two == "R\"") {
            const std::string mark = text.substr(i + 2, text.find('(', i) - i - 2);
            i = blank(i, after(")" + mark + "\"", i));
        } else if (text[i] == '"' || (text[i] == '\'' && !digitBefore(i))) {
            std::size_t end = i + 1;
            while (end < text.size() && text[end] != text[i] && text[end] != '\n') end += text[end] == '\\' ? 2 : 1;
            i = blank(i, end + 1);
        } else {
            ++i;
        }
    }
    return out;
}

std::vector<SourceFile> filesBelow(const std::string& folder) {
    namespace fs = std::filesystem;
    const fs::path root(SCRIM_SOURCE_DIR);
    std::vector<SourceFile> files;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
        const std::string extension = entry.path().extension().string();
        if (!entry.is_regular_file() || (extension != ".h" && extension != ".cpp" && extension != ".c")) continue;
        std::ifstream in(entry.path());
        std::stringstream text;
        text << in.rdbuf();
        const fs::path below = fs::relative(entry.path(), root / folder);
        SourceFile file{fs::relative(entry.path(), root).string(), below.begin()->string(), text.str(), {}};
        file.code = withoutComments(file.text);
        files.push_back(std::move(file));
    }
    std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
    return files;
}

const std::vector<SourceFile>& library() {
    static const std::vector<SourceFile> files = filesBelow("src/scrim");
    return files;
}

// What stands behind #include on each line that has one, with its quotes or angle brackets.
std::vector<std::string> allIncludes(const SourceFile& file) {
    std::vector<std::string> names;
    std::istringstream in(file.text);
    for (std::string line; std::getline(in, line);) {
        std::istringstream words(line);
        std::string first, second;
        words >> first;
        if (first == "#") words >> second;
        if (first + second != "#include") continue;
        std::string name;
        words >> name;
        names.push_back(name);
    }
    return names;
}

// "splat/kernel.h" for every #include of ours, however it is quoted.
std::vector<std::string> ourIncludes(const SourceFile& file) {
    std::vector<std::string> names;
    for (const std::string& name : allIncludes(file))
        if (name.size() > 8 && name.compare(1, 6, "scrim/") == 0) names.push_back(name.substr(7, name.size() - 8));
    return names;
}

std::size_t layerOf(const std::string& folder) {
    return static_cast<std::size_t>(std::find(kLayers.begin(), kLayers.end(), folder) - kLayers.begin());
}

std::string folderOf(const std::string& include) {
    const auto slash = include.find('/');
    return slash == std::string::npos ? "" : include.substr(0, slash);
}

bool partOfName(char c) {
    return c == '_' || std::isalnum(static_cast<unsigned char>(c));
}

// The lines of `code` that hold `name` as a whole name (blanks count as they are), as "path:line". `call`: only where
// an opening bracket follows.
std::vector<std::string> linesWith(const SourceFile& file, const std::string& name, bool call) {
    std::vector<std::string> found;
    for (auto at = file.code.find(name); at != std::string::npos; at = file.code.find(name, at + 1)) {
        std::size_t end = at + name.size();
        if (at > 0 && partOfName(file.code[at - 1])) continue;
        if (end < file.code.size() && partOfName(file.code[end])) continue;
        while (call && end < file.code.size() && file.code[end] == ' ') ++end;
        if (call && (end >= file.code.size() || file.code[end] != '(')) continue;
        const auto line = 1 + std::count(file.code.begin(), file.code.begin() + static_cast<std::ptrdiff_t>(at), '\n');
        found.push_back(file.path + ":" + std::to_string(line) + ": " + name);
    }
    return found;
}

TEST(Architecture, HasFilesToLookAt) {
    EXPECT_GT(library().size(), 80u) << SCRIM_SOURCE_DIR;
    std::size_t includes = 0;
    for (const SourceFile& file : library()) includes += ourIncludes(file).size();
    EXPECT_GT(includes, 200u);
}

TEST(Architecture, CommentsAndTextsAreNotTakenForCode) {
    EXPECT_EQ(withoutComments("a; // exit(1)\nb /* printf( */ c"), "a;           \nb               c");
    EXPECT_EQ(withoutComments("f(\"exit(\\\"1\", 'x', '\"', 1'000);"), "f(          ,    ,    , 1'000);");
    EXPECT_EQ(withoutComments("R\"re(\"exit(\")re\" + a"), "                 + a");
}

TEST(Layers, AreKnownFoldersOnly) {
    for (const SourceFile& file : library()) EXPECT_LT(layerOf(file.folder), kLayers.size()) << file.path;
}

TEST(Layers, IncludeNothingFromAbove) {
    for (const SourceFile& file : library())
        for (const std::string& include : ourIncludes(file)) {
            const std::string folder = folderOf(include);
            ASSERT_LT(layerOf(folder), kLayers.size()) << file.path << " includes scrim/" << include;
            EXPECT_LE(layerOf(folder), layerOf(file.folder))
                << file.path << " (" << file.folder << ") includes scrim/" << include << ", which stands above it";
        }
}

// kRooms.size(): a file of the engine itself.
std::size_t roomOf(const std::string& belowEngine) {
    const std::string folder = folderOf(belowEngine), room = folder.empty() ? belowEngine : folder;
    return static_cast<std::size_t>(std::find(kRooms.begin(), kRooms.end(), room) - kRooms.begin());
}

TEST(Rooms, OfTheEngineIncludeNothingFromAbove) {
    const std::string engine = "engine/", source = "src/scrim/engine/";
    std::size_t across = 0;
    for (const SourceFile& file : library()) {
        if (!file.path.starts_with(source)) continue;
        const std::string own = file.path.substr(source.size());
        if (!folderOf(own).empty()) {
            ASSERT_LT(roomOf(own), kRooms.size()) << file.path << ": no room that is known";
        }
        for (const std::string& include : ourIncludes(file)) {
            if (!include.starts_with(engine)) continue;
            const std::size_t there = roomOf(include.substr(engine.size()));
            EXPECT_LE(there, roomOf(own)) << file.path << " includes scrim/" << include << ", which stands above it";
            across += there < roomOf(own) ? 1 : 0;
        }
    }
    EXPECT_GT(across, 50u);
}

// Ours are included as <scrim/...>: the only other form would escape the test above.
TEST(Layers, AreNamedInEveryInclude) {
    for (const SourceFile& file : library())
        for (const std::string& name : allIncludes(file))
            EXPECT_TRUE(name.starts_with('<')) << file.path << " includes " << name;
}

TEST(PlugIns, IncludeTheSourceInterfaceOnly) {
    const std::vector<SourceFile> files = filesBelow("plugins/sources");
    EXPECT_FALSE(files.empty());
    for (const SourceFile& file : files)
        for (const std::string& include : ourIncludes(file)) EXPECT_EQ(include, "volume/scrim_source.h") << file.path;
}

TEST(Program, IncludesHeadersThatExist) {
    for (const SourceFile& file : filesBelow("src/cli"))
        for (const std::string& include : ourIncludes(file))
            EXPECT_TRUE(std::filesystem::exists(std::string(SCRIM_SOURCE_DIR) + "/src/scrim/" + include))
                << file.path << " includes scrim/" << include;
}

TEST(Files, AreShort) {
    std::vector<int> lines;
    std::string many;
    for (const SourceFile& file : library()) {
        lines.push_back(file.lines());
        EXPECT_LE(file.lines(), kMostLines) << file.path << ": split it, by idea";
        if (file.lines() > kManyLines) many += " " + file.path + " (" + std::to_string(file.lines()) + ")";
    }
    std::nth_element(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(lines.size() / 2), lines.end());
    const int median = lines[lines.size() / 2];
    RecordProperty("median", median);
    EXPECT_LE(median, kMedianLines);
    if (!many.empty()) std::cout << "over " << kManyLines << " lines:" << many << "\n";
}

TEST(Files, BeginWithTheLicence) {
    std::vector<SourceFile> files = library();
    for (const char* folder : {"src/cli", "plugins", "tests"}) {
        const std::vector<SourceFile> more = filesBelow(folder);
        files.insert(files.end(), more.begin(), more.end());
    }
    for (const SourceFile& file : files)
        EXPECT_TRUE(file.text.starts_with("// SPDX-License-Identifier: Apache-2.0\n") ||
                    file.text.starts_with("/* SPDX-License-Identifier: Apache-2.0"))
            << file.path;
}

TEST(Headers, AreGuardedByPragmaOnce) {
    for (const SourceFile& file : library())
        if (file.header()) {
            // The plug-in interface is plain C, and guards itself as C does; what is compiled anew for every
            // instruction set has Highway's guard.
            const auto has = [&](const char* text) { return file.code.find(text) != std::string::npos; };
            const bool guarded = has("#pragma once") || has("#ifndef SCRIM_") || has("HWY_TARGET_TOGGLE");
            EXPECT_TRUE(guarded) << file.path;
        }
}

TEST(Headers, OpenNoNamespaces) {
    for (const SourceFile& file : library())
        if (file.header()) {
            for (const std::string& line : linesWith(file, "using namespace", false)) ADD_FAILURE() << line;
        }
}

// "The library throws, never prints, never exits": output goes through sinks, and only `main` ends a program.
TEST(Library, NeitherPrintsNorExits) {
    const auto forbid = [](const std::vector<std::string>& names, bool call) {
        for (const SourceFile& file : library())
            for (const std::string& name : names)
                for (const std::string& line : linesWith(file, name, call)) ADD_FAILURE() << line;
    };
    forbid({"cout", "cerr", "clog"}, false);
    forbid({"printf", "fprintf", "vprintf", "puts", "fputs", "putchar", "perror", "print", "println"}, true);
    forbid({"exit", "_exit", "_Exit", "quick_exit", "abort", "terminate"}, true);
}

TEST(Library, PrintingAndExitingWouldBeFound) {
    SourceFile file{"x.cpp", "base", "", "a.exited(1); exit_now(); my_exit(2);\n  std::cout << 1; exit (3);\n"};
    EXPECT_EQ(linesWith(file, "exit", true), std::vector<std::string>{"x.cpp:2: exit"});
    EXPECT_EQ(linesWith(file, "cout", false), std::vector<std::string>{"x.cpp:2: cout"});
}

// The paths in the first column of the table below `heading` in LIBRARY.md.
std::vector<std::string> stopsBelow(const std::string& heading) {
    std::ifstream in(std::string(SCRIM_SOURCE_DIR) + "/examples/LIBRARY.md");
    std::vector<std::string> stops;
    bool below = false;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("#")) below = line == heading;
        if (below && line.starts_with("| `")) stops.push_back(line.substr(3, line.find('`', 3) - 3));
    }
    return stops;
}

// What the unit of a header includes of ours: the header, and the source files that implement it, whose first include
// it is.
std::vector<std::string> includesOfUnit(const std::string& header) {
    std::vector<std::string> names;
    for (const SourceFile& file : library()) {
        const std::vector<std::string> ours = ourIncludes(file);
        const bool implements = !file.header() && !ours.empty() && ours.front() == header;
        if (file.path == "src/scrim/" + header || implements) names.insert(names.end(), ours.begin(), ours.end());
    }
    return names;
}

// Whoever leaves out a stop breaks the chain, unless the two beside it know each other anyway.
TEST(Ways, OfAVoxelPassFilesThatKnowOneAnother) {
    constexpr std::size_t kMostStops = 30;
    const std::vector<std::string> stops = stopsBelow("### The way of a voxel");
    EXPECT_GT(stops.size(), kMostStops / 2);
    EXPECT_LE(stops.size(), kMostStops);
    std::vector<std::vector<std::string>> includes;
    for (const std::string& stop : stops) includes.push_back(includesOfUnit(stop));
    const auto knows = [&](std::size_t one, std::size_t other) {
        return std::find(includes[one].begin(), includes[one].end(), stops[other]) != includes[one].end();
    };
    for (std::size_t i = 0; i < stops.size(); ++i) {
        EXPECT_TRUE(std::filesystem::exists(std::string(SCRIM_SOURCE_DIR) + "/src/scrim/" + stops[i])) << stops[i];
        bool known = i == 0;
        for (std::size_t earlier = 0; earlier < i; ++earlier) known |= knows(i, earlier) || knows(earlier, i);
        EXPECT_TRUE(known) << stops[i] << " neither includes a stop before it nor is included by one";
    }
}

TEST(Ways, OfALightPassFourTypes) {
    for (const char* type : {"Light", "PlannedLight", "SheetLight", "Incidence"}) {
        std::size_t definitions = 0;
        for (const SourceFile& file : library())
            if (file.header()) definitions += linesWith(file, "struct " + std::string(type) + " {", false).size();
        EXPECT_EQ(definitions, 1u) << type;
    }
}

// A key's files are its table, the scene's member, and those that read or check it by name. Names that several tables
// share are left out, since a use does not tell which is meant.
TEST(Ways, OfAKeyPassFewFiles) {
    constexpr std::size_t kMostByName = 3;
    // How readers name a table: `k`, `keys`, or keysOf<...>().
    const std::vector<std::string> before{"k.", "keys.", "()."};
    const std::regex definition(R"(const Key& (\w+) =)");
    std::map<std::string, std::size_t> keys;
    for (const SourceFile& file : library())
        for (std::sregex_iterator i(file.code.begin(), file.code.end(), definition), end; i != end; ++i)
            ++keys[(*i)[1].str()];
    std::size_t read = 0;
    for (const auto& [key, count] : keys) {
        if (count > 1) continue;
        std::string files;
        std::size_t users = 0;
        for (const SourceFile& file : library()) {
            const bool uses = std::any_of(before.begin(), before.end(), [&](const std::string& table) {
                return !linesWith(file, table + key, false).empty();
            });
            if (!uses) continue;
            ++users;
            files += " " + file.path;
        }
        EXPECT_LE(users, kMostByName) << key << ":" << files;
        read += users > 0 ? 1 : 0;
    }
    EXPECT_GT(read, 30u);
}

}  // namespace
}  // namespace scrim::test
