// SPDX-License-Identifier: Apache-2.0
// Internal: one function a section of a scene. Each reads all keys of its table, refuses the rest, and
// returns what the section says at the frame.
#pragma once

#include <scrim/base/error.h>
#include <scrim/scene/scene.h>
#include <scrim/scene/scene_keys.h>
#include <scrim/scene/toml_reader.h>

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

namespace scrim {

/// What all sections need to know.
struct ReadContext {
    double frame = 1;       ///< that keys are looked up at
    double wholeFrame = 1;  ///< that files are those of: `frame`, or the frame that it is a moment of
    const ColourConfig& colour;
    std::string folder;                    ///< of the scene
    VariableLookup variables;              ///< [variables], then the environment
    std::vector<std::string> lights = {};  ///< names of all [[light]]
    bool gridsFromCode = false;            ///< volumes may name neither file nor source
    int version = 1;                       ///< `scene_version`: the defaults that its author knew
    std::shared_ptr<std::vector<std::string>> warnings = std::make_shared<std::vector<std::string>>();

    /// The pattern in `value` with its variables expanded, relative to the scene.
    FramePath path(const TomlValue& value) const;
    /// As files are numbered: the nearest whole number.
    int fileFrame() const;
};

struct CameraSection {
    Camera camera;
    int overscan = 0;
    std::optional<PlateCamera> plate;
    std::optional<Shutter> shutter = {};
    bool moves = false;  ///< does the plate have frames?
};

/// A place on a sphere.
struct Orbit {
    Vec3 wsCenter{0};
    double radius = 0;
    Vec3 toPlace{0, 0, 1};  ///< unit, from the middle
};

struct RenderSection {
    std::string quality = "standard";
    bool keepsPromise = true;
    Dials dials;
    double tolerance = 0;
};

CameraSection readCamera(TomlTable table, const ReadContext& context);
/// `defaultName` is the name of a volume or light that has none.
SceneVolume readVolume(TomlTable table, const std::string& defaultName, const ReadContext& context);
/// [volume.medium]: medium, albedoGrid and emission of `volume`.
void readMedium(TomlTable table, const ReadContext& context, SceneVolume& volume);
/// [volume.classified]: transfer function and Phong coefficients.
Classified readClassified(TomlTable table, const ReadContext& context);
/// { center, radius, elevation, azimuth } of what `of` describes; without a radius where none is needed. `up` is unit.
Orbit readOrbit(const TomlValue& value, const std::string& of, const Vec3& up, bool needsRadius,
                const ReadContext& context);
/// Takes +y to `up`, a unit vector, and +x and +z along: an orbit's right and front.
Mat3 wsFromOrbit(const Vec3& up);
/// Four rows of four numbers that act on column vectors; invertible and affine.
Mat4 readMatrix(const TomlValue& value);
/// Whether the linear part can be inverted, judged by its shape and not by its size.
bool isInvertible(const Mat4& m);
/// The map of a volume's transform.
Mat4 readTransform(TomlTable table, const ReadContext& context);
SceneMesh readMesh(TomlTable table, const std::string& defaultName, const ReadContext& context);
Light readLight(TomlTable table, const std::string& defaultName, const ReadContext& context);
Rgb readAmbient(TomlTable table, const ReadContext& context);
RenderSection readRender(TomlTable table);
/// Of a scene without [output] too: the defaults.
SceneOutput defaultOutput(const ReadContext& context);
SceneOutput readOutput(TomlTable table, const ReadContext& context);
std::vector<std::pair<std::string, std::string>> readVariables(TomlTable table);

/// Runs `call`; an error of the colour config is located at `value`.
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
/// The unit vector from `from` to `to`; throws at `value` where they coincide, with "`problem` at frame ...".
Vec3 directionBetween(const Vec3& from, const Vec3& to, const TomlValue& value, const std::string& problem,
                      double frame);
/// The text that is said about a volume or light: "[[light]] 'key'"; and its name.
std::string readName(TomlTable& table, const Key& key, const std::string& defaultName);

}  // namespace scrim
