// SPDX-License-Identifier: Apache-2.0
// As gtest's own, but it is also the child in which volumes are read: that is the running program itself, started
// with a hidden command.
#include <cli/internal_load.h>

#include <gtest/gtest.h>

#include <string>

int main(int argc, char** argv) {
    if (argc > 1 && std::string(argv[1]) == scrim::cli::kInternalLoad)
        return scrim::cli::internalLoad({argv + 2, argv + argc});
    ::testing::InitGoogleTest(&argc, argv);
    return RUN_ALL_TESTS();
}
