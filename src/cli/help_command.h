// SPDX-License-Identifier: Apache-2.0
// `scrim help`: commands, and all that a scene may say.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace scrim::cli {

struct HelpOptions {
    std::string topic;  ///< a command, a section of scenes, a key; "": what there is
    bool schema = false, markdown = false, completion = false, man = false;
};

/// `app` has the commands. Throws Error(usage) where there is no such topic.
void helpCommand(const HelpOptions& options, const CLI::App& app);

}  // namespace scrim::cli
