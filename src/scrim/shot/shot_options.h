// SPDX-License-Identifier: Apache-2.0
// How shots are opened and rendered.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/geometry/spaces.h>
#include <scrim/image/image.h>
#include <scrim/scene/scene.h>
#include <scrim/guard/load_options.h>

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <string>

namespace scrim {

class Shot;

struct OpenOptions {
    std::string ocio;                ///< path of an OpenColorIO config; "": $OCIO, or else Scrim's own
    std::optional<Int2> resolution;  ///< in place of the scene's; an asset is framed for it
    std::optional<Vec3> wsUp;        ///< of an asset's world: a unit vector along an axis; none: guessed
    int turntable = 0;               ///< in frames 1 to this the camera goes once around its target; 0: it does not
    LoadOptions load;                ///< how volume files are read
    int checkedFrame = 1;            ///< the scene is checked at this frame when it is opened
    bool gridsFromCode = false;      ///< a [[volume]] may name neither file nor source: Shot::setVolume gives its grids
    /// The new shot shares the colour config, the volumes and the slides of this one, if it is given: what both show is
    /// loaded once. Then the two are not independent; use them from one thread.
    const Shot* shareWith = nullptr;
};

/// What becomes of a frame that lacks the file of a volume.
enum class MissingPolicy {
    error,  ///< Error(input)
    black,  ///< the volume shows nothing
    skip,   ///< the frame is not rendered
};

/// What is planned of a frame, before anything is rendered.
struct ShotPlan {
    bool skipped = false;        ///< by MissingPolicy::skip; the rest is empty then
    std::string json;            ///< the plan as one JSON object
    std::string table;           ///< the same to read, several lines
    std::size_t fieldBytes = 0;  ///< memory of the volumes
};

/// As many pixels as there are.
constexpr int kVerifyAll = std::numeric_limits<int>::max();

struct RenderOptions {
    std::optional<PixelWindow> crop;  ///< render these pixels only (display window coordinates)
    int threads = 0;                  ///< 0: as many as the caller has
    std::size_t memory = 0;           ///< bytes for volumes, slides and buffers; 0: no limit
    MissingPolicy missing = MissingPolicy::error;

    /// The frame that is rendered next. What it needs of files is read while this one renders, where loading is guarded
    /// and the memory suffices for both. Nothing else depends on it: errors and messages come with the frame they
    /// belong to.
    std::optional<int> next;

    int verify = 0;                   ///< compares so many random pixels with brute force; kVerifyAll: all that matter
    double verifyLimit = 0;           ///< seconds after which a verification ends; 0: none
    std::optional<double> tolerance;  ///< relative RMSE, in place of the scene's; 0: none

    double previewExposure = 0;  ///< stops by which the preview is brighter than the picture

    /// Hears the finished part of the frame, 0 to 1. Where it returns false, the work ends with Error(interrupted).
    ProgressSink progress;
    /// Called often while files are loaded and sources run; throw an Error to stop. None: `progress` is asked, with 0.
    Checkpoint checkpoint;
    /// Hears warnings and notes.
    MessageSink messages;

    /// Hears of the picture while it is made: premultiplied, scene-linear, in the working space. With a tolerance of
    /// each that is tried; of a moving one of the mean of the moments so far.
    PictureSink shown;

    /// Changes the scene before anything that it names is loaded.
    std::function<void(Scene&)> change;
    /// Hears each plan before it is rendered. A tolerance may try several.
    std::function<void(const ShotPlan&)> planned;
    /// Hears, half a second after a verification began, how many seconds it will take.
    std::function<void(double)> announce;
};

}  // namespace scrim
