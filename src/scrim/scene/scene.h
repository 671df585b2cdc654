// SPDX-License-Identifier: Apache-2.0
// A scene at one frame: checked, keyed values evaluated, colours in the working space, paths expanded; no
// file but the scene itself was touched. Plain structs, so that whoever builds a scene in code needs no TOML.
#pragma once

#include <scrim/geometry/camera.h>
#include <scrim/geometry/spaces.h>
#include <scrim/scene/light.h>
#include <scrim/scene/dials.h>
#include <scrim/scene/frame_path.h>
#include <scrim/scene/keyed.h>
#include <scrim/scene/scene_lines.h>
#include <scrim/scene/classified.h>
#include <scrim/scene/medium.h>
#include <scrim/solid/triangle_mesh.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

struct DepthPicture;

/// Pictures beside the beauty.
enum class Layer { light, ambient, emission, albedo, depth, transmittance, shadow, volume, motion };

/// What a volume shows at frames before the first or after the last file of its sequence.
enum class OutsidePolicy {
    error,  ///< nothing: a missing file is an error
    hold,   ///< the first or last file
    black,  ///< no volume
};

/// Which file of its sequence a volume shows.
struct FrameMap {
    double speed = 1, offset = 0;
    Keyed<double> keys = {};  ///< frame to file number, in place of `speed`; empty: none

    /// (keys or frame * speed) + offset, to the nearest whole number.
    double fileAt(double frame) const;
    /// A frame that shows the file; none where there is none.
    std::optional<int> frameOf(int file) const;
};

/// A colour that grids give from place to place.
struct ColourGrid {
    std::string grid;           ///< as GridRequest names colours
    double scale = 1;           ///< times this
    Mat3 workingFromGrid{1.0};  ///< from the grid's colour space to the working space
    std::string where;          ///< of the grid's name in the scene
};

/// What moves a volume while the shutter is open.
struct Velocity {
    std::vector<std::string> grids;  ///< one as GridRequest names velocities, or three scalar ones: x, y, z
    double scale = 1;                ///< grid value to world units of the asset, a second or a frame
    bool perSecond = true;
    std::string where;  ///< of the grid's name in the scene

    /// Grid value to world units of the asset a frame.
    double perFrame(double fps) const { return perSecond ? scale / fps : scale; }
};

/// While the camera sees, in frames about the frame.
struct Shutter {
    double open = 0, close = 0;  ///< open < close
};

/// Light that a medium sends out by itself. It lights only volumes in which light scatters more than once.
struct Emission {
    std::string grid;
    /// Grid value to radiance per world unit, ascending and linear between; constant outside, but 0 where the grid is.
    /// Empty: the value itself, in white. A blackbody is a ramp, too, with a point every few Kelvin.
    std::vector<std::pair<double, Rgb>> ramp;
    double scale = 1;                          ///< times this
    bool blackbody = false;                    ///< for what is said about it
    double kelvinScale = 1, kelvinOffset = 0;  ///< black bodies: kelvin = grid value * scale + offset
    std::string where;                         ///< of the grid's name in the scene
};

struct SceneVolume {
    std::string name;
    FramePath sequence;      ///< file volumes: the path before the frame is put in
    std::string file;        ///< file volumes: the path at this frame; empty for a source
    int frame = 0;           ///< the number put into `file`
    FrameMap frameMap = {};  ///< where that comes from
    OutsidePolicy outside = OutsidePolicy::error;
    std::string source;                                           ///< name of a volume source; empty for a file
    std::vector<std::pair<std::string, std::string>> parameters;  ///< of the source, as text; `file`: as above
    Mat4 wsFromAsset{1.0};                                        ///< takes the asset's own world space to the scene's
    std::string densityGrid;                                      ///< as VdbFile::field takes it; "": choose
    double densityScale = 1;                         ///< extinction per world unit = ramp(grid value) * densityScale
    std::vector<std::pair<double, double>> ramp;     ///< grid value to value, ascending; constant outside; empty: none
    Medium medium;                                   ///< its densityScale is the one above
    std::optional<ColourGrid> albedoGrid;            ///< instead of medium.albedo
    std::vector<Emission> emission;                  ///< of a medium; they add up
    std::optional<Velocity> velocity = {};           ///< of all of its grids
    std::optional<std::vector<std::string>> lights;  ///< names of those that light it; none: all
    std::shared_ptr<const Classified> classified = nullptr;  ///< shaded so instead; its densityScale is the one above
    bool holdout = false;                                    ///< hides and shadows, and adds neither colour nor alpha
    std::string where;                                       ///< of `file` or `source` in the scene: "scene.toml:12:8"
};

