// SPDX-License-Identifier: Apache-2.0
// What a Shot holds: for shot.cpp and for studies.
#pragma once

#include <scrim/shot/load_shot.h>
#include <scrim/shot/shot.h>
#include <scrim/shot/shot_text.h>

#include <memory>
#include <optional>
#include <string>

namespace scrim {

struct Shot::Content {
    std::string path;
    std::optional<ShotText> text;  ///< none: the scene was built in code
    Scene opened;
    LoadOptions load;
    std::shared_ptr<ShotStores> stores;

    /// The scene at a frame, before the options change it. Frames an asset first.
    Scene sceneAt(int frame, const RenderOptions& options);
    void frameAsset(const RenderOptions& options);

    ShotPlan plan(Scene scene, const RenderOptions& options);
    /// `seconds`: that reading the scene took.
    ShotFrame render(Scene scene, double seconds, const RenderOptions& options);
};

}  // namespace scrim
