// SPDX-License-Identifier: Apache-2.0
#include "study_command.h"

#include "console.h"
#include "field_store.h"
#include "progress.h"
#include "scene_input.h"
#include "slide_store.h"

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/base/atomic_file.h>
#include <scrim/image/exr.h>
#include <scrim/shot/assemble.h>
#include <scrim/study/study.h>
#include <scrim/study/study_data.h>
#include <scrim/study/study_page.h>

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

namespace scrim::cli {
namespace {

// The folder for the results: there before hours of work rely on it, and gone again where nothing came of them.
class ResultFolder {
  public:
    explicit ResultFolder(const std::string& path) : m_path(path) {
        std::error_code error;
        m_made = std::filesystem::create_directories(path, error);
        if (error)
            throw Error(ErrorKind::output, fmt::format("cannot make the folder '{}': {}", path, error.message()));
    }
    ~ResultFolder() {
        std::error_code ignored;
        if (m_made) std::filesystem::remove(m_path, ignored);  // unless it holds something
    }
    ResultFolder(const ResultFolder&) = delete;
    ResultFolder& operator=(const ResultFolder&) = delete;

    const std::string& path() const { return m_path; }
    void write(const std::string& name, const std::string& text) const {
        writeWholeFile((std::filesystem::path(m_path) / name).string(), text);
    }

  private:
    std::string m_path;
    bool m_made = false;
};

std::string tableOf(const Study& study) {
    std::string text = fmt::format("{} reference pixels, {:.0f} s\n{:<12}{:<56}{:>9}{:>12}\n", study.pixels, study.spent,
                                   "error below", "setting", "error", "time");
    for (const Recommendation& r : recommendations(study)) {
        const Trial* t = r.trial ? &study.trials[*r.trial] : nullptr;
        text += t ? fmt::format("{:>9.1f} % {:<56}{:>7.2f} %{:>9.0f} ms\n", 100 * r.tolerance, t->name,
                                100 * t->error.error, 1e3 * t->time())
                  : fmt::format("{:>9.1f} % none of those tried\n", 100 * r.tolerance);
    }
    std::string before;
    for (const Recommendation& r : recommendations(study)) {
        if (!r.trial) continue;
        const std::string block = renderBlock(study.trials[*r.trial].dials);
        if (block != before) text += fmt::format("\n# below {:.1f} %\n{}", 100 * r.tolerance, block);
        before = block;
    }
    text += fmt::format("\n{:<12}one value finer or coarser\n", "dial");
    for (const DialWorth& w : worthOfDials(study)) text += fmt::format("{:<16}{}\n", w.dial, w.verdict);
    return text;
}

void study(const SceneOptions& options) {
    if (options.inputs.size() != 1) throw Error(ErrorKind::usage, "study: expected one scene or asset");
    if (options.output.empty())
        throw Error(ErrorKind::usage, "study: say with -o which folder the results go to");
    Console console(options.verbose, options.quiet);
    const ColourConfig colour = ColourConfig::open(options.ocio);
    FieldStore store({options.memory, options.threads, options.verbose}, console.sink());
    SlideStore slides(colour, console.sink());
    Progress progress(options.progress, console);
    // The output is a folder here: scenes have none of their own.
    SceneOptions sceneOptions = options;
    sceneOptions.output.clear();
    SceneInput input(options.inputs.front(), sceneOptions, colour, store);
    if (input.frames().size() != 1) throw Error(ErrorKind::usage, "study: expected one frame; say which with --frames");

    Scene scene = input.sceneAt(input.frames().front());
    const std::vector<VolumeFile> files = findFiles(scene);
    for (const VolumeFile& file : files)
        if (file.state == FileState::missing) throw Error(ErrorKind::input, file.problem);
    slides.loadInto(scene);
    const Fields fields = store.fieldsOf(scene, files, VolumesOf::scene);

    // Of all dials, only lod changes what is assembled.
    std::map<std::pair<double, VolumesOf>, ViewScene> assembled;
    const auto assembledWith = [&](const Dials& dials, VolumesOf volumesOf) {
        const std::pair key(dials.lod, volumesOf);
        auto found = assembled.find(key);
        if (found == assembled.end()) {
            scene.dials.lod = dials.lod;
            const std::size_t left = memoryLeft(options.memory, fields, slides.bytes());
            found = assembled.emplace(key, assemble(scene, fields, options.crop, left, volumesOf)).first;
        }
        ViewScene turned = found->second;
        turned.dials = dials;
        turned.layers.clear();  // what is studied is the beauty
        return turned;
    };
    const auto sceneWith = [&](const Dials& dials) { return assembledWith(dials, VolumesOf::picture); };
    const Dials base = scene.dials;
    StudyOptions studyOptions;
    studyOptions.budget = options.budget;
    studyOptions.truth = [&](const Dials& dials) { return assembledWith(dials, VolumesOf::scene); };
    const ResultFolder folder(options.output);
    progress.beginFrame(input.frames().front());
    const Study study = runStudy(sceneWith, base, studyOptions, progress.stage(0, 1));
    progress.endFrame();

    const std::string name = std::filesystem::path(input.name()).filename().string();
    folder.write("study.csv", studyAsCsv(study));
    folder.write("study.json", studyAsJson(study, name));
    folder.write("index.html", studyAsHtml(study, name, colour));
    if (!options.quiet) printOut(tableOf(study));
    console.line(fmt::format("{}: study.csv, study.json, index.html", folder.path()));
}

}  // namespace

void studyCommand(const SceneOptions& options) {
    TaskArena(options.threads).run([&] { study(options); });
}

}  // namespace scrim::cli
