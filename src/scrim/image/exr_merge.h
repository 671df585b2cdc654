// SPDX-License-Identifier: Apache-2.0
// Joins crops of one picture that were rendered separately, to the file that a render of the whole would have written.
#pragma once

#include <scrim/image/image.h>

#include <functional>
#include <string>
#include <vector>

namespace scrim {

struct MergedExr {
    PixelWindow window;       ///< the data window that was written
    bool deep = false;        ///< the picture is deep
    bool lossyTwice = false;  ///< lossy compression was applied once for the tiles and once more for the result
    std::string notFinite;    ///< the first tile with infinite or NaN values; "": none
    std::vector<std::string> leftOut;  ///< attributes that describe each tile and not the whole
};

/// Joins the flat or deep pictures `tiles` to `path`, bit by bit: values are neither converted nor added. A tile's crop
/// is stated by its attribute scrim:crop; without it, the crop is the data window, or the whole picture where Scrim
/// wrote the file. Tiles may overlap where their pixels are equal. The data window is the smallest one around those of
/// all tiles that are not empty, so it equals that of a whole render. Attributes are those of the tiles, which must
/// agree; scrim:plan and scrim:stats become lists, in the order of `tiles`. `compression` is as in ExrOptions; "" means
/// that of the tiles. `checkpoint` is called now and then, and may throw. The pictures are read in stripes, so memory
/// does not grow with the height. Throws Error: of kind `input` where a tile cannot be read, is missing, or contradicts
/// the others; `usage`; `output`.
MergedExr mergeExr(const std::vector<std::string>& tiles, const std::string& path, const std::string& compression = "",
                   const std::function<void()>& checkpoint = {});

}  // namespace scrim
