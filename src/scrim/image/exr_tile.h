// SPDX-License-Identifier: Apache-2.0
// Internal to exr_merge.cpp: which part of which picture an OpenEXR file holds, and whether several go together.
#pragma once

#include <scrim/image/image.h>

#include <OpenEXR/ImfHeader.h>

#include <optional>
#include <string>
#include <vector>

namespace scrim {

struct ExrTile {
    std::string path;
    Imf::Header header;
    bool deep = false;
    PixelWindow data;  ///< the data window; empty where the file holds nothing but its one empty pixel
    PixelWindow crop;  ///< what the file speaks of: 0 where it is beyond `data`
    std::optional<PixelWindow> picture;  ///< what the crop is a part of, where the file says so
};

/// Reads headers, and no pixels but the one of a picture that may be empty. Throws Error(input) where that fails, or
/// the file is not whole.
ExrTile readExrTile(const std::string& path);

/// Throws Error(input) where the tiles are of several pictures, or pixels of the picture are in none of them. There
/// must be one.
void checkExrTiles(const std::vector<ExrTile>& tiles);

/// The header that all of them share, without `leftOut` (whose names are added to it). Throws Error(input) where they
/// differ in what a picture has once.
Imf::Header mergedExrHeader(const std::vector<ExrTile>& tiles, std::vector<std::string>& leftOut);

/// "64,0,128,36", as --crop has it.
std::string cropText(const PixelWindow& window);

}  // namespace scrim
