// SPDX-License-Identifier: Apache-2.0
// Scenes for the tests of the reader: a small complete one, and what reading one says.
#pragma once

#include <scrim/base/error.h>
#include <scrim/scene/scene_reader.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

namespace scrim::test {

inline const ColourConfig& ownColours() {
    static const ColourConfig config = [] {
        ::unsetenv("OCIO");
        return ColourConfig::open("");
    }();
    return config;
}

inline Scene read(const std::string& text, const std::vector<std::string>& overrides = {}, double frame = 1) {
    return readScene({"scene.toml", "/shots", text}, frame, overrides, ownColours());
}

inline std::string errorOf(const std::string& text, const std::vector<std::string>& overrides = {}, double frame = 1) {
    try {
        read(text, overrides, frame);
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::input);
        return error.what();
    }
    return "no error";
}

/// Three lines; what is added begins at line 4.
inline const std::string kCamera = "[camera]\nposition = [0, 0, 9]\ntarget = [0, 0, 0]\n";
/// Two lines.
inline const std::string kVolume = "[[volume]]\nfile = \"a.####.vdb\"\n";

}  // namespace scrim::test
