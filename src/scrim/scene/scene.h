// SPDX-License-Identifier: Apache-2.0
// Plain structs that describe a scene at one frame. Values are checked, keyed values are evaluated,
// colours are in the working space and paths are expanded; no file was read but the
// scene's own, and those of expressions. Whoever builds a scene in code fills
// these structs and needs no TOML.
#pragma once

#include <scrim/geometry/camera.h>
#include <scrim/geometry/half_space.h>
#include <scrim/geometry/spaces.h>
#include <scrim/scene/light.h>
#include <scrim/scene/dials.h>
#include <scrim/scene/frame_path.h>
#include <scrim/scene/keyed.h>
#include <scrim/scene/scene_lines.h>
#include <scrim/scene/classified.h>
#include <scrim/scene/medium.h>
#include <scrim/solid/triangle_mesh.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

struct DepthPicture;
struct GridEdit;

/// Pictures that can be written beside the beauty.
enum class Layer {
    light,
    direct,
    indirect,
    ambient,
    emission,
    albedo,
    depth,
    transmittance,
    shadow,
    volume,
    motion,
    cryptomatte,
    backdrop
};

/// What a volume shows at frames before the first or after the last file of its sequence.
enum class OutsidePolicy {
    error,     ///< nothing: a missing file is an error
    hold,      ///< the first or last file
    black,     ///< no volume
    repeat,    ///< the sequence again, from its first file on
    pingPong,  ///< the sequence backwards, then forwards, and so on; its ends are shown once
};

/// What a volume shows where its number lies between those of two files.
enum class BetweenFiles {
    nearest,  ///< the file whose number is nearest
    blend,    ///< a mixture of both
    advect,   ///< the same, after each was carried there by its velocity
};

/// Maps a frame to the file of its sequence that a volume shows.
struct FrameMap {
    double speed = 1, offset = 0;
    Keyed<double> keys = {};  ///< maps frame to file number, in place of `speed`; empty: `speed` counts
    BetweenFiles between = BetweenFiles::nearest;

    /// (keys or frame * speed) + offset.
    double numberAt(double frame) const;
    /// The number of the file that is shown at `frame`: numberAt rounded to the nearest whole
    /// number, or, where files are mixed, the first of both.
    double fileAt(double frame) const;
    /// Where files are mixed: how far the frame is from that file on the way to the next one, 0 to
    /// less than 1. Otherwise 0.
    double beyondAt(double frame) const;
    /// A frame that shows file number `file`; none where no frame does.
    std::optional<int> frameOf(int file) const;
};

/// A sum of gradient noises (Perlin 2002), of which each octave is finer and fainter. It depends on
/// the place alone, so that it is the same in every frame, whatever the bounds of a grid.
struct Noise {
    double amount = 1;
    double frequency = 1;  ///< features per world unit, of the first octave
    int octaves = 4;
    double roughness = 0.5;  ///< amplitude of an octave relative to the one before
    double lacunarity = 2;   ///< frequency of an octave relative to the one before
    Vec3 offset{0};          ///< displaces the pattern, in world units
    double evolution = 0;    ///< changes the pattern in place; 1 makes a pattern that has nothing in common
    int seed = 0;
    bool inWorld = false;    ///< places are those of the scene, not of the asset
    std::string where = {};  ///< where the scene gives it: "scene.toml:12:8"

    bool operator==(const Noise&) const = default;
};

/// Maps one range of values to another. Values outside of the first count as its nearest limit.
struct Remap {
    std::array<double, 2> from{0, 1}, to{0, 1};  ///< `from` ascends
    double gamma = 1;                            ///< t of the range becomes t^(1 / gamma): above 1 lifts the middle
    double contrast = 1;  ///< above 1, values around the middle of the range move apart; both ends stay

    bool operator==(const Remap&) const = default;
    double at(double value) const;
};

/// A factor from another grid of the volume.
struct Mask {
    std::string grid;
    Remap remap;        ///< maps the grid's values to the factor
    std::string where;  ///< where the scene names the grid

    bool operator==(const Mask&) const = default;
};

/// How noise changes a density.
enum class NoiseMode {
    multiply,  ///< times 1 + amount * noise, and at least 0
    erode,     ///< minus amount * (1 + noise) / 2, and at least 0: thin places vanish first
};

/// The members are in the order in which shading applies them.
struct DensityShading {
    std::optional<Remap> remap = {};
    std::optional<std::array<double, 2>> edge = {};  ///< from the first value to the second, density fades in
    std::optional<Mask> mask = {};
    std::optional<Noise> noise = {};
    NoiseMode noiseMode = NoiseMode::multiply;

    bool operator==(const DensityShading&) const = default;
    bool any() const { return remap || edge || mask || noise; }
    /// The density of a voxel where the mask's grid and the noise have these values.
    double at(double density, double maskValue, double noiseValue) const;
};

