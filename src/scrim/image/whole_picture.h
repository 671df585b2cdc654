// SPDX-License-Identifier: Apache-2.0
// Tests whether a picture file is complete: a full disk, an interrupted copy or a machine that went down leaves files
// that begin correctly. Only the places where pieces of the file begin and end are examined, by code that trusts none
// of their contents, so that the test is cheap and safe for any file.
#pragma once

#include <optional>
#include <string>

namespace scrim {

/// True if `path` is an OpenEXR file of any kind with all its pixels. False where there is no such file.
bool isWholeExr(const std::string& path);

/// The same for PNG, JPEG and OpenEXR files; no value where the file has another format.
std::optional<bool> isWholePicture(const std::string& path);

}  // namespace scrim
