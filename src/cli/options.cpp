// SPDX-License-Identifier: Apache-2.0
#include "options.h"

#include <scrim/base/error.h>
#include <scrim/scene/frame_range.h>
#include <scrim/scene/quality.h>
#include <scrim/verify/verify.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <functional>
#include <string_view>

namespace scrim::cli {
namespace {

constexpr int kMostPixels = 65536;  // along a side, as in scenes
constexpr int kMostThreads = 4096;
constexpr double kMostStops = 30;

[[noreturn]] void refuse(const std::string& option, const std::string& text, const std::string& expected) {
    throw Error(ErrorKind::usage, fmt::format("{} {}: expected {}", option, shortened(text, 80), expected));
}

/// The numbers in `text` between `separator`s; no value where the text has any other form.
template <typename Number>
std::optional<std::vector<Number>> numbersOf(std::string_view text, char separator) {
    std::vector<Number> numbers;
    for (;;) {
        Number value{};
        const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc()) return std::nullopt;
        numbers.push_back(value);
        text.remove_prefix(std::size_t(stop - text.data()));
        if (text.empty()) return numbers;
        if (text.front() != separator) return std::nullopt;
        text.remove_prefix(1);
    }
}

/// The number that makes up all of `text`. Throws where it is none or `allows` rejects it.
double numberFrom(const std::string& option, const std::string& text, bool (*allows)(double),
                  const std::string& expected) {
    const auto numbers = numbersOf<double>(text, '\0');
    if (!numbers || numbers->size() != 1 || !allows(numbers->front())) refuse(option, text, expected);
    return numbers->front();
}

double secondsFrom(const std::string& option, const std::string& text) {
    return numberFrom(
        option, text, [](double v) { return v > 0 && v <= 1e9; }, "seconds, more than 0");
}

int countFrom(const std::string& option, const std::string& text, int most, const std::string& others = "") {
    const auto numbers = numbersOf<int>(text, '\0');
    if (!numbers || numbers->size() != 1 || numbers->front() < 0 || numbers->front() > most)
        refuse(option, text, fmt::format("{}a whole number from 0 to {}", others, most));
    return numbers->front();
}

int turntableFrom(const std::string& text) {
    constexpr int kMostFrames = 10000;
    const auto numbers = numbersOf<int>(text, '\0');
    if (!numbers || numbers->size() != 1 || numbers->front() < 2 || numbers->front() > kMostFrames)
        refuse("--turntable", text, fmt::format("a whole number of frames from 2 to {}", kMostFrames));
    return numbers->front();
}

/// Adds an option whose text `take` parses.
CLI::Option* add(CLI::App& command, const std::string& names, const std::string& form, const std::string& help,
                 const std::function<void(const std::string&)>& take) {
    return command.add_option_function<std::string>(names, take, help)->type_name(form);
}

/// Adds an option that names a file or a folder.
void addFile(CLI::App& command, const std::string& names, const std::string& form, const std::string& help,
             std::string& path) {
    add(command, names, form, help, [&path, names](const std::string& text) {
        if (text.empty()) throw Error(ErrorKind::usage, names.substr(names.find("--")) + ": the name is empty");
        path = text;
    });
}

/// Adds an option that is one of some words; `take` receives the word's index.
void addChoice(CLI::App& command, const std::string& name, const std::vector<std::string>& words,
               const std::string& help, const std::function<void(std::size_t)>& take) {
    add(command, name, fmt::format("{}", fmt::join(words, "|")), help, [=](const std::string& text) {
        const auto found = std::find(words.begin(), words.end(), text);
        if (found == words.end()) refuse(name, "'" + text + "'", choices(words));
        take(std::size_t(found - words.begin()));
    });
}

void addProgress(CLI::App& command, SceneOptions& o) {
    addChoice(command, "--progress", progressStyleNames(), "form of the progress report",
              [&o](std::size_t i) { o.progress = static_cast<ProgressStyle>(i); });
}

/// Adds the options about OpenUSD stages.
void addUsdOptions(CLI::App& command, UsdOptions& o) {
    const auto text = [&](const char* name, const char* form, const char* help, std::string& value) {
        command.add_option(name, value, help)->type_name(form)->group("OpenUSD");
    };
    text("--camera", "/CAM", "camera of a stage (default: that of its settings, or its only one)", o.camera);
    text("--settings", "/RS", "RenderSettings of a stage (default: those that it names)", o.settings);
    text("--purpose", "NAMES", "purposes of a stage that are rendered: default,render,proxy,guide", o.purpose);
    text("--sidecar", "FILE.toml", "tables keyed by prim paths: media, and other keys that a stage cannot hold",
         o.sidecar);
    text("--distant", "radiance|irradiance", "unit of the intensity of a stage's distant lights", o.distant);
    text("--meshes", "holdout|shadows|none", "effect of a stage's meshes on volumes", o.meshes);
}

}  // namespace

