// SPDX-License-Identifier: Apache-2.0
// One input of a command, a scene or an asset alone, as scenes at frames. For an asset the text of a scene is
// made up, so that all that follows knows scenes only.
#pragma once

#include "field_store.h"
#include "options.h"

#include <scrim/image/colour.h>
#include <scrim/scene/scene_reader.h>

#include <string>
#include <vector>

namespace scrim::cli {

class SceneInput {
  public:
    /// Reads a scene, and tells which frames there are. An asset is not looked at yet. `options`, `colour`
    /// and `store` must outlive this. Throws Error: usage, input.
    SceneInput(const std::string& path, const SceneOptions& options, const ColourConfig& colour, FieldStore& store);

    const std::string& name() const { return m_path; }
    const std::vector<int>& frames() const { return m_frames; }
    /// Before the frame is put in; the preview's has no pattern where none is wanted.
    const FramePath& output() const { return m_output; }
    const FramePath& preview() const { return m_preview; }

    /// The scene at one of the frames; its output and preview are those of the command line where given. The
    /// first call loads an asset.
    Scene sceneAt(int frame);

    /// With the changes of the command line to what is seen, as TOML; the first call loads an asset.
    std::string toml();
    /// The same, and with the output of the command line.
    std::string printedToml();

  private:
    void frameAsset();
    std::string framedText(const SparseField& field) const;
    Scene read(const SceneText& text, int frame) const;
    std::vector<int> framesOf(const Scene& scene) const;

    std::string m_path;
    const SceneOptions& m_options;
    const ColourConfig& m_colour;
    FieldStore& m_store;
    bool m_asset = false;
    bool m_framed = false;
    std::string m_assetPattern;  ///< the asset's path as a scene names it
    SceneText m_text;
    std::vector<std::string> m_overrides;
    std::vector<int> m_frames;
    FramePath m_output, m_preview;
};

/// All inputs of the command; where it `writes` pictures, once it is known that no two go to one file.
std::vector<SceneInput> openInputs(const SceneOptions& options, const ColourConfig& colour, FieldStore& store,
                                   bool writes);

/// Bytes that buffers may take: what `fields` and slides of so many bytes leave of `limit`; 0 where there is no limit.
/// Throws Error(memory).
std::size_t memoryLeft(std::size_t limit, const Fields& fields, std::size_t slideBytes);

}  // namespace scrim::cli
