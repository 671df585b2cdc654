// SPDX-License-Identifier: Apache-2.0
// Which OpenVDB this is, and which files it can read.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace scrim {

std::string openVdbVersion();

/// The newest version of the file format that it writes.
std::uint32_t vdbFileVersion();

/// The compressions it was built with: "zip", "blosc". Files without any are always read.
std::vector<std::string> vdbCodecs();

}  // namespace scrim
