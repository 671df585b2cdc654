// SPDX-License-Identifier: Apache-2.0
#include "view_command.h"

#include "python_program.h"

#include <scrim/base/error.h>

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include <unistd.h>

namespace scrim::cli {
namespace {

constexpr const char* kHowToInstall =
    "the viewer is in Scrim's Python package and needs tornado and tomlkit (pip install '.[view]' in the folder of "
    "Scrim's sources); $SCRIM_PYTHON names the Python that has all three";

/// Starts the viewer, or says in one line why this Python cannot.
constexpr const char* kStart = R"(try:
    from scrim.view.__main__ import main
except ImportError as missing:
    print(f"scrim: error: {missing}; {sys.argv[1]}", file=sys.stderr)
    sys.exit(3)
del sys.argv[1]
sys.exit(main()))";

}  // namespace

void viewCommand(const ViewOptions& options) {
    std::vector<std::string> words = pythonCommand(kStart);
    words.emplace_back(kHowToInstall);
    const auto add = [&words](const char* name, const std::string& value) {
        if (!value.empty()) words.push_back(fmt::format("--{}={}", name, value));
    };
    add("listen", options.listen);
    add("up", options.up);
    add("res", options.resolution);
    add("ocio", options.ocio);
    if (options.frame) add("frame", std::to_string(*options.frame));
    if (options.noBrowser) words.emplace_back("--no-browser");
    words.insert(words.end(), {"--", options.input});
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    ::execvp(arguments[0], arguments.data());
    throw Error(ErrorKind::input,
                fmt::format("cannot start '{}': {}; {}", words[0], std::strerror(errno), kHowToInstall));
}

}  // namespace scrim::cli
