// SPDX-License-Identifier: Apache-2.0
// The contents of a Shot, for shot.cpp and for studies.
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
    std::set<std::string> said;                                     ///< messages that keepPromise has sent

    /// The scene at a frame, before the options change it. Frames an asset first.
    Scene sceneAt(int frame, const RenderOptions& options);
    void frameAsset(const RenderOptions& options);
    /// The scene with the camera of a picture's header, where it asks for that.
    Scene withPlateCamera(Scene scene, const RenderOptions& options) const;
    /// The scene at a frame without reading an asset, whose camera, lights and density are then unknown.
    Scene sceneUnframed(int frame) const;

    /// Sets the dials of `scene` that keep its preset's promise. They are the same for all frames of the shot and all
    /// parts of a picture. Returns the seconds that pilots took, without those of loading.
    double keepPromise(Scene& scene, const RenderOptions& options, ShotUse use);
    /// As loadShot, but without the messages about the same files that keepPromise has sent.
    std::optional<LoadedShot> loadOnce(Scene scene, const RenderOptions& options, VolumesOf volumesOf, ShotUse use);
    /// Sets LoadedShot::textAt where the scene moves by its text. `options` must outlive `loaded`.
    void keepText(LoadedShot& loaded, const RenderOptions& options);
    /// A scene that was changed in code: its values are no longer keyed, and only velocities move it.
    static Scene byHand(Scene scene);
    /// The existing frame whose files are largest. Without sequences it is frame 1 for a scene that
    /// moves by its text, else the scene's own frame.
    int richestFrame(const Scene& scene) const;

    ShotPlan plan(Scene scene, const RenderOptions& options);
    /// Starts reading the files that `options.next` needs, if they fit into memory beside `loaded`
    /// and `buffers` (bytes).
    void readAhead(const RenderOptions& options, const LoadedShot& loaded, VolumesOf volumesOf, std::size_t buffers);
    /// `seconds`: the time that reading the scene took.
    ShotFrame render(Scene scene, double seconds, const RenderOptions& options);
};

}  // namespace scrim
