// SPDX-License-Identifier: Apache-2.0
#include "help_command.h"

#include "console.h"
#include "man_page.h"

#include <scrim/base/error.h>
#include <scrim/scene/nearest_name.h>
#include <scrim/scene/scene_help.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

namespace scrim::cli {
namespace {

/// True if an option's form is a list of words: "error|black|skip".
bool isChoice(const std::string& form) {
    const auto isWord = [](char c) { return (c >= 'a' && c <= 'z') || c == '|'; };
    return form.find('|') != std::string::npos && std::all_of(form.begin(), form.end(), isWord);
}

std::string spaced(std::string words) {
    std::replace(words.begin(), words.end(), '|', ' ');
    return words;
}

/// A completion script for bash, and for zsh with bashcompinit: commands, their options, the words that an option
/// chooses from, and the paths for --set.
std::string completionScript(const CLI::App& app) {
    std::vector<std::string> names;
    std::string cases, words;
    for (const CLI::App* command : app.get_subcommands({})) {
        names.push_back(command->get_name());
        std::vector<std::string> options;
        for (const CLI::Option* option : command->get_options())
            for (const std::string& name : option->get_lnames()) {
                options.push_back("--" + name);
                const std::string type = option->get_type_name();
                const std::string line = fmt::format("        --{}) words=\"{}\" ;;\n", name, spaced(type));
                if (isChoice(type) && words.find(line) == std::string::npos) words += line;
            }
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
        "    case \"${{COMP_WORDS[COMP_CWORD-1]}}\" in\n"
        "{}    esac\n"
        "    if [ -n \"$words\" ]; then :\n"
        "    elif [ \"$COMP_CWORD\" -eq 1 ]; then words=\"{}\"; else case \"${{COMP_WORDS[1]}}\" in\n"
        "        help) words=\"{} {}\" ;;\n"
        "{}    esac; fi\n"
        "    COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
        "}}\n"
        "complete -o default -F _scrim scrim\n",
        fmt::join(scenePaths(), " "), words, fmt::join(names, " "), fmt::join(names, " "),
        fmt::join(sceneTopics(), " "), cases);
}

}  // namespace

void helpCommand(const HelpOptions& options, const CLI::App& app) {
    if (options.schema) return printOut(sceneSchema());
    if (options.markdown) return printOut(scenesAsMarkdown());
    if (options.completion) return printOut(completionScript(app));
    if (options.man) return printOut(manPage(app, options.topic));
    if (options.topic.empty()) {
        printOut(app.help());
        return printOut(
            fmt::format("\nMore: scrim help COMMAND, or a key such as camera.fov, or a section of a scene:\n  {}\n",
                        fmt::join(sceneTopics(), ", ")));
    }
    std::vector<std::string> topics;
    for (const CLI::App* command : app.get_subcommands({})) topics.push_back(command->get_name());
    // A section and a command may share a name; help shows both.
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
