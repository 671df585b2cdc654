// SPDX-License-Identifier: Apache-2.0
// Shots and jobs.
#include "bindings.h"

#include <scrim/base/atomic_file.h>
#include <scrim/base/parallel.h>
#include <scrim/scene/frame_path.h>
#include <scrim/shot/shot_frame.h>
#include <scrim/study/shot_study.h>
#include <scrim/study/study_data.h>
#include <scrim/study/study_page.h>
#include <scrim/volume/grid_edit.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <tuple>

#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

namespace scrim::python {
namespace {

using Window = std::tuple<int, int, int, int>;

/// A render that is under way. It occupies the shot until it ends.
struct Job {
    std::shared_ptr<std::optional<ShotFrame>> made = std::make_shared<std::optional<ShotFrame>>();
    std::unique_ptr<Work> work;
    nb::object frame;  // set when somebody first asks for it
};

struct Plan {
    ShotPlan plan;
};

MissingPolicy missingFrom(const std::string& word) {
    if (word == "error") return MissingPolicy::error;
    if (word == "black") return MissingPolicy::black;
    if (word == "skip") return MissingPolicy::skip;
    throw Error(ErrorKind::usage,
                "missing='" + shortened(word, 80) + "': expected " + choices({"error", "black", "skip"}));
}

int verifyFrom(nb::handle it) {
    if (nb::isinstance<nb::str>(it) && textOf(it, "verify") == "all") return kVerifyAll;
    int pixels = -1;
    if (!nb::try_cast<int>(it, pixels) || pixels < 0)
        throw Error(ErrorKind::usage, shortened(nb::cast<std::string>(nb::str(nb::repr(it))), 80) +
                                          ": expected how many pixels to verify, or 'all'");
    return pixels;
}

RenderOptions optionsFrom(const std::optional<Window>& crop, int threads, std::size_t memory,
                          const std::string& missing, nb::handle verify, double verifyLimit,
                          std::optional<double> tolerance, std::optional<int> next, double previewExposure) {
    RenderOptions options;
    if (threads < 0) throw Error(ErrorKind::usage, "threads: expected 0 (all), or how many");
    if (tolerance && !(*tolerance > 0 && *tolerance < 1))
        throw Error(ErrorKind::usage, "tolerance: expected a relative error between 0 and 1, such as 0.005");
    if (crop) {
        const auto& [x0, y0, x1, y1] = *crop;
        if (x1 <= x0 || y1 <= y0)
            throw Error(ErrorKind::usage, "crop: expected x0, y0, x1, y1 in pixels with x0 < x1 and y0 < y1");
        options.crop = PixelWindow{x0, y0, x1, y1};
    }
    options.threads = threads;
    options.memory = memory;
    options.missing = missingFrom(missing);
    options.verify = verifyFrom(verify);
    options.verifyLimit = verifyLimit;
    options.tolerance = tolerance;
    options.next = next;
    options.previewExposure = previewExposure;
    return options;
}

void listen(RenderOptions& options, Work& work) {
    options.progress = work.progressSink();
    options.checkpoint = work.checkpoint();
    options.messages = work.messageSink();
}

std::shared_ptr<Job> start(const ShotObject& object, int frame, RenderOptions options) {
    auto job = std::make_shared<Job>();
    auto busy = std::make_shared<Busy>(object.state, "frame " + std::to_string(frame));
    job->work = std::make_unique<Work>([made = job->made, busy, frame, options](Work& work) mutable {
        listen(options, work);
        const auto held = std::exchange(busy, nullptr);  // released as soon as this scope ends
        made->emplace(held->shot().render(frame, options));
    });
    return job;
}

nb::object resultOf(Job& job, nb::handle progress) {
    await(*job.work, progress);
    job.work->rethrow();
    if (!job.frame.is_valid()) job.frame = toPython(std::move(**job.made));
    return job.frame;
}

Plan planOf(const ShotObject& object, int frame, RenderOptions options) {
    const auto busy = std::make_shared<Busy>(object.state, "a plan");
    Plan plan;
    doAndWait([&](Work& work) {
        listen(options, work);
        plan.plan = busy->shot().plan(frame, options);
    });
    return plan;
}

std::string tomlOf(const ShotObject& object, nb::handle overrides) {
    const Busy busy(object.state, "its text");
    const std::vector<std::string> more = assignmentsOf(overrides);
    std::string text;
    doAndWait([&](Work& work) {
        RenderOptions options;
        listen(options, work);
        text = busy.shot().toml(more, options);
    });
    return text;
}

void setVolume(const ShotObject& object, nb::handle volume, nb::handle grids) {
    const std::string name = textOf(volume, "the name of a volume");
    const nb::object fields = nb::module_::import_("scrim._grids").attr("fields_of")(grids);
    std::vector<SparseField> all;
    for (const nb::handle field : fields)
        for (const SparseField& grid : nb::cast<const Field&>(field).grids) all.push_back(grid);
    const Busy busy(object.state, "its volumes");
    std::vector<std::string> names;
    for (const SceneVolume& one : busy.shot().opened().volumes) names.push_back(one.name);
    if (std::find(names.begin(), names.end(), name) == names.end())
        throw Error(ErrorKind::usage, busy.shot().path() + ": there is no volume '" + shortened(name, 80) +
                                          "'; there is " + choices(names));
    if (all.empty()) throw Error(ErrorKind::usage, "volume '" + name + "': expected at least one grid");
    busy.shot().setVolume(name, std::move(all));
}

void set(const ShotObject& object, nb::handle overrides) {
    const std::vector<std::string> more = assignmentsOf(overrides);
    const Busy busy(object.state, "its values");
    doAndWait([&](Work&) { busy.shot().set(more); });
}

/// The expressions of a volume, and the values of its parameters at the frame at which the scene was read: those of a
/// source as text.
nb::tuple codeOf(const ShotObject& object, const std::string& name) {
    std::string code;
    nb::dict values;
    for (const SceneVolume& volume : object.shot().opened().volumes) {
        if (volume.name != name) continue;
        for (const auto& [key, value] : volume.parameters) values[key.c_str()] = value;
        if (!volume.edit) break;
        for (const AxCode& program : volume.edit->programs) code += program.text;
        for (const AxVariable& variable : volume.edit->variables) {
            if (variable.value.size() == 1)
                values[variable.name.c_str()] = variable.value.front();
            else
                values[variable.name.c_str()] = nb::cast(variable.value);
        }
    }
    return nb::make_tuple(code, values);
}

/// What a volume is put together from, as the key `grids` says it, with absolute paths.
nb::dict gridsOf(const ShotObject& object, const std::string& name) {
    nb::dict out;
    for (const SceneVolume& volume : object.shot().opened().volumes) {
        if (volume.name != name || !volume.edit) continue;
        for (const CombinedGrid& grid : volume.edit->grids) {
            nb::list parts;
            for (const CombinedGrid::Part& part : grid.parts) {
                const FramePath& file = volume.sequences[part.file];
                parts.append(absolutePattern(file.folder, file.pattern) + (part.grid.empty() ? "" : ":" + part.grid));
            }
            constexpr const char* kHow[] = {"", "max", "add", "multiply"};
            nb::dict combined;
            combined[kHow[std::size_t(grid.how)]] = parts;
            const bool copied = grid.how == CombinedGrid::How::copied;
            out[grid.name.c_str()] = copied ? nb::object(parts[0]) : nb::object(combined);
        }
    }
    return out;
}

void writeStudy(const std::string& folder, const Study& study, const std::string& name, const Shot& shot) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw Error(ErrorKind::output, "cannot make the folder '" + folder + "': " + error.message());
    const auto write = [&](const char* file, const std::string& text) {
        writeWholeFile((std::filesystem::path(folder) / file).string(), text);
    };
    write("study.csv", studyAsCsv(study));
    write("study.json", studyAsJson(study, name));
    write("index.html", studyAsHtml(study, name, shot.colour()));
}

nb::object studyOf(const ShotObject& object, int frame, nb::handle folder, double budget, int threads,
                   nb::handle progress) {
    const Busy busy(object.state, "a study");
    const std::string path = folder.is_none() ? "" : pathText(folder);
    if (threads < 0) throw Error(ErrorKind::usage, "threads: expected 0 (all), or how many");
    std::string json;
    doAndWait(
        [&](Work& work) {
            TaskArena(threads).run([&] {
                RenderOptions options;
                options.checkpoint = work.checkpoint();
                options.messages = work.messageSink();
                const std::string name = std::filesystem::path(busy.shot().path()).filename().string();
                const Study study = ShotStudy(busy.shot(), frame, options).run(budget, work.progressSink());
                json = studyAsJson(study, name);
                if (!path.empty()) writeStudy(path, study, name, busy.shot());
            });
        },
        progress);
    return fromJson(json);
}

void bindPlans(nb::module_& module) {
    nb::class_<Plan>(module, "Plan", "What rendering a frame would do. `print(plan)` shows it.")
        .def_prop_ro(
            "skipped", [](const Plan& p) { return p.plan.skipped; }, "Whether missing='skip' leaves the frame out.")
        .def_prop_ro(
            "data", [](const Plan& p) { return p.plan.json.empty() ? nb::dict() : fromJson(p.plan.json); },
            nb::sig("def data(self) -> dict[str, typing.Any]"), "Effects, groups, sheets, rasters, work.")
        .def_prop_ro(
            "field_bytes", [](const Plan& p) { return p.plan.fieldBytes; }, "Memory of the volumes, in bytes.")
        .def("__str__", [](const Plan& p) { return p.plan.table; });
}

void bindJobs(nb::module_& module) {
    nb::class_<Job>(module, "Job", R"(A render under way in a thread of its own: `shot.start(7)`.

A job that nobody refers to any more is cancelled.)")
        .def_prop_ro(
            "progress", [](const Job& job) { return job.work->progress(); }, "The finished part, 0 to 1.")
        .def_prop_ro(
            "done", [](const Job& job) { return job.work->done(); }, "Whether it has ended, one way or another.")
        .def(
            "cancel", [](Job& job) { job.work->cancel(); },
            "Asks it to stop. It ends soon after, and `result` raises Cancelled.")
        .def(
            "wait",
            [](Job& job, std::optional<double> timeout, nb::handle progress) {
                return await(*job.work, progress, timeout);
            },
            nb::arg("timeout") = nb::none(), nb::arg("progress") = nb::none(),
            nb::sig("def wait(self, timeout: float | None = None, progress: collections.abc.Callable[[float], object] "
                    "| None "
                    "= None) -> bool"),
            "Waits for the end, at most `timeout` seconds: whether it came. What `progress` raises, and Ctrl-C, "
            "cancels "
            "the job.")
        .def("result", &resultOf, nb::arg("progress") = nb::none(),
             nb::sig(
                 "def result(self, progress: collections.abc.Callable[[float], object] | None = None) -> Frame | None"),
             "Waits for the frame; None where it was skipped. Raises what the render raised.");
}

constexpr const char* kRenderSignature =
    "crop: tuple[int, int, int, int] | None = None, threads: int = 0, memory: int = 0, missing: str = 'error', verify: "
    "int | "
    "str = 0, verify_limit: float = 0.0, tolerance: float | None = None, next: int | None = None, preview_exposure: "
    "float = "
    "0.0";

constexpr const char* kRenderText = R"(

`crop`: x0, y0, x1, y1, the pixels to render.  `threads`: 0 for all; pixels do not depend on it.
`memory`: bytes for volumes, slides and buffers, 0 for any.  `missing`: 'error', 'black' or 'skip' where a volume has no
file.
`verify`: compares so many random pixels (or 'all') with brute force, for `verify_limit` seconds at most.
`tolerance`: relative RMSE in place of the scene's.
`next`: the frame that is rendered next: its files are read meanwhile.
`preview_exposure`: stops by which previews are brighter.)";

