// SPDX-License-Identifier: Apache-2.0
// One input of a command: a shot, and the changes that the command line makes to it.
#pragma once

#include "console.h"
#include "file_claims.h"
#include "options.h"
#include "usd_scenes.h"

#include <scrim/shot/shot.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scrim::cli {

/// The path pattern of an option's file: relative to the current folder, with environment variables expanded. Throws
/// Error(usage).
FramePath pathFrom(const std::string& option, const std::string& text);

class SceneInput {
  public:
    /// Opens the shot and determines its frames. `options` must outlive this object. `sharing`: another input of the
    /// command, with which this one shares volumes. Throws Error: usage, input.
    SceneInput(const std::string& path, const SceneOptions& options, const SceneInput* sharing = nullptr);

    /// An input for a part of a stage that was read.
    SceneInput(const std::string& stage, const UsdScenes& scenes, const UsdScene& part, const SceneOptions& options,
               const SceneInput* sharing = nullptr);

    Shot& shot() { return m_shot; }
    const Shot& shot() const { return m_shot; }
    const std::string& name() const { return m_shot.path(); }
    const std::vector<int>& frames() const { return m_frames; }
    /// The patterns before the frame number is put in; the preview's is empty where none is wanted.
    const FramePath& output() const { return m_output; }
    const FramePath& preview() const { return m_preview; }
    const FramePath& deep() const { return m_deep; }                  ///< likewise, for the deep picture
    const std::vector<OutputFile>& files() const { return m_files; }  ///< further files
    /// All EXR files: the picture, further files, and the deep picture if it is wanted.
    std::vector<FramePath> exrs() const;

    /// The pixels to render, where the scene or the command line states them.
    std::optional<PixelWindow> crop() const { return m_options.crop ? m_options.crop : m_crop; }

    /// Sets the output and the preview of the command line in `scene`; its quality replaces a tolerance.
    void change(Scene& scene) const;

    /// The scene as TOML with the changes of the command line; the first call loads an asset.
    std::string printedToml(const RenderOptions& options);

  private:
    void begin();
    void nameFiles(std::vector<OutputFile>& files) const;
    void checkPreview(const ScenePreview& preview) const;
    std::vector<int> framesOf(const Scene& scene) const;

    const SceneOptions& m_options;
    Shot m_shot;
    std::vector<int> m_frames;
    FramePath m_output, m_preview, m_deep;
    std::vector<OutputFile> m_files;
    std::optional<PixelWindow> m_crop;
    std::shared_ptr<TemporaryFolder> m_folder;  // holds files that the scene names
};

/// For each input of the command, what was read of it if it is a stage.
using Stages = std::vector<std::optional<UsdScenes>>;
/// Reads the stages, and says on `console` what is not rendered as they have it.
Stages readStages(const SceneOptions& options, Console& console);

/// Opens all inputs of the command. `options` must outlive them.
std::vector<SceneInput> openInputs(const SceneOptions& options, const Stages& stages);
/// The same, after reading the stages.
std::vector<SceneInput> openInputs(const SceneOptions& options);

/// Claims the files that `inputs` read.
void claimInputs(const std::vector<SceneInput>& inputs, const SceneOptions& options, FileClaims& claims);
/// Claims the pictures, previews and statistics of `inputs`, whose read files must have been claimed. Throws
/// Error(usage) where two outputs are one file, or an output is also read.
void claimOutputs(const std::vector<SceneInput>& inputs, const SceneOptions& options, FileClaims& claims);

/// The options of the command line that concern every frame; `messages` receives messages.
RenderOptions renderOptionsOf(const SceneOptions& options, MessageSink messages);

}  // namespace scrim::cli
