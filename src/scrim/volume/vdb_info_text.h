// SPDX-License-Identifier: Apache-2.0
// VdbFileInfo as JSON, for other processes and for programs that ask for it. It is a separate file
// because the JSON library is slow to compile.
#pragma once

#include <scrim/volume/vdb_info.h>

#include <string>

namespace scrim {

/// All of `info` as one JSON object. Bytes that are not UTF-8 are replaced.
std::string toJson(const VdbFileInfo& info);

/// Parses the output of `toJson`. Throws Error(input) for any other text.
VdbFileInfo vdbFileInfoFromJson(const std::string& text);

}  // namespace scrim