/// Binds a method whose keywords are those of a render; `call` receives them as options.
template <typename Call, typename... More>
auto bindRender(nb::class_<ShotObject>& type, const char* name, const std::string& signature, const std::string& text,
                const Call& call, const More&... more) {
    type.def(name, call, nb::arg("frame") = 1, more..., nb::arg("crop") = nb::none(), nb::arg("threads") = 0,
             nb::arg("memory") = 0, nb::arg("missing") = "error", nb::arg("verify") = 0, nb::arg("verify_limit") = 0.0,
             nb::arg("tolerance") = nb::none(), nb::arg("next") = nb::none(), nb::arg("preview_exposure") = 0.0,
             nb::sig((signature).c_str()), (text + kRenderText).c_str());
}

void bindRenders(nb::class_<ShotObject>& type) {
    static const std::string signatures[] = {
        std::string(
            "def render(self, frame: int = 1, progress: collections.abc.Callable[[float], object] | None = None, *, ") +
            kRenderSignature + ") -> Frame | None",
        std::string("def start(self, frame: int = 1, *, ") + kRenderSignature + ") -> Job"};
    bindRender(
        type, "render", signatures[0],
        "Renders a frame; None where it is skipped. `progress` hears the finished part, 0 to 1, in this thread; what "
        "it "
        "raises cancels the render and is raised again, and so does Ctrl-C. Other threads of Python go on.",
        [](const ShotObject& object, int frame, nb::handle progress, const std::optional<Window>& crop, int threads,
           std::size_t memory, const std::string& missing, nb::handle verify, double verifyLimit,
           std::optional<double> tolerance, std::optional<int> next, double exposure) {
            const auto job =
                start(object, frame,
                      optionsFrom(crop, threads, memory, missing, verify, verifyLimit, tolerance, next, exposure));
            return resultOf(*job, progress);
        },
        nb::arg("progress") = nb::none(), nb::kw_only());
    bindRender(
        type, "start", signatures[1], "Starts to render a frame, and returns at once.",
        [](const ShotObject& object, int frame, const std::optional<Window>& crop, int threads, std::size_t memory,
           const std::string& missing, nb::handle verify, double verifyLimit, std::optional<double> tolerance,
           std::optional<int> next, double exposure) {
            return start(object, frame,
                         optionsFrom(crop, threads, memory, missing, verify, verifyLimit, tolerance, next, exposure));
        },
        nb::kw_only());
}

}  // namespace

