// SPDX-License-Identifier: Apache-2.0
#include "python_program.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace scrim::cli {
namespace {

// PYTHONSAFEPATH keeps Python from the current folder from 3.11 on; it goes at once, since it is not meant for programs
// that Python starts. Python 3.10 does not know it, and has the current folder as its first entry, "", by the time it
// runs code. The option -I would do for both, but ignores PYTHONPATH and packages of the user.
constexpr const char* kWithoutCurrentFolder = R"(import sys
if sys.path[:1] == [""]:
    del sys.path[0]
import os
if os.environ.get("PYTHONSAFEPATH") == "scrim":
    del os.environ["PYTHONSAFEPATH"]
)";

std::string pythonProgram() {
    if (const char* const named = std::getenv("SCRIM_PYTHON"); named != nullptr && *named != '\0') return named;
    std::error_code ignored;
    const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", ignored);
    const std::filesystem::path beside = self.parent_path() / "python3";
    return !self.empty() && std::filesystem::exists(beside, ignored) ? beside.string() : "python3";
}

/// PYTHONPATH without empty entries, which mean the current folder: PYTHONPATH=$PYTHONPATH:/more makes one by mistake.
std::string withoutEmptyEntries(const std::string& path) {
    std::string out;
    for (std::size_t begin = 0; begin <= path.size();) {
        const std::size_t end = std::min(path.find(':', begin), path.size());
        if (end > begin) out += (out.empty() ? "" : ":") + path.substr(begin, end - begin);
        begin = end + 1;
    }
    return out;
}

}  // namespace

std::vector<std::string> pythonCommand(const std::string& code) {
    ::setenv("PYTHONSAFEPATH", "scrim", 0);
    if (const char* const path = std::getenv("PYTHONPATH"); path != nullptr)
        ::setenv("PYTHONPATH", withoutEmptyEntries(path).c_str(), 1);
    return {pythonProgram(), "-c", kWithoutCurrentFolder + code};
}

}  // namespace scrim::cli
