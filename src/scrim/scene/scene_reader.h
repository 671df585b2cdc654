// SPDX-License-Identifier: Apache-2.0
// Reads a Scene from the text of a scene (TOML). Unknown keys, wrong types and values out of range
// are errors. Every message begins with "file:line:column: ", or with "--set key.path: " where the
// value came from an override, and says what was found and what is allowed.
#pragma once

#include <scrim/image/colour.h>
#include <scrim/scene/scene.h>

#include <string>
#include <vector>

namespace scrim {

struct SceneText {
    std::string file;            ///< the scene's name in messages
    std::string folder;          ///< the folder that its paths are relative to; "": the current folder
    std::string text;            ///< TOML
    bool gridsFromCode = false;  ///< volumes may name neither a file nor a source
    bool deepFromCode = false;   ///< [output] may say how a deep picture is written without naming one
};

/// Reads a file of up to 16 MB; `folder` becomes the file's folder. Throws Error(input) where it is
/// missing or too large.
SceneText loadSceneText(const std::string& path);

/// The scene at `frame`. An override is "key.path=value" with a TOML value, or with a bare word, which counts as a
/// string: "camera.fov=20", "light[0].intensity=3" (from 0), "light.key.intensity=3" (by name), "camera.position[1]=2",
/// "output.file=out.exr". Overrides are applied in order, before anything is read. Throws Error(input).
///
/// Matrices are written row by row and act on column vectors: the last column is the translation, the last row 0, 0, 0,
/// 1. Nothing is read but the text and the environment; volume_file.h finds out whether a volume's file exists.
///
/// `within`: keyed values are evaluated that many frames after `frame`, while files, and the
/// scene's statements about itself, stay those of `frame`.
Scene readScene(const SceneText& text, double frame, const std::vector<std::string>& overrides,
                const ColourConfig& colour, double within = 0);

/// The camera of a text that holds keys of [camera]; messages call the text `name`. Throws Error(input).
Camera readCameraText(const std::string& text, const std::string& name, const ColourConfig& colour);

/// The scene as TOML with its overrides applied; without any, the text itself. Throws Error(input)
/// where text or overrides are malformed; values are not checked.
std::string sceneAsToml(const SceneText& text, const std::vector<std::string>& overrides);

}  // namespace scrim
