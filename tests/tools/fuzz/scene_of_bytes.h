// SPDX-License-Identifier: Apache-2.0
// Any bytes as a small scene: the choices that a user has, taken one after the other. Where the bytes end, all further
// choices are the plainest. The scene is text first, so that only what a user can write is ever rendered.
#pragma once

#include <scrim/scene/view_scene.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace scrim::fuzz {

struct ByteScene {
    std::string toml;
    ViewScene view;  ///< of `toml`, with fields and slides that are made of the bytes, too
};

/// Throws Error where the scene is refused.
ByteScene sceneOfBytes(const std::uint8_t* data, std::size_t size);

}  // namespace scrim::fuzz
