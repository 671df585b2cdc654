// SPDX-License-Identifier: Apache-2.0
// OpenUSD stages. Python code reads them (plugins/python/scrim/usd), so a stage is passed to a child process that
// writes a scene for each frame. OpenUSD is not linked: its libraries are in no distribution, and clash with copies
// that other libraries bring.
#pragma once

#include "options.h"

#include <scrim/base/child_process.h>
#include <scrim/base/descriptor.h>
#include <scrim/image/image.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scrim::cli {

/// A folder that is removed with all its contents when this object is destroyed, and when this process ends, by
/// whatever signal: a child removes it that waits for that.
class TemporaryFolder {
  public:
    TemporaryFolder();

    const std::string& path() const { return m_path; }

  private:
    std::string m_path;
    std::optional<ChildProcess> m_keeper;
    Descriptor m_open;  ///< until it is closed, the keeper waits: so it is closed first
};

/// Frames of a stage that form one scene, so that whatever stands still is opened once.
struct UsdScene {
    std::vector<int> frames;
    std::string toml;
    std::optional<PixelWindow> crop;  ///< the crop in the stage's render settings
};

struct UsdScenes {
    std::vector<UsdScene> scenes;             ///< in the order of the frames
    std::vector<std::string> warnings;        ///< what could not be converted, prim by prim
    std::vector<std::string> notes;           ///< what users may want to check: the irradiance of suns
    std::shared_ptr<TemporaryFolder> folder;  ///< holds the files that the scenes name
};

/// True for the extensions of stages: .usd, .usda, .usdc, .usdz.
bool isStage(const std::string& path);

/// The scenes of a stage at the frames of the options, or at its only frame. Throws Error: usage, input, interrupted.
UsdScenes readStage(const std::string& path, const SceneOptions& options);

}  // namespace scrim::cli
