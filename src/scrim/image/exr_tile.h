// SPDX-License-Identifier: Apache-2.0
// Internal to exr_merge.cpp: finds out which part of which picture an OpenEXR file holds, and
// whether several files belong together.
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
    PixelWindow data;  ///< the data window; empty where the file holds only the one pixel of an empty picture
    PixelWindow crop;  ///< the region that the file describes; pixels outside of `data` are 0
    std::optional<PixelWindow> picture;  ///< the picture that the crop is part of, where the file states it
};

/// Reads the header, and no pixels but the one of a picture that may be empty. Throws Error(input)
/// where that fails, or the file is incomplete.
ExrTile readExrTile(const std::string& path);

/// Throws Error(input) where the tiles belong to different pictures, or do not cover the picture.
/// There must be at least one.
void checkExrTiles(const std::vector<ExrTile>& tiles);

/// The header that all tiles share. Attributes that describe single tiles are left out, and their names are added to
/// `leftOut`. Throws Error(input) where tiles differ in an attribute that a picture has only once.
Imf::Header mergedExrHeader(const std::vector<ExrTile>& tiles, std::vector<std::string>& leftOut);

/// "64,0,128,36", as --crop takes it.
std::string cropText(const PixelWindow& window);

}  // namespace scrim