/// A colour that varies in space and comes from grids.
struct ColourGrid {
    std::string grid;  ///< the grid's name, as GridRequest names colours
    double scale = 1;  ///< factor on the grid's values
    /// Not empty: the grid is a scalar one, whose values (ascending) this maps to colours; constant outside.
    std::vector<std::pair<double, Rgb>> ramp = {};
    Mat3 workingFromGrid{1.0};  ///< maps colours of the grid's colour space to the working space
    std::string where;          ///< where the scene names the grid: "file:line:column"
};

/// The grids and units by which a volume moves while the shutter is open.
struct Velocity {
    std::vector<std::string> grids;  ///< one as GridRequest names velocities, or three scalar ones: x, y, z
    double scale = 1;                ///< converts grid values to world units of the asset per second or per frame
    bool perSecond = true;
    std::string where;  ///< where the scene names the grid

    /// The factor that converts grid values to world units of the asset from one file to the next.
    double perFrame(double fps) const { return perSecond ? scale / fps : scale; }
};

/// The time during which the camera sees, in frames relative to the scene's frame.
struct Shutter {
    double open = 0, close = 0;  ///< open < close
};

/// Light that a medium emits. It lights only volumes in which light scatters more than once.
struct Emission {
    std::string grid;
    /// Maps grid values (ascending) to radiance per world unit: linear between points and constant
    /// outside of them, but always 0 where the grid is 0. An empty ramp emits the grid value
    /// itself, in `color`. A blackbody is stored as a ramp with a point every few Kelvin.
    std::vector<std::pair<double, Rgb>> ramp;
    Rgb color{1};                              ///< without a ramp: what a grid value of 1 emits
    double scale = 1;                          ///< factor on the ramp's values
    bool blackbody = false;                    ///< the scene said `blackbody`; only messages depend on it
    double kelvinScale = 1, kelvinOffset = 0;  ///< blackbodies: kelvin = grid value * scale + offset
    double physicalIntensity = 1;              ///< blackbodies: how much brightness depends on temperature, 0 to 1
    std::optional<Mask> mask = {};             ///< a factor on what is emitted
    std::string where;                         ///< where the scene names the grid
};

/// How a volume's grids are seen between their voxels.
enum class GridInterpolation {
    automatic,  ///< as Dials::kernel says
    linear,
    smooth,  ///< Kernel::bspline
};

struct SceneVolume {
    std::string name;
    FramePath sequence;  ///< file volumes: the path pattern, before the frame number is put in
    std::string file;    ///< file volumes: the path at this frame; empty for a source
    /// Volumes with `grids`: the patterns of all files, of which `sequence` is the first (GridEdit::files); else empty.
    std::vector<FramePath> sequences = {};
    int frame = 0;           ///< the file number that was put into `file`
    double beyond = 0;       ///< how far it shows what is between that number and the next one, 0 to less than 1
    FrameMap frameMap = {};  ///< how these follow from the scene's frame
    OutsidePolicy outside = OutsidePolicy::error;
    std::string source;  ///< name of a volume source; empty for a file
    /// Parameters of the source, as text; `file` is expanded as above.
    std::vector<std::pair<std::string, std::string>> parameters;
    std::shared_ptr<const GridEdit> edit = nullptr;  ///< what is done to the grids first (grid_edit.h); null: nothing
    std::vector<HalfSpace> clip = {};                ///< the volume ends at their faces; in the asset's own world
    Mat4 wsFromAsset{1.0};                           ///< maps the asset's own world space to the scene's
    std::string densityGrid;                         ///< a name as VdbFile::field takes it; "": the reader chooses
    std::string densityWhere = {};                   ///< where the scene names it; "": it does not
    double densityScale = 1;                         ///< extinction per world unit = ramp(grid value) * densityScale
    /// Maps grid values (ascending) to values; constant outside; empty: no ramp.
    std::vector<std::pair<double, double>> ramp;
    DensityShading shading = {};                           ///< is done to the density before its ramp
    std::optional<Noise> displacement = {};                ///< displaces all grids, before any other shading
    Medium medium;                                         ///< its densityScale does not count, but the member above
    std::optional<ColourGrid> albedoGrid;                  ///< replaces medium.albedo
    std::vector<Emission> emission;                        ///< sources of emission of a medium; they add up
    std::optional<Velocity> velocity = {};                 ///< moves all grids of the volume
    std::optional<std::vector<std::string>> lights;        ///< names of the lights that light it; none: all do
    std::optional<std::vector<std::string>> shadows = {};  ///< those in which it casts shadows; none: all
    /// Shades the volume in place of `medium`; its densityScale does not count, but the member above.
    std::shared_ptr<const Classified> classified = nullptr;
    GridInterpolation interpolation = GridInterpolation::automatic;
    bool holdout = false;  ///< hides what is behind it and casts shadows, but adds neither colour nor alpha
    std::string where;     ///< where the scene says `file`, `grids` or `source`: "scene.toml:12:8"

    /// As scattersFully of a view's volume, which also has voxels.
    bool scattersFully() const { return classified ? classified->scatters : medium.scattering == Scattering::full; }
};

