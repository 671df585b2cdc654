// SPDX-License-Identifier: Apache-2.0
#include "help_command.h"

#include "console.h"

#include <scrim/base/error.h>
#include <scrim/scene/nearest_name.h>
#include <scrim/scene/scene_help.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

namespace scrim::cli {
namespace {

/// For bash, and for zsh with bashcompinit: commands, their options, and the paths behind --set.
std::string completionScript(const CLI::App& app) {
    std::vector<std::string> names;
    std::string cases;
    for (const CLI::App* command : app.get_subcommands({})) {
        names.push_back(command->get_name());
        std::vector<std::string> options;
        for (const CLI::Option* option : command->get_options())
            for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
        cases += fmt::format("        {}) words=\"{}\" ;;\n", command->get_name(), fmt::join(options, " "));
    }
    return fmt::format(
        "# bash completion for scrim: eval \"$(scrim help --completion)\"\n"
        "_scrim() {{\n"
        "    local word=\"${{COMP_WORDS[COMP_CWORD]}}\" words=\"\"\n"
        "    COMPREPLY=()\n"
        "    if [ \"${{COMP_WORDS[COMP_CWORD-1]}}\" = --set ]; then\n"
        "        compopt -o nospace\n"
        "        COMPREPLY=($(compgen -S = -W \"{}\" -- \"$word\"))\n"
        "        return\n"
        "    fi\n"
        "    if [ \"$COMP_CWORD\" -eq 1 ]; then words=\"{}\"; else case \"${{COMP_WORDS[1]}}\" in\n"
        "        help) words=\"{} {}\" ;;\n"
        "{}    esac; fi\n"
        "    COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
        "}}\n"
        "complete -o default -F _scrim scrim\n",
        fmt::join(scenePaths(), " "), fmt::join(names, " "), fmt::join(names, " "), fmt::join(sceneTopics(), " "),
        cases);
}

}  // namespace

void helpCommand(const HelpOptions& options, const CLI::App& app) {
    if (options.schema) return printOut(sceneSchema());
    if (options.markdown) return printOut(scenesAsMarkdown());
    if (options.completion) return printOut(completionScript(app));
    if (options.topic.empty()) {
        printOut(app.help());
        return printOut(
            fmt::format("\nMore: scrim help COMMAND, or one of these of a scene, or a key such as camera.fov:\n  {}\n",
                        fmt::join(sceneTopics(), ", ")));
    }
    std::vector<std::string> topics;
    for (const CLI::App* command : app.get_subcommands({})) topics.push_back(command->get_name());
    // A section is called as a command is: both are meant.
    const std::string text = sceneHelp(options.topic);
    for (const std::string& name : topics)
        if (name == options.topic) {
            printOut(app.get_subcommand(name)->help("scrim"));
            if (!text.empty()) printOut("\nIn a scene: ");
        }
    const bool isCommand = std::find(topics.begin(), topics.end(), options.topic) != topics.end();
    if (!isCommand && text.empty()) {
        const std::vector<std::string> sections = sceneTopics();
        topics.insert(topics.end(), sections.begin(), sections.end());
        throw Error(ErrorKind::usage,
                    fmt::format("there is no help on '{}'{}; expected a key, or {}", shortened(options.topic, 60),
                                didYouMean(options.topic, topics), choices(topics)));
    }
    printOut(text);
}

}  // namespace scrim::cli
