// SPDX-License-Identifier: Apache-2.0
// Where programs look for their libraries: in places of their own, and never in the current folder, where a library may
// lie beside a downloaded scene.
#include "support/program_test.h"

#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <regex>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace scrim::test {
namespace {

using Libraries = ProgramTest;

std::string outputOf(const std::string& command) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
    std::string text;
    std::array<char, 4096> buffer{};
    while (pipe && std::fgets(buffer.data(), static_cast<int>(buffer.size()), pipe.get()) != nullptr)
        text += buffer.data();
    return text;
}

// Programs, libraries and plug-ins of this build.
std::vector<std::string> binaries() {
    const std::filesystem::path bin = std::filesystem::path(SCRIM_PROGRAM).parent_path();
    std::vector<std::string> all;
    const auto add = [&](const std::filesystem::path& folder) {
        for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
            if (entry.is_regular_file() && (folder == bin || entry.path().string().find(".so") != std::string::npos))
                all.push_back(entry.path().string());
    };
    add(bin);
    all.push_back(SCRIM_LOADER);
    add(std::filesystem::path(SCRIM_BUILT_SOURCES).parent_path().parent_path());
    return all;
}

TEST_F(Libraries, AreLookedForInFoldersOfTheirOwnAlone) {
    const std::vector<std::string> all = binaries();
    ASSERT_GT(all.size(), 5u);  // program, library, sources
    int paths = 0;
    for (const std::string& file : all) {
        const std::string dynamic = outputOf("readelf -d '" + file + "'");
        ASSERT_NE(dynamic.find("NEEDED"), std::string::npos) << file << ": readelf (package binutils) shows nothing";
        std::smatch found;
        if (!std::regex_search(dynamic, found, std::regex(R"(\((?:RUNPATH|RPATH)\).*\[(.*)\])"))) continue;
        ++paths;
        // Split at ':', an empty part (also the one after a last ':') means the current folder.
        const std::string path = found[1].str() + ":";
        for (std::size_t begin = 0; begin < path.size(); begin = path.find(':', begin) + 1) {
            const std::string part = path.substr(begin, path.find(':', begin) - begin);
            EXPECT_EQ(part.rfind("$ORIGIN/", 0), 0u) << file << " looks for libraries in '" << part << "'";
        }
    }
    EXPECT_GT(paths, 0);  // the program finds its library somehow
}

TEST_F(Libraries, OfTheCurrentFolderAreNotLoaded) {
    const std::string needed = outputOf("readelf -d '" SCRIM_PROGRAM "'");
    const std::regex name(R"(\(NEEDED\).*\[(.*)\])");
    int count = 0;
    for (std::sregex_iterator it(needed.begin(), needed.end(), name), end; it != end; ++it, ++count)
        write((*it)[1].str(), "no library at all");
    ASSERT_GT(count, 2);
    const ProgramResult result = run({"--version"});
    EXPECT_EQ(result.status, 0) << result.err;
}

}  // namespace
}  // namespace scrim::test
