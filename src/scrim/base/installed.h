// SPDX-License-Identifier: Apache-2.0
// Where the files lie that belong to this library: modules, volume sources and the program that reads volumes. In the
// build tree as in the installed one, wherever it was moved to.
#pragma once

#include <string>

namespace scrim {

/// The folder of the shared object (or program) that this code is part of; "" where the system does not tell.
std::string libraryFolder();

/// "scrim/NAME" in that folder.
std::string besideLibrary(const std::string& name);

/// The path of the module FILE there. Throws Error(render) where it is not installed; `what` says what it does:
/// "reads volumes".
std::string installedModule(const std::string& file, const std::string& what);

/// The function `symbol` of that module, which is loaded for good. Throws Error(render).
void* moduleFunction(const std::string& file, const char* symbol, const std::string& what);

}  // namespace scrim
