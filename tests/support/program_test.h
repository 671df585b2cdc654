// SPDX-License-Identifier: Apache-2.0
// A folder with a small asset and a scene, and the program to run there: what all tests of the command line
// share.
#pragma once

#include "support/run_program.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace scrim::test {

/// Line 1 to 5 of the scenes; 32 x 24 pixels.
inline const std::string kCamera =
    "[camera]\nposition = [0, 0, 40]\ntarget = [0, 0, 0]\nfov = 35\nresolution = [32, 24]\n";
inline const std::string kVolume = "[[volume]]\nfile = \"smoke.vdb\"\n";  // line 6 and 7
inline const std::string kLight = "[[light]]\nname = \"key\"\ntype = \"distant\"\ndirection = [-1, -1, -1]\n";

class ProgramTest : public ::testing::Test {
  protected:
    void SetUp() override {
        makeVdb(file("smoke.vdb"), {{.voxels = box({-6, -6, -6}, {6, 6, 6}, 0.2)}});
        write("scene.toml", kCamera + kVolume + kLight);
    }

    std::string file(const std::string& name) const { return m_folder.file(name); }
    static bool contains(const std::string& text, const std::string& part) { return text.find(part) != text.npos; }
    void write(const std::string& name, const std::string& text) const { writeBytes(file(name), text); }
    bool exists(const std::string& name) const { return std::filesystem::exists(file(name)); }

    ProgramResult run(const std::vector<std::string>& arguments, const ProgramOptions& options = {}) const {
        return runProgram(m_folder.path(), arguments, options);
    }

    /// Runs what must succeed.
    ProgramResult runWell(const std::vector<std::string>& arguments, const ProgramOptions& options = {}) const {
        ProgramResult result = run(arguments, options);
        EXPECT_EQ(result.status, 0) << result.err;
        return result;
    }

    std::set<std::string> listing() const {
        std::set<std::string> names;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(m_folder.path()))
            names.insert(entry.path().lexically_relative(m_folder.path()).string());
        return names;
    }

    /// Runs what must fail: with this exit status, with "scrim: error: " and `reason` as the only line on
    /// stderr, and without a new file, half or whole.
    void expectFailure(const std::vector<std::string>& arguments, int status, const std::string& reason,
                       const ProgramOptions& options = {}) const {
        const std::set<std::string> before = listing();
        const ProgramResult result = run(arguments, options);
        EXPECT_EQ(result.status, status) << "signal " << result.signal << "\n" << result.err;
        EXPECT_EQ(result.err, "scrim: error: " + reason + "\n");
        EXPECT_EQ(result.out, "");
        EXPECT_EQ(listing(), before);
    }

    TempFolder m_folder;
};

}  // namespace scrim::test
