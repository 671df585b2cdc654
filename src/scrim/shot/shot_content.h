// SPDX-License-Identifier: Apache-2.0
// What a Shot holds: for shot.cpp and for studies.
#pragma once

#include <scrim/shot/load_shot.h>
#include <scrim/shot/shot.h>
#include <scrim/shot/shot_text.h>
#include <scrim/verify/promise.h>

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace scrim {

struct Shot::Content {
    std::string path;
    std::optional<ShotText> text;  ///< none: the scene was built in code
    Scene opened;
    LoadOptions load;
    std::shared_ptr<ShotStores> stores;
    std::optional<std::pair<std::string, PromisedDials>> promised;  ///< by preset
    std::set<std::string> said;                                     ///< by keepPromise

    /// The scene at a frame, before the options change it. Frames an asset first.
    Scene sceneAt(int frame, const RenderOptions& options);
    void frameAsset(const RenderOptions& options);
    /// With the camera that a picture's header has, where the scene asks for it.
    Scene withPlateCamera(Scene scene, const RenderOptions& options) const;
    /// The same without reading an asset: camera, lights and density are then not known.
    Scene sceneUnframed(int frame) const;

    /// Puts the dials into `scene` that keep its preset's promise: the same for all frames of the shot, and all parts
    /// of a picture.
    void keepPromise(Scene& scene, const RenderOptions& options, ShotUse use);
    /// As loadShot; what keepPromise has said of the same files is not said again.
    std::optional<LoadedShot> loadOnce(Scene scene, const RenderOptions& options, VolumesOf volumesOf, ShotUse use);
    /// Of a scene that was changed by hand nothing is keyed any more: only velocities move it.
    static Scene byHand(Scene scene);
    /// The existing frame whose files are largest; where nothing is a sequence, the first, or
    /// of a scene that does not move its own.
    int richestFrame(const Scene& scene) const;

    ShotPlan plan(Scene scene, const RenderOptions& options);
    /// Lets files be read that `options.next` needs, where they fit in beside what is in memory: `loaded`, and
    /// `buffers`.
    void readAhead(const RenderOptions& options, const LoadedShot& loaded, VolumesOf volumesOf, std::size_t buffers);
    /// `seconds`: that reading the scene took.
    ShotFrame render(Scene scene, double seconds, const RenderOptions& options);
};

}  // namespace scrim
