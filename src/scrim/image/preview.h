// SPDX-License-Identifier: Apache-2.0
// Preview pictures: what a render looks like on a display, in a format anything opens. Apart from EXR, which
// carries the data.
#pragma once

#include <scrim/image/colour.h>
#include <scrim/image/image.h>

#include <string>
#include <vector>

namespace scrim {

/// Writes `working` (premultiplied, in the working space) through a view of a display, over black and opaque,
/// as an 8-bit RGB picture of the whole display window. It has no alpha, on purpose: dividing display-encoded
/// colour by alpha, which PNG would need, overflows wherever a thin volume is bright. The extension chooses
/// the format (".png", ".jpg", ...). `exposure`: stops by which it is brighter. An empty `display` or `view` stands for
/// the default. The file appears whole or not at all. Throws an Error of kind `output`, `usage` for an empty display
/// window, or `input` for an unknown view.
void writePreview(const std::string& path, const Image& working, const PixelWindow& displayWindow,
                  const ColourConfig& colour, const std::string& display, const std::string& view, double exposure = 0);

/// The bytes of a picture file, opaque, in the format that the extension of `name` stands for. Throws Error(output),
/// which calls it `name`.
std::vector<unsigned char> pictureBytes(const std::string& name, const DisplayImage& picture);

}  // namespace scrim
