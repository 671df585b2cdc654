// SPDX-License-Identifier: Apache-2.0
// Finds the files that belong to this library: modules, volume sources and the program that reads
// volumes. It works in the build tree as well as after installation, wherever that was moved.
#pragma once

#include <string>

namespace scrim {

/// The folder of the shared object (or program) that contains this code; "" where the system cannot tell.
std::string libraryFolder();

/// "scrim/NAME" in that folder.
std::string besideLibrary(const std::string& name);

/// The path of the module `file` in that folder. Throws Error(render) where it is not installed;
/// `what` says in the message what the module does: "reads volumes".
std::string installedModule(const std::string& file, const std::string& what);

/// The function `symbol` of that module, which is loaded and never unloaded. Throws Error(render).
void* moduleFunction(const std::string& file, const char* symbol, const std::string& what);

}  // namespace scrim
