// SPDX-License-Identifier: Apache-2.0
#include "man_page.h"

#include <scrim/base/error.h>
#include <scrim/base/version.h>
#include <scrim/scene/nearest_name.h>
#include <scrim/scene/scene_help.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace scrim::cli {
namespace {

constexpr std::array<std::pair<int, const char*>, 9> kStatuses{{
    {0, "Done."},
    {1, "The render failed, or a limit of the system was met (ulimit)."},
    {2, "The command line is wrong."},
    {3, "An input is missing or bad."},
    {4, "The output could not be written."},
    {5, "Written, but a tolerance was missed, or multiple scattering did not converge; or a shot flickers."},
    {33, "Out of memory: farms may try again on a larger machine."},
    {130, "Interrupted by SIGINT; no incomplete file was left."},
    {143, "Interrupted by SIGTERM, in the same way."},
}};

constexpr std::array<std::pair<const char*, const char*>, 5> kVariables{{
    {"OCIO", "The OpenColorIO config, unless --ocio or the scene names one."},
    {"SCRIM_PLUGIN_PATH", "Folders of volume sources, searched before those that were installed; ':' between them."},
    {"SCRIM_PYTHON", "The Python that reads OpenUSD stages and runs the viewer: one with the module scrim."},
    {"SLURM_CPUS_PER_TASK", "The number of threads, unless --threads gives it."},
    {"TMPDIR", "The folder for temporary files."},
}};

std::string heading(const std::string& name, int section) {
    std::string upper = name;
    for (char& c : upper) c = c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c;
    return fmt::format(".TH {} {} \"\" \"scrim {}\" \"Scrim\"\n", roffText(upper), section, scrimVersion());
}

/// A paragraph with a hanging term.
std::string item(const std::string& term, const std::string& text) {
    return fmt::format(".TP\n{}\n{}\n", term, roffText(text));
}

std::string bold(const std::string& text) {
    return "\\fB" + roffText(text) + "\\fR";
}

/// "\fB-o\fR, \fB--output\fR \fIFILE.exr\fR".
std::string optionTerm(const CLI::Option& option) {
    if (option.get_positional()) return fmt::format("\\fI{}\\fR", roffText(option.get_type_name()));
    std::string term;
    const auto add = [&](const char* dashes, const std::vector<std::string>& names) {
        for (const std::string& name : names) term += (term.empty() ? "" : ", ") + bold(dashes + name);
    };
    add("-", option.get_snames());
    add("--", option.get_lnames());
    if (option.get_expected_max() > 0 && !option.get_type_name().empty())
        term += fmt::format(" \\fI{}\\fR", roffText(option.get_type_name()));
    return term;
}

/// The options of a command by groups, as CLI11 knows them.
std::string optionLists(const CLI::App& command) {
    std::string text = ".SH ARGUMENTS\n";
    bool any = false;
    for (const CLI::Option* option : command.get_options()) {
        if (!option->get_positional()) continue;
        any = true;
        text += item(optionTerm(*option), option->get_description());
    }
    if (!any) text.clear();
    text += ".SH OPTIONS\n";
    for (const std::string& group : command.get_groups()) {
        if (group.empty()) continue;
        if (group != "Options") text += fmt::format(".SS {}\n", roffText(group));
        for (const CLI::Option* option : command.get_options())
            if (!option->get_positional() && option->get_group() == group)
                text += item(optionTerm(*option), option->get_description());
    }
    return text;
}

std::string synopsis(const CLI::App& command) {
    std::string text = fmt::format(".SH SYNOPSIS\n{} {} [\\fIoptions\\fR]", bold("scrim"), bold(command.get_name()));
    for (const CLI::Option* option : command.get_options()) {
        if (!option->get_positional()) continue;
        const std::string term = optionTerm(*option) + (option->get_expected_max() > 1 ? " ..." : "");
        text += " " + (option->get_required() ? term : "[" + term + "]");
    }
    return text + "\n";
}

std::string statuses() {
    std::string text = ".SH EXIT STATUS\nThe last line on standard error says why.\n";
    for (const auto& [status, meaning] : kStatuses) text += item(bold(std::to_string(status)), meaning);
    return text;
}

std::string commandPage(const CLI::App& command) {
    const std::string name = "scrim-" + command.get_name();
    return heading(name, 1) +
           fmt::format(".SH NAME\n{} \\- {}\n", roffText(name), roffText(command.get_description())) +
           synopsis(command) + optionLists(command) + statuses() +
           ".SH SEE ALSO\n.BR scrim (1),\n.BR scrim-scene (5)\n";
}

std::string overviewPage(const CLI::App& app) {
    std::string text = heading("scrim", 1) +
                       ".SH NAME\nscrim \\- renderer of OpenVDB volumes with volumetric shadows\n"
                       ".SH SYNOPSIS\n\\fBscrim\\fR \\fIcommand\\fR [\\fIoptions\\fR] ...\n.SH DESCRIPTION\n" +
                       roffText(app.get_description()) +
                       "\nPictures are colour-managed, scene-linear OpenEXR. An asset alone is framed and lit; scenes "
                       "are TOML files, of which\n.BR scrim-scene (5)\nholds every key.\n.SH COMMANDS\n";
    std::string also;
    for (const CLI::App* command : app.get_subcommands({})) {
        text += item(bold(command->get_name()), command->get_description());
        also += fmt::format(".BR {} (1),\n", roffText("scrim-" + command->get_name()));
    }
    text += statuses() + ".SH ENVIRONMENT\n";
    for (const auto& [name, meaning] : kVariables) text += item(bold(name), meaning);
    text += ".SH EXAMPLES\n.nf\n";
    for (const char* line : {"scrim render smoke.vdb -o smoke.exr --preview smoke.png",
                             "scrim render smoke.vdb --print-scene > smoke.toml",
                             "scrim render smoke.toml -o 'smoke.####.exr' --frames 1-48 --set camera.fov=20"})
        text += roffText(line) + "\n";
    return text + ".fi\n.SH SEE ALSO\n" + also + ".BR scrim-submit (1),\n.BR scrim-scene (5)\n";
}

std::string scenePage() {
    return heading("scrim-scene", 5) +
           ".SH NAME\nscrim-scene \\- scenes that scrim renders\n.SH DESCRIPTION\n"
           "A scene is a TOML file. This page lists every key by its section; the same is printed by\n"
           "\\fBscrim help\\fR \\fIsection\\fR. A star marks values that may be keyed.\n" +
           scenesAsRoff() + ".SH SEE ALSO\n.BR scrim (1),\n.BR scrim-render (1)\n";
}

}  // namespace

std::string manPage(const CLI::App& app, const std::string& topic) {
    if (topic.empty()) return overviewPage(app);
    if (topic == "scene") return scenePage();
    std::vector<std::string> names{"scene"};
    for (const CLI::App* command : app.get_subcommands({})) {
        if (command->get_name() == topic) return commandPage(*command);
        names.push_back(command->get_name());
    }
    throw Error(ErrorKind::usage, fmt::format("there is no man page on '{}'{}; expected {}", shortened(topic, 60),
                                              didYouMean(topic, names), choices(names)));
}

}  // namespace scrim::cli
