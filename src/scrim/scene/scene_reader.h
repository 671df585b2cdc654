// SPDX-License-Identifier: Apache-2.0
// From the text of a scene (TOML) to a Scene. A key that nobody reads is an error, and so are a wrong type
// and a value out of range: every message begins with "file:line:column: ", or with "--set key.path: " where
// the value came from an override, and says what was found and what is allowed.
#pragma once

#include <scrim/image/colour.h>
#include <scrim/scene/scene.h>

#include <string>
#include <vector>

namespace scrim {

struct SceneText {
    std::string file;            ///< how messages call the scene
    std::string folder;          ///< what its paths are relative to; "": the current folder
    std::string text;            ///< TOML
    bool gridsFromCode = false;  ///< volumes may name neither file nor source
};

/// Reads a file of up to 16 MB; `folder` becomes the file's. Throws Error(input) where it is missing or too
/// large.
SceneText loadSceneText(const std::string& path);

/// The scene at `frame`. An override is "key.path=value" with a TOML value, or a bare word as a string:
/// "camera.fov=20", "light[0].intensity=3" (from 0), "light.key.intensity=3" (by name),
/// "camera.position[1]=2", "output.file=out.exr". Overrides are applied in order, before anything is read.
/// Throws Error(input).
///
/// Matrices are written row by row and act on column vectors: the last column is the translation, the last
/// row 0, 0, 0, 1. Only the environment is read besides the text; whether a volume's file exists is for
/// volume_file.h.
/// `within`: frames after `frame` at which keys are looked up; files, and what the scene says of itself, stay those of
/// `frame`.
Scene readScene(const SceneText& text, double frame, const std::vector<std::string>& overrides,
                const ColourConfig& colour, double within = 0);

/// The camera of a text such as the inside of [camera], whose messages call it `name`. Throws Error(input).
Camera readCameraText(const std::string& text, const std::string& name, const ColourConfig& colour);

/// The scene with its overrides, as TOML: the text itself where there are none. Throws Error(input) where
/// text or overrides are malformed; values are not checked.
std::string sceneAsToml(const SceneText& text, const std::vector<std::string>& overrides);

}  // namespace scrim
