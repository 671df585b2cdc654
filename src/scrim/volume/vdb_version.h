// SPDX-License-Identifier: Apache-2.0
// The version of OpenVDB and the files that it can read.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace scrim {

std::string openVdbVersion();

/// The newest version of the file format that it writes.
std::uint32_t vdbFileVersion();

/// The compressions that it was built with: "zip", "blosc". Files without compression are always read.
std::vector<std::string> vdbCodecs();

}  // namespace scrim
