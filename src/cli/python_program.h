// SPDX-License-Identifier: Apache-2.0
// The Python that runs what the program leaves to Python code: OpenUSD stages and the viewer.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace scrim::cli {

/// The Python program: the one named by $SCRIM_PYTHON, or python3 beside this program, or the one in PATH.
inline std::string pythonProgram() {
    if (const char* const named = std::getenv("SCRIM_PYTHON"); named != nullptr && *named != '\0') return named;
    std::error_code ignored;
    const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", ignored);
    const std::filesystem::path beside = self.parent_path() / "python3";
    return !self.empty() && std::filesystem::exists(beside, ignored) ? beside.string() : "python3";
}

}  // namespace scrim::cli