/// A solid of triangles.
struct SceneMesh {
    std::string name;
    FramePath sequence;  ///< the path before the frame is put in
    std::string file;    ///< at this frame
    Mat4 wsFromMesh{1.0};
    bool holdout = true, shadows = true, catches = false;  ///< see Solid
    std::string where;                                     ///< of `file` in the scene: "scene.toml:12:8"
    std::shared_ptr<const TriangleMesh> mesh = nullptr;    ///< null until it is loaded
};

struct ScenePreview {
    std::string file;  ///< at this frame; empty: no preview
    FramePath path;
    std::string display;  ///< "": the config's default
    std::string view;     ///< "": the display's default
};

/// A deep picture beside the flat one.
struct SceneDeep {
    std::string file;  ///< at this frame; empty: none
    FramePath path;
    double tolerance = 0.01;  ///< of merging samples: of alpha, and of colour as a part of the pixel's
    bool half = true;         ///< 16-bit colours, or else 32-bit; depths are 32-bit
};

/// A depth or deep picture of another renderer, which hides what is behind it.
struct SceneHoldout {
    std::string file;         ///< at this frame; empty: none
    std::string channel;      ///< of depths; "": the one that must be it
    bool alongRay = false;    ///< depths are distances along the pixel's ray, and not along the viewing axis
    double background = 1e9;  ///< from here on nothing is there; nor is there at 0 and below, and where is no number
    bool dataWindow = false;  ///< its data window is the picture, whatever its display window says
    std::string where;        ///< of its path in the scene
    std::shared_ptr<const DepthPicture> picture = nullptr;  ///< null until it is loaded
};

struct SceneOutput {
    std::string file;        ///< at this frame; empty where the scene names none
    FramePath path;          ///< before the frame is put in
    std::string colorspace;  ///< the config's own name of it
    bool half = true;        ///< 16-bit channels, or else 32-bit
    std::string compression = "zip";
    double fps = 24;
    std::vector<Layer> layers;  ///< each at most once, in the order of the enumeration
    ScenePreview preview;
    SceneDeep deep;
    SceneHoldout holdout;
};

/// What the picture's normalised device coordinates are over its width and height.
enum class NdcRange { automatic, symmetric, unit };  // -1..1, 0..1

/// A picture whose header says what camera made it.
struct PlateCamera {
    std::string file;   ///< at this frame
    std::string where;  ///< in the scene
    NdcRange ndc = NdcRange::automatic;
    bool givesResolution = true;  ///< the scene says none
};

struct Scene {
    std::string file;  ///< where the scene comes from, as in error messages
    double frame = 1;
    Camera camera;
    std::optional<PlateCamera> plate =
        {};                            ///< that `camera` is read from when a shot is loaded; till then it has `near`
    int overscan = 0;                  ///< pixels added on every side of the picture
    std::vector<SceneVolume> volumes;  ///< at least one
    std::vector<SceneMesh> meshes = {};
    std::vector<Light> lights;
    Rgb ambient{0};  ///< radiance of an unshadowed environment
    Dials dials;
    bool moves = false;                   ///< does its text have keys, or a camera from frames?
    bool movesOn = false;                 ///< may its text tell where things are a frame later?
    std::optional<Shutter> shutter = {};  ///< none: the picture is that of one moment
    bool movesWithin = false;             ///< does any of its text's keys change a value while the shutter is open?
    std::string quality = "standard";     ///< the preset that `dials` started from
    /// Are texels and sheets to be chosen for what the preset promises? Not where the scene gives either.
    bool keepsPromise = false;
    double tolerance = 0;  ///< relative RMSE that texels and sheets are to be chosen for; 0: as `dials` say
    SceneOutput output;
    std::vector<std::string> warnings = {};  ///< of the reader, each with its place
    /// Where the scene's text says what: "light.key.shadows" is at "scene.toml:12:3". Null for one built in code.
    std::shared_ptr<const SceneLines> lines = nullptr;
};

}  // namespace scrim
