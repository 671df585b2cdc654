// SPDX-License-Identifier: Apache-2.0
// Internal: `readTexture` (texture.h) in two steps, for code that reads the file in another process.
#pragma once

#include <scrim/image/picture_module.h>
#include <scrim/image/texture.h>

#include <memory>
#include <string>

namespace scrim {

/// Throws Error(input) where there is no regular file.
void checkPictureFile(const std::string& path);

/// The texture that `readTexture` makes from the pixels it read; throws as that does.
std::shared_ptr<const Texture> textureOf(FilePicture pixels, const std::string& path, const std::string& colorspace,
                                         const ColourConfig& colour, const MessageSink& messages);

}  // namespace scrim