int threadsOfJob() {
    const char* const text = std::getenv("SLURM_CPUS_PER_TASK");
    if (text == nullptr) return 0;
    const auto numbers = numbersOf<int>(text, '\0');
    const bool fits = numbers && numbers->size() == 1 && numbers->front() > 0;
    return fits ? std::min(numbers->front(), kMostThreads) : 0;
}

std::size_t parseSize(const std::string& text) {
    std::string bytes = text;
    std::size_t value = 0;
    try {
        // CLI11 takes a unit alone for 1 of it.
        if (bytes.find_first_of("0123456789") == 0) CLI::AsSizeValue(false)(bytes);
        std::from_chars(bytes.data(), bytes.data() + bytes.size(), value);
    } catch (const CLI::ValidationError&) {
    }
    if (value == 0) refuse("--memory", text, "a size such as 8G, 512M, 64K, or a number of bytes");
    return value;
}

Int2 parseResolution(const std::string& text) {
    const auto sides = numbersOf<int>(text, 'x');
    if (!sides || sides->size() != 2 || std::min((*sides)[0], (*sides)[1]) < 1 ||
        std::max((*sides)[0], (*sides)[1]) > kMostPixels)
        refuse("--res", text, fmt::format("WIDTHxHEIGHT, each from 1 to {} pixels", kMostPixels));
    return {(*sides)[0], (*sides)[1]};
}

PixelWindow parseCrop(const std::string& text) {
    const auto n = numbersOf<int>(text, ',');
    if (!n || n->size() != 4 || (*n)[0] >= (*n)[2] || (*n)[1] >= (*n)[3])
        refuse("--crop", text, "X0,Y0,X1,Y1 in pixels with X0 < X1 and Y0 < Y1");
    return {(*n)[0], (*n)[1], (*n)[2], (*n)[3]};
}

Vec3 parseAxis(const std::string& text) {
    const bool negative = text.starts_with('-');
    const std::string_view letter = std::string_view(text).substr(negative ? 1 : 0);
    if (letter.size() != 1 || letter[0] < 'x' || letter[0] > 'z')
        refuse("--up", "'" + text + "'", choices({"x", "y", "z", "-x", "-y", "-z"}));
    Vec3 axis(0);
    axis[letter[0] - 'x'] = negative ? -1 : 1;
    return axis;
}

void addVerbosity(CLI::App& command, bool& verbose, bool& quiet) {
    CLI::Option* loud = command.add_flag("-v,--verbose", verbose, "print details of each step");
    command.add_flag("-q,--quiet", quiet, "only warnings and errors")->excludes(loud);
}

void addSceneOptions(CLI::App& command, SceneOptions& o) {
    command
        .add_option("inputs", o.inputs,
                    "scenes (.toml), assets (.vdb), scans (.nrrd, .nii) or stages (.usd); an asset or scan alone is "
                    "framed and lit")
        ->type_name("SCENE|ASSET")
        ->required();
    add(command, "--frames", "RANGE", "frames: 1-48x2,60",
        [&o](const std::string& t) { o.frames = parseFrameRange(t); });
    add(command, "--res", "WxH", "resolution, in place of the scene's",
        [&o](const std::string& t) { o.resolution = parseResolution(t); });
    add(command, "--crop", "X0,Y0,X1,Y1", "only the pixels of this window",
        [&o](const std::string& t) { o.crop = parseCrop(t); });
    add(command, "--up", "AXIS", "up axis of an asset: y, z, -z, ... (default: guessed)",
        [&o](const std::string& t) { o.wsUp = parseAxis(t); });
    addChoice(command, "--quality", presetNames(), "preset of all dials, in place of the scene's",
              [&o](std::size_t i) { o.quality = presetNames()[i]; });
    addFile(command, "--dials", "FILE.toml", "dials of a shot, as scrim plan --write-dials writes them", o.dials);
    command.add_option("--set", o.sets, "change a value of the scene: camera.fov=20, light.key.intensity=3")
        ->type_name("KEY.PATH=VALUE")
        ->allow_extra_args(false);
    add(command, "--shutter", "off", "no motion blur: the same as --set camera.shutter=off",
        [&o](const std::string& t) {
            if (t != "off") refuse("--shutter", t, "'off'; --set camera.shutter=[OPEN, CLOSE] gives times");
            o.sets.push_back("camera.shutter=\"off\"");
        });
    o.threads = threadsOfJob();
    add(command, "--threads", "N",
        "threads to use; 0: all of the machine (default: those of the Slurm job, or else all)",
        [&o](const std::string& t) { o.threads = countFrom("--threads", t, kMostThreads); });
    add(command, "--memory", "SIZE", "limit for volumes and buffers: 8G, 512M",
        [&o](const std::string& t) { o.memory = parseSize(t); });
    addChoice(command, "--missing", {"error", "black", "skip"}, "what to do with a frame if a volume's file is missing",
              [&o](std::size_t i) { o.missing = static_cast<MissingPolicy>(i); });
    addFile(command, "--ocio", "FILE", "OpenColorIO config, in place of $OCIO", o.ocio);
    command.add_flag("--print-scene", o.printScene, "only print the scene, with all changes");
    addVerbosity(command, o.verbose, o.quiet);
    addUsdOptions(command, o.usd);
}

