// SPDX-License-Identifier: Apache-2.0
// Options for opening and rendering shots.
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
    std::optional<Int2> resolution;  ///< replaces the scene's resolution; an asset is framed for it
    std::optional<Vec3> wsUp;        ///< up direction of an asset's world: a unit vector along an axis; none: guessed
    int turntable = 0;               ///< the camera circles its target once in frames 1 to this number; 0: it does not
    LoadOptions load;                ///< how volume files are read
    int checkedFrame = 1;            ///< the frame at which the scene is checked when it is opened
    /// A [[volume]] may name neither file nor source, because Shot::setVolume gives its grids.
    bool gridsFromCode = false;
    /// [output] may say how a deep picture is written without naming one, because it is named elsewhere.
    bool deepFromCode = false;
    /// If given, the new shot shares the colour config, the volumes and the slides of that shot, and files that both
    /// show are loaded once. The two shots are then not independent and must be used from one thread.
    const Shot* shareWith = nullptr;
};

/// The treatment of a frame for which the file of a volume is missing.
enum class MissingPolicy {
    error,  ///< throws Error(input)
    black,  ///< the volume shows nothing
    skip,   ///< the frame is not rendered
};

/// The plan of a frame, made before anything is rendered.
struct ShotPlan {
    bool skipped = false;        ///< MissingPolicy::skip skipped the frame; all else is then empty
    std::string json;            ///< the plan as one JSON object
    std::string table;           ///< the same as several lines of text for people
    std::size_t fieldBytes = 0;  ///< memory of the volumes
    double seconds = 0;          ///< a rough time of the render; right within a factor of about three
    /// The error that the preset promises, and the largest that is expected, relative; 0: the scene states its dials.
    double promised = 0, expected = 0;
};

/// Stands for all pixels.
constexpr int kVerifyAll = std::numeric_limits<int>::max();

struct RenderOptions {
    std::optional<PixelWindow> crop;  ///< restricts the render to these pixels (display window coordinates)
    int threads = 0;                  ///< number of threads; 0: as many as the caller has
    std::size_t memory = 0;           ///< limit in bytes for volumes, slides and buffers; 0: none
    MissingPolicy missing = MissingPolicy::error;

    /// The frame that will be rendered next. Its files are read while this frame renders, if loading is guarded and
    /// memory suffices for both. This has no other effect: errors and messages appear with the frame they belong to.
    std::optional<int> next;

    /// Number of random pixels that are compared with brute force; kVerifyAll: all that may show something.
    int verify = 0;
    double verifyLimit = 0;           ///< seconds after which a verification ends; 0: no limit
    std::optional<double> tolerance;  ///< relative RMSE; replaces the scene's tolerance; 0: none

    /// A preset chooses dials for each frame by itself, in place of one set for all frames of the shot.
    bool dialsOfEachFrame = false;

    double previewExposure = 0;  ///< stops by which the preview is brighter than the picture

    /// Receives the finished fraction of the frame, 0 to 1. If it returns false, the work ends with Error(interrupted).
    ProgressSink progress;
    /// Called often while files are loaded and sources run; it may throw an Error to stop the work.
    /// Without one, `progress` is called with 0 instead.
    Checkpoint checkpoint;
    /// Receives warnings and notes.
    MessageSink messages;

    /// Receives the picture while it is made: premultiplied, scene-linear, in the working space.
    /// With a tolerance it receives each attempt, with motion blur the mean of the moments so far.
    PictureSink shown;

    /// Changes the scene before the files that it names are loaded.
    std::function<void(Scene&)> change;
    /// Receives each plan before it is rendered. A tolerance may render several.
    std::function<void(const ShotPlan&)> planned;
    /// Called half a second after a verification begins, with the expected number of seconds.
    std::function<void(double)> announce;
};

}  // namespace scrim
