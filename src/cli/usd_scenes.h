// SPDX-License-Identifier: Apache-2.0
// OpenUSD: what reads it is Python's (plugins/python/scrim/usd), so a stage goes to a child process that writes a scene
// for each frame. Not linked: OpenUSD's libraries are in no distribution, and clash with those that others bring.
#pragma once

#include "options.h"

#include <scrim/image/image.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scrim::cli {

/// A folder that goes when this does, with all that is in it.
class TemporaryFolder {
  public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::string& path() const { return m_path; }

  private:
    std::string m_path;
};

/// Frames of a stage that are one scene: what stands still is opened once.
struct UsdScene {
    std::vector<int> frames;
    std::string toml;
    std::optional<PixelWindow> crop;  ///< what the stage's render settings ask for
};

struct UsdScenes {
    std::vector<UsdScene> scenes;             ///< in the order of the frames
    std::vector<std::string> warnings;        ///< what could not be mapped, prim by prim
    std::vector<std::string> notes;           ///< what may be checked: the irradiance of suns
    std::shared_ptr<TemporaryFolder> folder;  ///< holds what the scenes name
};

/// Whether the name of a file is that of a stage: .usd, .usda, .usdc, .usdz.
bool isStage(const std::string& path);

/// The scenes of a stage at the frames of the options, or at its only one. Throws Error: usage, input, interrupted.
UsdScenes readStage(const std::string& path, const SceneOptions& options);

}  // namespace scrim::cli