void addRenderOptions(CLI::App& command, SceneOptions& o, const std::string& group) {
    command.option_defaults()->group(group);
    addFile(command, "-o,--output", "FILE.exr", "picture to write: plume.####.exr", o.output);
    addFile(command, "--deep", "FILE.exr", "deep picture to write, in place of the scene's", o.deep);
    command.add_option("--file", o.files, "further file to write, in place of the scene's; once for each, in order")
        ->type_name("FILE.exr")
        ->allow_extra_args(false);
    addFile(command, "--preview", "FILE.png", "also write a picture for viewing", o.preview);
    command.add_option("--view", o.view, "view of the OpenColorIO config for previews")->type_name("NAME");
    command.add_flag("--annotate", o.annotate, "previews with a scale bar and the directions of x, y and z");
    add(command, "--exposure", "STOPS", "exposure of previews; the picture does not change",
        [&o](const std::string& t) {
            o.exposure = numberFrom(
                "--exposure", t, [](double v) { return v >= -kMostStops && v <= kMostStops; }, "stops from -30 to 30");
        });
    add(command, "--turntable", "N", "N frames in which the camera turns once around its target",
        [&o](const std::string& t) { o.turntable = turntableFrom(t); });
    command.add_option("--display-server", o.display, "show pictures during the render in a viewer such as tev")
        ->type_name("HOST:PORT");
    addFile(command, "--stats", "FILE.json", "write times, work and memory", o.stats);
    command.add_flag("--skip-existing", o.skipExisting, "skip frames whose picture exists");
    add(command, "--verify", "N|all",
        "compare N random pixels, or all, where a volume may be seen, with the brute-force reference",
        [&o](const std::string& t) {
            o.verify = t == "all" ? kAllPixels : countFrom("--verify", t, kAllPixels - 1, "'all' or ");
        });
    add(command, "--verify-limit", "SECONDS", "end the verification after this time",
        [&o](const std::string& t) { o.verifyLimit = secondsFrom("--verify-limit", t); });
    add(command, "--tolerance", "E",
        "choose texels and sheets for an error (relative RMSE) below E, and measure it; exit status 5 if it is missed",
        [&o](const std::string& t) {
            o.tolerance = numberFrom(
                "--tolerance", t, [](double e) { return e > 0 && e < 1; },
                "a relative RMSE between 0 and 1, such as 0.005");
        });
    addProgress(command, o);
    command.option_defaults()->group("Options");
}

void addJobs(CLI::App& command, SceneOptions& o) {
    add(command, "--jobs", "N", "frames to render side by side, each with its part of the threads and of --memory",
        [&o](const std::string& t) {
            o.jobs = countFrom("--jobs", t, kMostThreads);
            if (o.jobs == 0) refuse("--jobs", t, fmt::format("a whole number from 1 to {}", kMostThreads));
        });
}

void addBudget(CLI::App& command, SceneOptions& o) {
    add(command, "--budget", "SECONDS", "take the finest preset with which a frame should render in this time",
        [&o](const std::string& t) { o.budget = secondsFrom("--budget", t); });
}

void addPlanOptions(CLI::App& command, SceneOptions& o) {
    command.add_flag("--json", o.json, "print JSON");
    addFile(command, "--write-dials", "FILE.toml",
            "write the dials that the preset chooses, the most exact of all frames, for renders with --dials",
            o.writeDials);
}

void addStudyOptions(CLI::App& command, SceneOptions& o) {
    addFile(command, "-o,--output", "DIR",
            "folder for study.csv, study.json and index.html; with --steady for steady.csv and steady.json", o.output);
    command.add_flag("--steady", o.steady,
                     "measure how much neighbouring frames flicker; exit status 5 if it is more than promised");
    add(command, "--budget", "SECONDS", "stop after this time, and report the results so far",
        [&o](const std::string& t) { o.budget = secondsFrom("--budget", t); });
    addProgress(command, o);
}

void addBakeOptions(CLI::App& command, SceneOptions& o) {
    addFile(command, "-o,--output", "LIGHT.vdb", "file to write: light.####.vdb", o.baked);
    command.add_option("--light", o.bakedLights, "only this light; may be given more than once")
        ->type_name("NAME")
        ->allow_extra_args(false);
    command.add_flag("--emission", o.emission, "also save scattered light as an emission grid, and extinction");
    command.add_flag("--indirect", o.indirect, "also save light that has scattered before: mean radiance and flux");
    addProgress(command, o);
}

}  // namespace scrim::cli
