// SPDX-License-Identifier: Apache-2.0
// The program: reads the command line, runs one command, and turns any failure into one line and an exit status. This
// is the only place that catches all exceptions.
#include "bake_command.h"
#include "console.h"
#include "help_command.h"
#include "info_command.h"
#include "interrupt.h"
#include "make_command.h"
#include "merge_command.h"
#include "options.h"
#include "plan_command.h"
#include "render_command.h"
#include "study_command.h"
#include "view_command.h"

#include <scrim/base/system_error.h>
#include <scrim/base/version.h>
#include <scrim/image/exr.h>
#include <scrim/image/versions.h>
#include <scrim/scene/frame_range.h>
#include <scrim/scene/nearest_name.h>
#include <scrim/volume/vdb_version.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

namespace scrim::cli {
namespace {

constexpr int kAccuracyStatus = 5;
constexpr int kMemoryStatus = 33;  // farms take this status for "try again on a larger machine"

int statusOf(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::render:
            return 1;
        case ErrorKind::usage:
            return 2;
        case ErrorKind::input:
            return 3;
        case ErrorKind::output:
            return 4;
        case ErrorKind::memory:
            return kMemoryStatus;
        case ErrorKind::interrupted:
            return 128 + (interruptSignal() != 0 ? interruptSignal() : SIGINT);
        case ErrorKind::accuracy:
            return kAccuracyStatus;
    }
    return 1;
}

/// Prints the last line on stderr and returns the status.
int fail(int status, const std::string& reason) {
    constexpr std::size_t kLongestReason = 4000;
    std::fputs(fmt::format("scrim: error: {}\n", shortened(reason, kLongestReason)).c_str(), stderr);
    return status;
}

std::string versionText() {
    return fmt::format(
        "scrim {}\nOpenVDB {} (files up to version {}; codecs {})\nOpenEXR {}\nOpenColorIO {}\nOpenImageIO "
        "{}\n"
        "oneTBB {}\nHighway {}",
        scrimVersion(), openVdbVersion(), vdbFileVersion(), fmt::join(vdbCodecs(), ", "), openExrVersion(),
        openColorIoVersion(), openImageIoVersion(), tbbVersion(), highwayVersion());
}

/// The command line and the options that it fills in.
struct CommandLine {
    CLI::App app{"Renders OpenVDB volumes with volumetric shadows by sheet-based splatting.", "scrim"};
    SceneOptions render, plan, study, bake;
    InfoOptions info;
    MakeOptions make;
    MergeOptions merge;
    ViewOptions view;
    HelpOptions help;

    CommandLine() {
        app.set_version_flag("--version", versionText, "print the versions of scrim and its libraries");
        app.require_subcommand(0, 1);
        addRender();
        addPlan();
        addStudy();
        addBake();
        addInfo();
        addMake();
        addMerge();
        addView();
        addHelp();
    }

    void addRender() {
        CLI::App* command = app.add_subcommand("render", "render scenes, or assets alone");
        addSceneOptions(*command, render);
        addRenderOptions(*command, render, "Output");
        addBudget(*command, render);
        addJobs(*command, render);
    }
    void addPlan() {
        CLI::App* command = app.add_subcommand("plan", "show what a render would do");
        addSceneOptions(*command, plan);
        addRenderOptions(*command, plan, "Options of a render (a plan writes no files)");
        addPlanOptions(*command, plan);
    }
    void addStudy() {
        CLI::App* command = app.add_subcommand("study", "measure how long each accuracy takes on a scene");
        addSceneOptions(*command, study);
        addStudyOptions(*command, study);
    }
    void addBake() {
        CLI::App* command = app.add_subcommand("bake", "save the lighting at voxels as grids, for other renderers");
        addSceneOptions(*command, bake);
        addBakeOptions(*command, bake);
    }
    void addInfo() {
        CLI::App* command = app.add_subcommand("info", "describe .vdb files, sequences and scans");
        command->add_option("files", info.files, "files (.vdb, .nrrd, .nii) or sequences (smoke.####.vdb)")
            ->type_name("ASSET")
            ->required();
        command
            ->add_option_function<std::string>(
                "--frames", [this](const std::string& t) { info.frames = parseFrameRange(t); },
                "of a sequence: 1-48x2,60")
            ->type_name("RANGE");
        command->add_flag("--json", info.json, "print JSON");
        command->add_option("--ax", info.ax, "an expression that changes the grids of .vdb files first")
            ->type_name("CODE");
        command->add_flag("-v,--verbose", info.verbose, "show the output of the reading process");
    }
    void addMake() {
        CLI::App* command = app.add_subcommand("make", "run a volume source and save its grids");
        command
            ->add_option("source", make.source,
                         "name of the source; or ax, to save the grids of a file after an expression")
            ->type_name("SOURCE");
        command->add_option("parameters", make.parameters, "values in place of the defaults")->type_name("KEY=VALUE");
        command->add_option("-o,--output", make.output, "file to write")->type_name("OUT.vdb");
        make.threads = threadsOfJob();
        command->add_option("--threads", make.threads, "threads to use; 0: all of the machine")
            ->type_name("N")
            ->check(CLI::Range(0, 4096));
        command->add_flag("--list", make.list, "print all sources with their parameters");
        command->add_flag("--help-source", make.helpSource, "print the parameters of the source");
        addVerbosity(*command, make.verbose, make.quiet);
    }
    void addMerge() {
        CLI::App* command = app.add_subcommand("merge", "join crops of a picture");
        command->add_option("tiles", merge.tiles, "pictures that scrim render --crop wrote")
            ->type_name("TILE.exr")
            ->required();
        command->add_option("-o,--output", merge.output, "file to write")->type_name("WHOLE.exr");
        command->add_option("--compression", merge.compression, "in place of that of the tiles")
            ->type_name(fmt::format("{}", fmt::join(exrCompressions(), "|")));
        command->add_flag("--check", merge.check, "only print the incomplete pictures");
        command->add_flag("-q,--quiet", merge.quiet, "only warnings and errors");
    }
    void addView() {
        CLI::App* command = app.add_subcommand("view", "show a scene or an asset in the browser, and change it there");
        command
            ->add_option("input", view.input,
                         "a scene (.toml), asset (.vdb), scan (.nrrd, .nii), stage (.usd), or a folder of them")
            ->type_name("SCENE|ASSET|FOLDER")
            ->required();
        command->add_option("--frame", view.frame, "frame to begin with (default: the first)")->type_name("N");
        command->add_option("--res", view.resolution, "resolution of an asset alone")->type_name("WxH");
        command->add_option("--up", view.up, "up axis of an asset: y, z, -z, ... (default: guessed)")
            ->type_name("AXIS");
        command->add_option("--ocio", view.ocio, "OpenColorIO config, in place of $OCIO")->type_name("FILE");
        command
            ->add_option("--listen", view.listen,
                         "address to listen on (default: a free port of 127.0.0.1, for this machine alone)")
            ->type_name("HOST:PORT");
        command->add_flag("--no-browser", view.noBrowser, "only print the address");
    }
    void addHelp() {
        CLI::App* command = app.add_subcommand("help", "explain a command, a section of a scene, a key");
        command->add_option("topic", help.topic, "render, camera, camera.fov")->type_name("TOPIC");
        command->add_flag("--schema", help.schema, "print a JSON schema of scenes, for editors");
        command->add_flag("--markdown", help.markdown, "print all sections and keys of a scene as Markdown");
        command->add_flag("--completion", help.completion, "print a completion script for bash");
        command->add_flag("--man", help.man, "print the man page of scrim, or of a command, or of 'scene'");
    }

