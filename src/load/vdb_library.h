// SPDX-License-Identifier: Apache-2.0
// OpenVDB, which this program loads only for files that need it: binding its 67,000 names takes longer than reading a
// small file does.
#pragma once

#include <string>

namespace scrim::load {

/// Loads the module `scrim-load-vdb.so` (scrim/volume/vdb_module.h) beside this program. Does nothing where that was
/// done or tried before. Where it fails, vdbModule() throws the reason. Only for a program without active threads that
/// may open files.
void loadOpenVdb() noexcept;

/// True after loadOpenVdb().
bool triedOpenVdb();

}  // namespace scrim::load
