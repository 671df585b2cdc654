// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/file_identity.h>

#include "support/temp_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace scrim {
namespace {

class Identity : public ::testing::Test {
  protected:
    void SetUp() override {
        std::ofstream(m_folder.file("a")) << "a";
        std::ofstream(m_folder.file("b")) << "b";
        std::filesystem::create_directory(m_folder.file("inner"));
        std::filesystem::create_directory_symlink("inner", m_folder.file("link"));
    }
    FileIdentity of(const std::string& name) const { return identityOf(m_folder.file(name)); }

    test::TempFolder m_folder;
};

TEST_F(Identity, IsOneForAllNamesOfAFile) {
    std::filesystem::create_symlink("a", m_folder.file("soft"));
    std::filesystem::create_hard_link(m_folder.file("a"), m_folder.file("hard"));
    for (const char* name : {"./a", "inner/../a", "link/../a", "soft", "hard"}) EXPECT_EQ(of(name), of("a")) << name;
    EXPECT_NE(of("a"), of("b"));
}

TEST_F(Identity, IsOneForAllNamesOfAFileThatIsNotThere) {
    EXPECT_EQ(of("inner/new"), of("link/new"));
    EXPECT_EQ(of("inner/new/deep/x"), of("link/./new/deep/../deep/x"));
    std::filesystem::create_symlink("link/new", m_folder.file("dangling"));
    EXPECT_EQ(of("inner/new"), of("dangling"));
    EXPECT_NE(of("inner/new"), of("new"));
    EXPECT_NE(of("inner/new"), of("inner"));
    EXPECT_NE(of("inner/new"), of("inner/other"));
}

}  // namespace
}  // namespace scrim
