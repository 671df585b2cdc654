// SPDX-License-Identifier: Apache-2.0
// Whether a picture file is all there: a disk that was full, a copy that was broken off or a machine that went down
// leaves files that begin as they should. Only the places where pieces of the file begin and end are looked at, by code
// that trusts none of them, so that whatever lies there can be asked about, and cheaply.
#pragma once

#include <optional>
#include <string>

namespace scrim {

/// Whether `path` is an OpenEXR file, of any kind, with all its pixels. False where there is no such file.
bool isWholeExr(const std::string& path);

/// The same of PNG, JPEG and OpenEXR files; nothing where the file is of another format.
std::optional<bool> isWholePicture(const std::string& path);

}  // namespace scrim
