// SPDX-License-Identifier: Apache-2.0
// The photometric files that were made for tests and examples.
#pragma once

#include <scrim/image/light_profile.h>
#include <scrim/scene/light.h>

#include <memory>
#include <string>

#include <gtest/gtest.h>

namespace scrim::test {

/// "downlight": the cosine law, the same all around, nothing upwards. "batwing": two wings, mirrored twice; with
/// TILT=INCLUDE. "wall": to its right alone, and a little upwards.
inline FilePhotometry photometryOf(const std::string& name) {
    return readPhotometry(SCRIM_SOURCE_DIR "/examples/scenes/luminaires/" + name + ".ies");
}

inline Luminaire luminaireOf(const std::string& name) {
    const FilePhotometry file = photometryOf(name);
    EXPECT_EQ(file.problem, "");
    return {"", "", std::make_shared<const LightProfile>(file)};
}

}  // namespace scrim::test
