// SPDX-License-Identifier: Apache-2.0
// The text behind a shot: that of a scene file, or one that is generated for an asset, so that all
// later code deals with scenes only.
#pragma once

#include <scrim/image/colour.h>
#include <scrim/scene/scene.h>
#include <scrim/scene/scene_reader.h>
#include <scrim/shot/field_store.h>
#include <scrim/shot/frame_asset.h>
#include <scrim/shot/shot_options.h>

#include <string>
#include <vector>

namespace scrim {

class ShotText {
  public:
    /// Reads a scene file. Only the path of an asset is examined. Throws Error: usage, input.
    ShotText(const std::string& path, const std::vector<std::string>& overrides, const OpenOptions& options);
    /// Takes a scene in memory. Throws Error: usage, input.
    ShotText(SceneText text, const std::vector<std::string>& overrides, const OpenOptions& options);

    const std::string& path() const { return m_path; }
    bool isAsset() const { return m_asset; }

    /// Adds overrides to those of the caller. Throws Error(input).
    void add(const std::vector<std::string>& overrides);

    /// Frames an asset unless that has been done, and loads it into `store` for this.
    void frameAsset(FieldStore& store, const MessageSink& messages);

    /// The scene at a frame. If it names no output, the output gets the shot's name. `within` is as in readScene.
    Scene at(int frame, const ColourConfig& colour, double within = 0) const;

    /// The text with its overrides and those in `more`.
    std::string toml(const std::vector<std::string>& more) const;

  private:
    void give(const std::vector<std::string>& overrides, const OpenOptions& options);
    void applyTurntable();

    std::string m_path;
    AssetOptions m_asAsset;
    int m_turntable = 0;
    bool m_asset = false;
    bool m_framed = false;
    std::string m_assetPattern;  ///< the asset's path as a scene names it
    SceneText m_text;
    std::vector<std::string> m_given;      ///< overrides of the caller
    std::vector<std::string> m_overrides;  ///< those and the overrides of a turntable
};

/// Puts the frame into the paths of all output files.
void nameOutputs(SceneOutput& output, int frame);

/// The extension of a file's name in lower case: ".exr".
std::string lowerExtension(const std::string& path);

}  // namespace scrim
