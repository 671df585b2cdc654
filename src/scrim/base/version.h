// SPDX-License-Identifier: Apache-2.0
// The versions of Scrim and its parts, for `scrim --version`, pictures' metadata and bug reports. The folders that hide
// a library state its version themselves (image/versions.h, volume/vdb_version.h).
#pragma once

#include <string>

namespace scrim {

/// "0.1.0".
std::string scrimVersion();

/// The version of the oneTBB library that is loaded.
std::string tbbVersion();

/// The version of Highway that this was compiled with.
std::string highwayVersion();

}  // namespace scrim