/// A solid made of triangles.
struct SceneMesh {
    std::string name;
    FramePath sequence;  ///< the path pattern, before the frame number is put in
    std::string file;    ///< the path at this frame
    Mat4 wsFromMesh{1.0};
    bool holdout = true, shadows = true, catches = false;  ///< see Solid
    Rgb albedo{0};                                         ///< likewise
    std::optional<Rgb> color;                              ///< likewise
    std::string where;                                     ///< where the scene says `file`: "scene.toml:12:8"
    std::shared_ptr<const TriangleMesh> mesh = nullptr;    ///< null until it is loaded
};

struct ScenePreview {
    std::string file;  ///< the path at this frame; empty: no preview
    FramePath path;
    std::string display;                  ///< name of the display; "": the config's default
    std::string view;                     ///< name of the view; "": the display's default
    bool annotate = false;                ///< with a scale bar and the directions of x, y and z
    std::optional<Slide> backplate = {};  ///< what it is laid over; none: black
};

/// A deep picture that is written beside the flat one.
struct SceneDeep {
    std::string file;  ///< the path at this frame; empty: none
    FramePath path;
    double tolerance = 0.01;  ///< largest change by merging samples: of alpha, and of a colour relative to the pixel's
    bool half = true;         ///< colours are 16-bit, else 32-bit; depths are always 32-bit
};

/// A depth or deep picture by another renderer; it hides whatever is behind its surfaces.
struct SceneHoldout {
    std::string file;         ///< the path at this frame; empty: none
    std::string channel;      ///< name of the depth channel; "": the channel that can only be it
    bool alongRay = false;    ///< depths are distances along the pixel's ray instead of along the viewing axis
    double background = 1e9;  ///< depths from this one on mean "nothing there", and so do depths <= 0 and NaN
    bool dataWindow = false;  ///< the picture is its data window, whatever its display window says
    std::string where;        ///< where the scene gives its path
    std::shared_ptr<const DepthPicture> picture = nullptr;  ///< null until it is loaded
};

/// A flat picture file.
struct OutputFile {
    std::string file;        ///< the path at this frame; empty where the scene names none
    FramePath path;          ///< the path pattern, before the frame number is put in
    std::string where;       ///< where the scene says `file`: "scene.toml:12:8"
    std::string colorspace;  ///< the colour config's own name of the space
    bool half = true;        ///< channels are 16-bit, else 32-bit
    std::string compression = "zip";
    std::vector<Layer> layers;  ///< each at most once, in the order of the enumeration
    bool picture = true;        ///< it holds the beauty, too
};

struct SceneOutput : OutputFile {
    std::vector<OutputFile> files;  ///< further files, which hold other layers
    double fps = 24;
    bool chromaticities = true;  ///< linear files state their primaries, beside the name of their space
    ScenePreview preview;
    SceneDeep deep;
    SceneHoldout holdout;

    /// The layers of all files, as in OutputFile.
    std::vector<Layer> allLayers() const;
};

/// The range of the picture's normalised device coordinates over its width and height.
enum class NdcRange { automatic, symmetric, unit };  // symmetric: -1..1; unit: 0..1

/// A picture whose header holds the camera that made it.
struct PlateCamera {
    std::string file;   ///< the path at this frame
    std::string where;  ///< where the scene gives its path
    NdcRange ndc = NdcRange::automatic;
    bool givesResolution = true;  ///< the resolution comes from the header, because the scene states none
};

struct Scene {
    std::string file;  ///< the scene's file, as error messages name it
    double frame = 1;
    Camera camera;
    /// The header that `camera` is read from when a shot is loaded; until then only `near` of `camera` is set.
    std::optional<PlateCamera> plate = {};
    int overscan = 0;                  ///< pixels that are added on each side of the picture
    std::vector<SceneVolume> volumes;  ///< at least one
    std::vector<SceneMesh> meshes = {};
    std::vector<Light> lights;
    Rgb ambient{0};  ///< radiance of an unshadowed environment
    Dials dials;
    bool moves = false;                   ///< the scene has keyed values, or a camera whose file depends on the frame
    bool movesOn = false;                 ///< the scene's text may tell where things are one frame later
    std::optional<Shutter> shutter = {};  ///< none: the picture is that of one moment
    std::optional<Lens> lens = {};        ///< none: everything is sharp
    bool movesWithin = false;             ///< some keyed value changes while the shutter is open
    std::string quality = "standard";     ///< name of the preset that `dials` started from
    /// Texels and sheets are to be chosen so that the preset's promise holds; false where the scene
    /// states either of them.
    bool keepsPromise = false;
    double tolerance = 0;  ///< relative RMSE for which texels and sheets are to be chosen; 0: `dials` count as they are
    SceneOutput output;
    std::vector<std::string> warnings = {};  ///< warnings by the reader, each with its place in the text
    /// The places of all keys in the scene's text: "light.key.shadows" is at "scene.toml:12:3".
    /// Null for a scene built in code.
    std::shared_ptr<const SceneLines> lines = nullptr;
};

}  // namespace scrim
