// SPDX-License-Identifier: Apache-2.0
// What accuracy costs on a scene: settings of the dials rendered, timed and compared with the brute-force reference.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/scene/view_scene.h>
#include <scrim/study/dial_sweep.h>
#include <scrim/study/trial.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

/// The scene under other dials: `lod` makes other fields of the same file, so a scene cannot simply be turned.
using SceneWith = std::function<ViewScene(const Dials&)>;

struct StudyOptions {
    double budget = 0;            ///< seconds after which to stop with what there is; 0: none
    int mostPixels = 1000;        ///< of the reference, at most
    double intervalWanted = 0.1;  ///< of the error: stop adding pixels where half the 95 % interval is this narrow
    int repeats = 5;              ///< of every render, interleaved; the median counts
    int mostPictures = 4;         ///< error pictures
    std::function<Dials(const std::string&)> preset = {};  ///< what a preset is in this scene; none: presetDials
    SceneWith truth = {};  ///< with all volumes, those too that a picture has no use for; none: as rendered
};

/// A picture's distance from the most accurate one of the study.
struct ErrorPicture {
    std::string name;
    std::size_t trial = 0;
    Image difference;  ///< signed, R, G, B; alpha of the most accurate
};

struct Study {
    std::vector<Trial> trials;  ///< the scene's own setting first
    std::vector<DialSweep> sweeps;
    std::vector<std::pair<std::string, std::size_t>> presets;  ///< name and trial, fast to accurate
    std::vector<std::size_t> front;                            ///< trials, fast to accurate
    int pixels = 0;                                            ///< of the reference
    double meanReference = 0;                                  ///< what errors are relative to
    std::size_t best = 0;                                      ///< the most accurate trial
    Image picture;                                             ///< its picture
    std::vector<ErrorPicture> errorPictures;
    double spent = 0;        ///< seconds
    bool outOfTime = false;  ///< the budget ended it
    int threads = 0;
};

/// Around the dials `base`. Throws Error: as rendering does, and render where the picture is empty.
Study runStudy(const SceneWith& sceneWith, const Dials& base, const StudyOptions& options,
               const ProgressSink& progress = {});

/// What a tolerance takes: the cheapest trial within it.
struct Recommendation {
    double tolerance = 0;
    std::optional<std::size_t> trial;
};
std::vector<Recommendation> recommendations(const Study& study);

/// What one value finer, and one value coarser, than the scene's own does to error and time.
struct DialWorth {
    std::string dial;
    std::optional<std::size_t> finer, coarser;  ///< trials
    std::string verdict;                        ///< in words, with numbers
};
std::vector<DialWorth> worthOfDials(const Study& study);

}  // namespace scrim
