// SPDX-License-Identifier: Apache-2.0
// Preview pictures: a render as it looks on a display, in a format that any program opens. The data
// itself is written as EXR.
#pragma once

#include <scrim/image/colour.h>
#include <scrim/image/image.h>
#include <scrim/image/preview_marks.h>

#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// How a preview shows a picture.
struct PreviewLook {
    std::string display, view;               ///< of the configuration; empty: the default
    double exposure = 0;                     ///< stops by which it is brighter
    std::optional<PreviewMarks> marks = {};  ///< drawn into it
};

/// Writes `working` (premultiplied, in the working space) through a view of a display, over black and opaque, as an
/// 8-bit RGB picture of the whole display window. It deliberately has no alpha: PNG would need display-encoded colour
/// divided by alpha, which overflows wherever a thin volume is bright. The extension chooses the format (".png",
/// ".jpg", ...). The file appears completely or not at all. Throws an Error of kind
/// `output`, `usage` for an empty display window, or `input` for an unknown view.
void writePreview(const std::string& path, const Image& working, const PixelWindow& displayWindow,
                  const ColourConfig& colour, const PreviewLook& look);

/// The bytes of an opaque picture file in the format of the extension of `name`. Throws
/// Error(output), which names the file `name`.
std::vector<unsigned char> pictureBytes(const std::string& name, const DisplayImage& picture);

}  // namespace scrim