void bindShots(nb::module_& module) {
    bindPlans(module);
    bindJobs(module);
    nb::class_<ShotObject> type(module, "Shot", R"(A scene or an asset, with all that its frames need: `scrim.open`.

Volumes and pictures are loaded when a frame needs them, and kept as long as the next one needs them, too. A shot does
one thing at a time; different shots are independent.)");
    type.def_prop_ro(
            "path", [](const ShotObject& s) { return pathObject(s.shot().path()); }, nb::sig("def path(self) -> str"),
            "As it was opened, or its name.")
        .def_prop_ro(
            "is_asset", [](const ShotObject& s) { return s.shot().isAsset(); },
            "Whether it is an asset that was framed.")
        .def_prop_ro(
            "frames", [](const ShotObject& s) { return s.shot().frames(); },
            "The frames for which its sequences have files, ascending; [1] without sequences.")
        .def_prop_ro(
            "volumes",
            [](nb::handle self) {
                nb::list names;
                for (const SceneVolume& volume : nb::cast<const ShotObject&>(self).shot().opened().volumes)
                    names.append(volume.name);
                return nb::module_::import_("scrim._volumes").attr("Volumes")(self, names);
            },
            nb::sig("def volumes(self) -> scrim._volumes.Volumes"),
            "Names of its volumes; `volumes['smoke']` is one of them, whose `ax`, `parameters` and `grids` can be set.")
        .def(
            "set", &set, nb::arg("overrides"),
            nb::sig("def set(self, overrides: collections.abc.Mapping[str, object] | collections.abc.Sequence[str]) -> "
                    "None"),
            "Overrides more values, as those of `open`, in all frames from now on. Raises InputError where the scene "
            "would be wrong then; it stays as it was.")
        .def("_code", &codeOf, nb::arg("name"))
        .def("_grids_of", &gridsOf, nb::arg("name"))
        .def("toml", &tomlOf, nb::arg("overrides") = nb::none(),
             nb::sig("def toml(self, overrides: collections.abc.Mapping[str, object] | collections.abc.Sequence[str] | "
                     "None = "
                     "None) -> str"),
             "The scene as TOML, with its overrides and these.")
        .def("set_volume", &setVolume, nb::arg("name"), nb::arg("grids"),
             nb::sig("def set_volume(self, name: str, grids: object) -> None"),
             "Gives a volume grids that were made in code, instead of those of its file or source, until the next "
             "call.\n\n"
             "`grids`: a Field, an OpenVDB grid, the path of a .vdb file, or a list of them. The scene chooses among "
             "them by "
             "their names.")
        .def(
            "plan",
            [](const ShotObject& object, int frame, std::size_t memory, const std::string& missing, int threads) {
                return planOf(object, frame, optionsFrom({}, threads, memory, missing, nb::int_(0), 0, {}, {}, 0));
            },
            nb::arg("frame") = 1, nb::kw_only(), nb::arg("memory") = 0, nb::arg("missing") = "error",
            nb::arg("threads") = 0, "What rendering the frame would do. `memory`: bytes that there are, 0 for any.")
        .def(
            "study", &studyOf, nb::arg("frame") = 1, nb::arg("folder") = nb::none(), nb::kw_only(),
            nb::arg("budget") = 0.0, nb::arg("threads") = 0, nb::arg("progress") = nb::none(),
            nb::sig(
                "def study(self, frame: int = 1, folder: str | os.PathLike[str] | None = None, *, budget: float = 0.0, "
                "threads: int = 0, progress: collections.abc.Callable[[float], object] | None = None) -> dict[str, "
                "typing.Any]"),
            "Accuracy against time: settings of the dials rendered, timed and compared with brute force.\n\n`folder`: "
            "where "
            "study.csv, study.json and index.html go; None: nowhere. `budget`: seconds, 0 for as many as it takes.")
        .def("__repr__", [](const ShotObject& s) { return pathObject("<scrim.Shot '" + s.shot().path() + "'>"); });
    bindRenders(type);
    bindLooking(module, type);
}

}  // namespace scrim::python
