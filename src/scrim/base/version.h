// SPDX-License-Identifier: Apache-2.0
// What Scrim is made of, for `scrim --version`, pictures' metadata and bug reports. The folders that hide a
// library say its version themselves (image/versions.h, volume/vdb_version.h).
#pragma once

#include <string>

namespace scrim {

/// "0.1.0".
std::string scrimVersion();

/// Of the oneTBB that runs the loops, at run time.
std::string tbbVersion();

/// Of the Highway this was compiled with.
std::string highwayVersion();

}  // namespace scrim
