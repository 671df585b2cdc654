// SPDX-License-Identifier: Apache-2.0
// Crops of one picture, rendered by themselves, joined to the file that a render of the whole would have written.
#pragma once

#include <scrim/image/image.h>

#include <functional>
#include <string>
#include <vector>

namespace scrim {

struct MergedExr {
    PixelWindow window;                ///< the data window that was written
    bool deep = false;                 ///< is it a deep picture?
    bool lossyTwice = false;           ///< what the compression of the tiles lost is lost of them once more
    std::string notFinite;             ///< the first tile with values that are infinite or no numbers; "": none has any
    std::vector<std::string> leftOut;  ///< attributes that say something of each tile and nothing of the whole
};

/// Joins the flat or deep pictures `tiles` to `path`, bit by bit: values are neither converted nor added. What a tile
/// holds is said by its attribute scrim:crop; without it, it is the data window, or all of the picture where Scrim
/// wrote the file. Tiles may overlap where their pixels are the same. The data window is the smallest one around those
/// of all tiles that are not empty, so it is that of the whole render. Attributes are those of the tiles, which must
/// agree; scrim:plan and scrim:stats become lists, in the order of `tiles`. `compression`: as ExrOptions has it, "" is
/// that of the tiles. `checkpoint` is called now and then, and may throw. The pictures are read in stripes, so memory
/// does not grow with the height. Throws Error: of kind `input` where a tile cannot be read, is missing, or does not
/// fit the others; `usage`; `output`.
MergedExr mergeExr(const std::vector<std::string>& tiles, const std::string& path, const std::string& compression = "",
                   const std::function<void()>& checkpoint = {});

}  // namespace scrim
