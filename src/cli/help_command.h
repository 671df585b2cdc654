// SPDX-License-Identifier: Apache-2.0
// `scrim help`: explains commands, and everything that a scene may contain.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace scrim::cli {

struct HelpOptions {
    std::string topic;  ///< a command, a section of scenes or a key; "": an overview
    bool schema = false, markdown = false, completion = false, man = false;
};

/// `app` holds the commands. Throws Error(usage) where there is no such topic.
void helpCommand(const HelpOptions& options, const CLI::App& app);

}  // namespace scrim::cli
