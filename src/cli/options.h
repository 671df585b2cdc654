// SPDX-License-Identifier: Apache-2.0
// The options that commands on scenes share, and the forms of their values.
#pragma once

#include "progress.h"

#include <scrim/geometry/spaces.h>
#include <scrim/image/image.h>
#include <scrim/shot/shot_options.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace scrim::cli {

/// How an OpenUSD stage is read; see `scrim.usd.open` in Python. "": the default given there.
struct UsdOptions {
    std::string camera, settings, purpose, sidecar, distant, meshes;
};

struct SceneOptions {
    std::vector<std::string> inputs;
    std::string output;              ///< "": the scene's output
    std::string deep;                ///< "": the scene's deep picture
    std::vector<std::string> files;  ///< names of all further files; empty: the scene's
    std::vector<int> frames;         ///< empty: not given
    std::optional<Int2> resolution;
    std::optional<PixelWindow> crop;
    std::string quality;
    std::vector<std::string> sets;  ///< key.path=value
    std::string dials;              ///< file of dials that replace the scene's; "": none
    int threads = 0;                ///< 0: all
    int jobs = 1;                   ///< frames that are rendered side by side
    std::size_t memory = 0;         ///< bytes; 0: no limit
    MissingPolicy missing = MissingPolicy::error;
    std::string ocio;
    UsdOptions usd;
    bool printScene = false;
    bool verbose = false, quiet = false;

    std::string stats, preview;
    std::string display;             ///< HOST:PORT of a viewer; "": none
    std::string view;                ///< view of the preview; "": the scene's
    bool annotate = false;           ///< previews with a scale bar and axes
    std::optional<double> exposure;  ///< exposure of the preview, stops
    std::optional<Vec3> wsUp;        ///< up direction of assets
    int turntable = 0;               ///< frames; 0: none
    bool skipExisting = false;
    ProgressStyle progress = ProgressStyle::automatic;
    int verify = 0;          ///< pixels; kAllPixels: all
    double verifyLimit = 0;  ///< seconds; 0: none
    double tolerance = 0;    ///< relative RMSE, replaces the quality; 0: not given

    std::string baked;                     ///< `scrim bake`: the file to write
    std::vector<std::string> bakedLights;  ///< `scrim bake`: names of lights; empty: all
    bool emission = false;
    bool indirect = false;

    bool json = false;       ///< for `scrim plan`
    std::string writeDials;  ///< `scrim plan`: the file to write; "": none
    double budget = 0;       ///< for `scrim study` and `scrim render`: seconds; 0: none
    bool steady = false;     ///< for `scrim study`
};

/// Adds the options that decide what is rendered, for `render` and `plan`. `options` must outlive the parse.
void addSceneOptions(CLI::App& command, SceneOptions& options);
/// Adds the options about the results of `render`. `group` is their title in the help.
void addRenderOptions(CLI::App& command, SceneOptions& options, const std::string& group);
/// Adds the options of `render` alone.
void addBudget(CLI::App& command, SceneOptions& options);
void addJobs(CLI::App& command, SceneOptions& options);
/// Adds the options of `plan` alone.
void addPlanOptions(CLI::App& command, SceneOptions& options);
/// Adds the options of `study`.
void addStudyOptions(CLI::App& command, SceneOptions& options);
/// Adds the options of `bake`.
void addBakeOptions(CLI::App& command, SceneOptions& options);
/// Adds -v and -q.
void addVerbosity(CLI::App& command, bool& verbose, bool& quiet);

/// The number of threads in SLURM_CPUS_PER_TASK if the program runs in a Slurm job, since Slurm does not bind jobs to
/// processors everywhere; else 0. Processors that the job is bound to are respected in any case (TaskArena).
int threadsOfJob();

/// "8G", "512M", "64K" (powers of 1024), or bytes. Throws Error(usage), as do all of these.
std::size_t parseSize(const std::string& text);
/// "1920x1080".
Int2 parseResolution(const std::string& text);
/// "z", "-y".
Vec3 parseAxis(const std::string& text);
/// "X0,Y0,X1,Y1": the half-open box from (X0, Y0) to (X1, Y1).
PixelWindow parseCrop(const std::string& text);

}  // namespace scrim::cli
