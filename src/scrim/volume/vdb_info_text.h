// SPDX-License-Identifier: Apache-2.0
// VdbFileInfo as JSON: between processes, and for programs that ask for it. Apart, because the JSON library
// is slow to compile.
#pragma once

#include <scrim/volume/vdb_info.h>

#include <string>

namespace scrim {

/// All of `info` as one JSON object. Bytes that are not UTF-8 are replaced.
std::string toJson(const VdbFileInfo& info);

/// The reverse. Throws Error(input) where `text` does not come from `toJson`.
VdbFileInfo vdbFileInfoFromJson(const std::string& text);

}  // namespace scrim
