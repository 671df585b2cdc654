// SPDX-License-Identifier: Apache-2.0
// Reads OpenEXR files, for tests and tools that examine rendered pictures. Slides and other
// textures are read elsewhere, in any format.
#pragma once

#include <scrim/image/image.h>

#include <map>
#include <string>
#include <vector>

namespace scrim {

/// R, G, B and A of the first part of a flat file, as floats over its data window. A missing colour
/// channel reads as 0, a missing A as 1. Throws an Error of kind `input`.
Image readExr(const std::string& path);

/// One channel of the first part of a flat file: one float per pixel over its data window, rows
/// from top to bottom. Throws an Error of kind `input`, also where there is no such channel.
std::vector<float> readExrChannel(const std::string& path, const std::string& channel);

/// The header of the first part as text, by attribute name. Numbers are printed with as many digits as they need,
/// matrices row by row as in the file, windows as half-open "x0 y0 x1 y1", channels as "A:half B:half"; an attribute
/// without a text form reads "(type)". Throws an Error of kind `input`.
std::map<std::string, std::string> readExrAttributes(const std::string& path);

}  // namespace scrim
