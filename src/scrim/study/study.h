// SPDX-License-Identifier: Apache-2.0
// Measures what accuracy costs on a scene: settings of the dials are rendered, timed and compared
// with the brute-force reference.
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

/// The scene under other dials. It is a function, since `lod` makes other fields from the same file.
using SceneWith = std::function<ViewScene(const Dials&)>;

struct StudyOptions {
    double budget = 0;      ///< seconds after which the study stops with what it has; 0: none
    int mostPixels = 1000;  ///< largest number of reference pixels
    /// Relative to the error: no pixels are added once half the 95 % interval is this narrow.
    double intervalWanted = 0.1;
    int repeats = 5;                                       ///< renders of every setting, interleaved; the median counts
    int mostPictures = 4;                                  ///< largest number of error pictures
    std::function<Dials(const std::string&)> preset = {};  ///< the dials of a preset in this scene; none: presetDials
    /// The scene with all volumes, including those that a picture has no use for; none: the scene as rendered.
    SceneWith truth = {};
};

/// A picture's difference from the most accurate one of the study.
struct ErrorPicture {
    std::string name;
    std::size_t trial = 0;
    Image difference;  ///< signed, R, G, B; alpha is that of the most accurate picture
};

struct Study {
    std::vector<Trial> trials;  ///< the first is the scene's own setting
    std::vector<DialSweep> sweeps;
    std::vector<std::pair<std::string, std::size_t>> presets;  ///< name and trial, from fast to accurate
    std::vector<std::size_t> front;                            ///< trials, from fast to accurate
    int pixels = 0;                                            ///< number of reference pixels
    double meanReference = 0;                                  ///< mean of the reference, which errors are relative to
    std::size_t best = 0;                                      ///< the most accurate trial
    Image picture;                                             ///< picture of the most accurate trial
    std::vector<ErrorPicture> errorPictures;
    double spent = 0;        ///< seconds
    bool outOfTime = false;  ///< the budget ended the study
    int threads = 0;
};

/// Studies the scene around the dials `base`. Throws Error: as rendering does, and of kind render
/// where the picture is empty.
Study runStudy(const SceneWith& sceneWith, const Dials& base, const StudyOptions& options,
               const ProgressSink& progress = {});

/// The cheapest trial within a tolerance.
struct Recommendation {
    double tolerance = 0;
    std::optional<std::size_t> trial;
};
std::vector<Recommendation> recommendations(const Study& study);

/// The effect on error and time of setting a dial one value finer or coarser than in the scene.
struct DialWorth {
    std::string dial;
    std::optional<std::size_t> finer, coarser;  ///< trials
    std::string verdict;                        ///< a sentence with numbers
};
std::vector<DialWorth> worthOfDials(const Study& study);

}  // namespace scrim
