// SPDX-License-Identifier: Apache-2.0
// Where the real volumes are that some tests read: they are too large, and not ours, to lie beside the tests.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#ifndef SCRIM_REPOSITORY
#error "define SCRIM_REPOSITORY as the path of the repository, as a string"
#endif

namespace scrim::test {

/// The folder $SCRIM_DATA, else ../shared/data beside the repository.
inline std::string dataFolder() {
    const char* folder = std::getenv("SCRIM_DATA");
    return folder != nullptr && *folder != '\0' ? folder : std::string(SCRIM_REPOSITORY) + "/../shared/data";
}

inline std::string dataFile(const std::string& name) {
    return dataFolder() + "/" + name;
}

}  // namespace scrim::test

/// Leaves the test, saying why, where the file `name` of the data folder is absent.
#define SCRIM_NEEDS_DATA(name)                                 \
    if (!std::filesystem::exists(scrim::test::dataFile(name))) \
    GTEST_SKIP() << "no " << scrim::test::dataFile(name) << "; SCRIM_DATA names the folder of test volumes"