    std::vector<std::string> commandNames() const {
        std::vector<std::string> names;
        for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
        return names;
    }
    /// The command that was given, else the program itself.
    const CLI::App& current() const {
        const std::vector<CLI::App*> given = app.get_subcommands();
        return given.empty() ? app : *given.front();
    }
};

/// CLI11's text about a mistake, in one line and with a suggestion.
std::string usageText(const CommandLine& line, const CLI::ParseError& error) {
    std::string text = error.what();
    const CLI::App& command = line.current();
    if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
        std::vector<std::string> options;
        for (const CLI::Option* option : command.get_options())
            for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
        for (const std::string& extra : command.remaining()) {
            const std::string hint = didYouMean(extra.substr(0, extra.find('=')), options);
            if (!hint.empty()) return text + hint;
        }
    }
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
        const auto inputs = command.get_options(
            [](const CLI::Option* option) { return option->get_positional() && option->get_expected_max() > 1; });
        text = fmt::format("{}: expected {}{}", command.get_name(), inputs.empty() ? "" : "one or more ",
                           command.get_name() == "info"    ? "ASSET.vdb"
                           : command.get_name() == "merge" ? "TILE.exr"
                                                           : "SCENE.toml or ASSET.vdb");
    }
    const bool inCommand = &command != &line.app;
    return fmt::format("{}; see scrim {}--help", text, inCommand ? command.get_name() + " " : "");
}

void checkCommandName(const CommandLine& line, const std::vector<std::string>& arguments) {
    if (arguments.empty() || arguments.front().rfind('-', 0) == 0) return;
    const std::vector<std::string> names = line.commandNames();
    for (const std::string& name : names)
        if (name == arguments.front()) return;
    throw Error(ErrorKind::usage,
                fmt::format("unknown command '{}'; expected {}", shortened(arguments.front(), 80), choices(names)));
}

int runCommand(CommandLine& line) {
    const std::string name = &line.current() == &line.app ? "" : line.current().get_name();
    if (name == "render") renderCommand(line.render);
    if (name == "plan") planCommand(line.plan);
    if (name == "study") studyCommand(line.study);
    if (name == "bake") bakeCommand(line.bake);
    if (name == "info") infoCommand(line.info);
    if (name == "make") makeCommand(line.make);
    if (name == "merge") mergeCommand(line.merge);
    if (name == "view") viewCommand(line.view);
    if (name == "help") helpCommand(line.help, line.app);
    if (name.empty()) {
        printOut(line.app.help());
        flushOut();
        throw Error(ErrorKind::usage, fmt::format("no command; expected {}", choices(line.commandNames())));
    }
    flushOut();
    return 0;
}

int run(const std::vector<std::string>& arguments) {
    handleInterrupts();
    CommandLine line;
    checkCommandName(line, arguments);
    try {
        line.app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
    } catch (const CLI::Success& success) {  // help and version are requested through exceptions
        std::ostringstream text;
        line.app.exit(success, text, text);
        printOut(text.str());
        flushOut();
        return 0;
    } catch (const CLI::ParseError& error) {
        throw Error(ErrorKind::usage, usageText(line, error));
    }
    return runCommand(line);
}

}  // namespace
}  // namespace scrim::cli

int main(int argc, char** argv) {
    using namespace scrim;
    openStandardStreams();
    try {
        return withErrors([&] { return cli::run({argv + 1, argv + argc}); });
    } catch (const Error& error) {
        return cli::fail(cli::statusOf(error.kind()), error.what());
    } catch (const std::exception& error) {
        return cli::fail(1, error.what());
    }
}
