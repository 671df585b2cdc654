// SPDX-License-Identifier: Apache-2.0
// Damage to files as disks, networks and attackers do it, and what may come of it.
#pragma once

#include "support/program_test.h"

#include <scrim/base/error.h>

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <random>
#include <string>

namespace scrim::test {

/// One kind of damage, at a random place.
inline std::string damaged(std::string bytes, std::mt19937& random) {
    const auto below = [&](std::size_t n) { return random() % n; };
    const auto put = [&](const auto value) {
        if (bytes.size() <= sizeof value) return;
        std::memcpy(bytes.data() + below(bytes.size() - sizeof value), &value, sizeof value);
    };
    const std::uint32_t lengths[] = {0xffffffff, 0x7fffffff, 0x80000000, 0x10000000, 0x00100000, 0};
    switch (below(7)) {
        case 0:
            return bytes.substr(0, below(bytes.size()));  // cut off
        case 1:
            return bytes.replace(below(bytes.size()), 512, std::string(512, '\0'));  // a sector lost
        case 2:
            return bytes.erase(below(bytes.size()), 1 + below(64));  // bytes lost
        case 3:
            return bytes.insert(below(bytes.size()), bytes.substr(below(bytes.size()), 64));  // bytes doubled
        case 4:
            put(lengths[below(6)]);
            break;  // a length
        case 5:
            put(std::uint64_t{lengths[below(6)]} << below(33));
            break;  // an offset
        default:
            for (int i = 0; i < 8; ++i) bytes[below(bytes.size())] = static_cast<char>(random());
    }
    return bytes;
}

/// How many files of a kind to damage: what SCRIM_FUZZ_FILES says, or else `files`; fewer with the address sanitizer,
/// under which a process takes several times as long.
inline int damagedFiles(int files, int sanitized) {
#ifdef SCRIM_ADDRESS_SANITIZED
    constexpr bool isSanitized = true;
#else
    constexpr bool isSanitized = false;
#endif
    const char* wanted = std::getenv("SCRIM_FUZZ_FILES");
    if (wanted != nullptr) return std::atoi(wanted);
    return isSanitized ? sanitized : files;
}

/// What became of damaged files that a guarded load was given.
struct Outcomes {
    int read = 0, refused = 0, crashed = 0;

    /// Holds an error against what it may be; it begins with `place`.
    void expectTold(const Error& error, const std::string& place) {
        const std::string text = error.what();
        EXPECT_TRUE(error.kind() == ErrorKind::input || error.kind() == ErrorKind::memory) << text;
        EXPECT_EQ(text.rfind(place + ": ", 0), 0u) << text;
        // A reader that does what the filter forbids would do so with good files, too.
        EXPECT_EQ(text.find("SIGSYS"), std::string::npos) << text;
        crashed += text.find("reading it crashed") != std::string::npos || text.find("stopped on it") != text.npos;
    }
    void print(const std::string& kind) const {
        std::cout << kind << ": " << read << " read, " << refused << " refused, " << crashed << " crashed\n";
    }
};

/// The program planned a scene with a damaged file in it, or said where the scene names it.
inline void expectPlannedOrLocated(const ProgramResult& result) {
    EXPECT_TRUE(result.status == 0 || result.status == 3) << result.status << ": " << result.err;
    if (result.status == 3) {
        EXPECT_EQ(result.lastErrorLine().rfind("scrim: error: scene.toml:", 0), 0u) << result.err;
    }
}

}  // namespace scrim::test
