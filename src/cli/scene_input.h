// SPDX-License-Identifier: Apache-2.0
// One input of a command: a shot, and what the options of the command line change in it.
#pragma once

#include "file_claims.h"
#include "options.h"
#include "usd_scenes.h"

#include <scrim/shot/shot.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scrim::cli {

/// What a command writes, as `option` names it: relative to the current folder, with variables of the environment.
/// Throws Error(usage).
FramePath pathFrom(const std::string& option, const std::string& text);

class SceneInput {
  public:
    /// Opens the shot, and tells which frames there are. `options` must outlive this. `sharing`: another input of the
    /// command, whose volumes this one shares. Throws Error: usage, input.
    SceneInput(const std::string& path, const SceneOptions& options, const SceneInput* sharing = nullptr);

    /// A part of a stage that was read.
    SceneInput(const std::string& stage, const UsdScenes& scenes, const UsdScene& part, const SceneOptions& options,
               const SceneInput* sharing = nullptr);

    Shot& shot() { return m_shot; }
    const Shot& shot() const { return m_shot; }
    const std::string& name() const { return m_shot.path(); }
    const std::vector<int>& frames() const { return m_frames; }
    /// Before the frame is put in; the preview's has no pattern where none is wanted.
    const FramePath& output() const { return m_output; }
    const FramePath& preview() const { return m_preview; }
    const FramePath& deep() const { return m_deep; }  ///< the same of the deep picture

    /// The pixels to render, where the scene or the command line say which.
    std::optional<PixelWindow> crop() const { return m_options.crop ? m_options.crop : m_crop; }

    /// Puts the output and the preview of the command line into `scene`, and its quality in the place of a tolerance.
    void change(Scene& scene) const;

    /// With the changes of the command line, as TOML; the first call loads an asset.
    std::string printedToml(const RenderOptions& options);

  private:
    void begin();
    void checkPreview(const ScenePreview& preview) const;
    std::vector<int> framesOf(const Scene& scene) const;

    const SceneOptions& m_options;
    Shot m_shot;
    std::vector<int> m_frames;
    FramePath m_output, m_preview, m_deep;
    std::optional<PixelWindow> m_crop;
    std::shared_ptr<TemporaryFolder> m_folder;  // of files that the scene names
};

/// All inputs of the command.
std::vector<SceneInput> openInputs(const SceneOptions& options);

/// What `inputs` read.
void claimInputs(const std::vector<SceneInput>& inputs, const SceneOptions& options, FileClaims& claims);
/// The pictures, previews and statistics of `inputs`, whose files were claimed. Throws Error(usage) where two are one
/// file, or one of those that are read.
void claimOutputs(const std::vector<SceneInput>& inputs, const SceneOptions& options, FileClaims& claims);

/// The options of the command line that concern every frame; `messages` hears what is said.
RenderOptions renderOptionsOf(const SceneOptions& options, MessageSink messages);

}  // namespace scrim::cli
