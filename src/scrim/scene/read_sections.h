// SPDX-License-Identifier: Apache-2.0
// Internal: one function for each section of a scene. Each reads all keys of its table, refuses
// unknown ones, and returns the section's values at the frame.
#pragma once

#include <scrim/base/error.h>
#include <scrim/scene/scene.h>
#include <scrim/scene/scene_keys.h>
#include <scrim/scene/toml_reader.h>
#include <scrim/volume/grid_edit.h>

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

namespace scrim {

/// What all sections need to know while they are read.
struct ReadContext {
    double frame = 1;  ///< the frame at which keyed values are evaluated
    /// The frame whose files are read: `frame` itself, or the frame that `frame` is a moment of.
    double wholeFrame = 1;
    const ColourConfig& colour;
    std::string folder;                    ///< the scene's folder
    VariableLookup variables;              ///< [variables], then the environment
    std::vector<std::string> meshes = {};  ///< names of all [[mesh]] tables
    std::vector<std::string> lights = {};  ///< names of all [[light]] tables
    bool gridsFromCode = false;            ///< volumes may name neither a file nor a source
    bool deepFromCode = false;             ///< [output] may say how a deep picture is written without naming one
    double fps = 24;                       ///< frames per second
    int version = 1;                       ///< `scene_version`: the defaults that the author knew
    std::shared_ptr<std::vector<std::string>> warnings = std::make_shared<std::vector<std::string>>();

    /// The path pattern in `value` with its variables expanded; relative to the scene's folder.
    FramePath path(const TomlValue& value) const { return path(value, value.string()); }
    /// The same of `pattern`, a part of the text of `value`.
    FramePath path(const TomlValue& value, const std::string& pattern) const;
    /// The frame as files are numbered: `wholeFrame` rounded to the nearest whole number.
    int fileFrame() const;
};

/// A place on a sphere.
struct Orbit {
    Vec3 wsCenter{0};
    double radius = 0;
    Vec3 toPlace{0, 0, 1};  ///< unit, from the centre to the place
};

/// Reads [camera] into `camera`, `plate`, `overscan` and `shutter` of `scene`. `moves` becomes true
/// where the camera's file depends on the frame.
void readCamera(TomlTable table, const ReadContext& context, Scene& scene);
/// `defaultName` names a volume or light without a name of its own.
SceneVolume readVolume(TomlTable table, const std::string& defaultName, const ReadContext& context);
/// Reads the faces at which a volume ends: those of its clip and clip_plane.
std::vector<HalfSpace> readClip(TomlTable& table);
/// Reads how the grids of a volume are put together from files, whose patterns become `sequences`.
std::vector<CombinedGrid> readGrids(const TomlValue& value, const ReadContext& context,
                                    std::vector<FramePath>& sequences);
/// Reads what else is done to the grids of `volume`, of which density and motion are known: clip,
/// resample, ax. Null where nothing is.
std::shared_ptr<const GridEdit> readEdit(TomlTable& table, const ReadContext& context, const SceneVolume& volume);
/// The names of the external variables of the volume's expression, which are not parameters of its source.
std::vector<std::string> variablesOf(TomlTable& table, const ReadContext& context);
/// Reads what is done to a density: remap, edge, mask, noise.
void readDensityShading(TomlTable& table, const ReadContext& context, DensityShading& shading);
/// Two numbers, which ascend if they have to; [0, 1] where the key is missing.
std::array<double, 2> readPair(TomlTable& table, const Key& key, bool ascends);
/// Read a table inside of the one that messages call `of`. What is random depends on the frame
/// alone, not on the moment within it.
Mask readMask(const TomlValue& value, const std::string& of);
Noise readNoise(const TomlValue& value, const std::string& of, const ReadContext& context);
/// Reads [volume.medium] into the medium, albedoGrid and emission of `volume`.
void readMedium(TomlTable table, const ReadContext& context, SceneVolume& volume);
/// Reads [volume.classified]: the transfer function or a window, and Phong's coefficients.
Classified readClassified(TomlTable table, const ReadContext& context);
/// Reads { center, radius, elevation, azimuth } for the thing that messages call `of`. The radius
/// is left out where `needsRadius` is false. `up` must be unit.
Orbit readOrbit(const TomlValue& value, const std::string& of, const Vec3& up, bool needsRadius,
                const ReadContext& context);
/// The shortest rotation that takes +y to the unit vector `up`. It carries +x and +z to the right
/// and front of an orbit.
Mat3 wsFromOrbit(const Vec3& up);
/// Reads four rows of four numbers that act on column vectors; the matrix must be invertible and affine.
Mat4 readMatrix(const TomlValue& value);
/// True if the linear part can be inverted, judged by its shape and not by its scale.
bool isInvertible(const Mat4& m);
/// Reads the map of a volume's transform.
Mat4 readTransform(TomlTable table, const ReadContext& context);
SceneMesh readMesh(TomlTable table, const std::string& defaultName, const ReadContext& context);
Light readLight(TomlTable table, const std::string& defaultName, const ReadContext& context);
Rgb readAmbient(TomlTable table, const ReadContext& context);
/// Reads [render] into `quality`, `keepsPromise`, `dials` and `tolerance` of `scene`.
void readRender(TomlTable table, const ReadContext& context, Scene& scene);
/// The output of a scene without [output]: the defaults.
SceneOutput defaultOutput(const ReadContext& context);
SceneOutput readOutput(TomlTable table, const ReadContext& context);
std::vector<std::pair<std::string, std::string>> readVariables(TomlTable table);

/// Runs `call` and adds the place of `value` to an error that the colour config throws.
template <typename Call>
auto located(const TomlValue& value, const Call& call) {
    try {
        return call();
    } catch (const Error& error) {
        value.fail(fmt::format("'{}': {}", value.name(), error.what()));
    }
}

/// The unit vector along the three numbers of `value`, which must not all be 0.
Vec3 readDirection(const TomlValue& value, double frame);
/// The unit vector from `from` to `to`. Throws at `value` where they coincide, with "`problem` at frame ...".
Vec3 directionBetween(const Vec3& from, const Vec3& to, const TomlValue& value, const std::string& problem,
                      double frame);
/// Reads a colour with components from 0 to `most` in the working space. Conversions may exceed the limits by rounding.
Rgb readBounded(const TomlValue& value, const ReadContext& context, double most);
/// Reads a picture and its colour space, which is all that the picture of a rectangle, a dome or a backplate has.
Slide readPicture(TomlTable& table, const Key& fileKey, const Key& spaceKey, const ReadContext& context);
/// A text without control characters.
std::string nameIn(const TomlValue& value);
/// The name of one of `names`, which are those of the tables of `key`.
std::string nameAmong(const TomlValue& value, const Key& key, const std::vector<std::string>& names);
/// Reads the name and describes the table in messages by it: "[[light]] 'key'". Returns the name.
std::string readName(TomlTable& table, const Key& key, const std::string& defaultName);

}  // namespace scrim
