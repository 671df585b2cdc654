// SPDX-License-Identifier: Apache-2.0
// The files that a command reads as text.
#pragma once

#include <string>

namespace scrim::cli {

/// All bytes of a file. Throws Error(input).
std::string textOf(const std::string& path);

}  // namespace scrim::cli
