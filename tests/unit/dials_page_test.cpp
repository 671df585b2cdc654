// SPDX-License-Identifier: Apache-2.0
// The page of dials says what the program does.
#include <scrim/scene/quality.h>

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

namespace scrim::test {
namespace {

TEST(DialsPage, ListsEveryDialAsTheTableHasIt) {
    std::ifstream file(SCRIM_SOURCE_DIR "/examples/DIALS.md");
    std::ostringstream text;
    text << file.rdbuf();
    for (const DialInfo& d : dialTable()) {
        const std::string row =
            "| `" + d.name + "` | " + d.unit + " | " + d.defaultText + " | " + d.allowed + " | " + d.meaning + " |";
        EXPECT_NE(text.str().find(row), std::string::npos) << row;
    }
}

}  // namespace
}  // namespace scrim::test
