// SPDX-License-Identifier: Apache-2.0
// Errors are part of the interface: tests assert their kind and their text.
#pragma once

#include <scrim/base/error.h>

#include <string>

#include <gtest/gtest.h>

namespace scrim::test {

/// Runs `task`, which must throw a scrim::Error of `kind`, and returns its text ("" where it does not throw).
template <typename Task>
std::string errorOf(ErrorKind kind, const Task& task) {
    try {
        task();
    } catch (const Error& error) {
        EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(kind)) << error.what();
        return error.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
}

}  // namespace scrim::test
