// SPDX-License-Identifier: Apache-2.0
// The first step of every plan, render and study: a scene, and in memory all that it names.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/image/colour.h>
#include <scrim/scene/scene.h>
#include <scrim/shot/assemble.h>
#include <scrim/shot/depth_store.h>
#include <scrim/shot/field_store.h>
#include <scrim/shot/mesh_store.h>
#include <scrim/shot/shot_options.h>
#include <scrim/shot/slide_store.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

namespace scrim {

/// What shots keep between frames, and may share.
struct ShotStores {
    explicit ShotStores(ColourConfig config) : colour(config), fields(LoadOptions{}), slides(std::move(config)) {}

    ColourConfig colour;
    FieldStore fields;
    SlideStore slides;
    MeshStore meshes = {};
    DepthStore depths = {};
};

struct LoadedShot {
    Scene scene;  ///< its slides and its holdout have their pictures, its meshes their triangles
    std::vector<VolumeFile> files;
    Fields fields;                         ///< one each of the scene's volumes
    std::size_t slideBytes = 0;            ///< of slides, meshes and depths
    std::shared_ptr<const Solids> solids;  ///< null: there are none

    std::function<Scene(double)> textAt =
        {};  ///< the scene's text so many frames after the frame; none: nothing moves, or nobody asks

    /// The scene so many frames after its frame, with what this one has loaded. Throws Error.
    Scene sceneAt(double t) const;
    /// The same a frame later, as far as the text knows: its camera, and where volumes are.
    Scene nextAt(double t) const;
    /// The fields with the time by which velocities move them.
    Fields fieldsAt(double t) const;

    /// What the engine renders so many frames after the frame, or what the reference sees then.
    ViewScene viewAt(double t, const RenderOptions& options, double lod, VolumesOf volumesOf, Moved moved) const;

    /// What the engine renders, with another value of the dial `lod`. Throws Error(memory) where volumes and slides
    /// leave nothing of the options' limit.
    ViewScene view(const RenderOptions& options, double lod, VolumesOf volumesOf) const;
};

enum class ShotUse { plan, render };

/// `load` with the memory of `options`.
LoadOptions limited(LoadOptions load, const RenderOptions& options);

/// Lets `store` load as `load` and `options` say.
void listenTo(FieldStore& store, const LoadOptions& load, const RenderOptions& options);

/// The scene as the options change it, checked (scene/check_scene.h). A scene that was built in code gets defaults for
/// what it leaves out.
Scene withOptions(Scene scene, const RenderOptions& options, const ShotStores& stores);

/// Loads what `scene` names. Returns nothing where a file is missing and such a frame is to be skipped; the message
/// about that depends on `use`.
std::optional<LoadedShot> loadShot(ShotStores& stores, const LoadOptions& load, Scene scene,
                                   const RenderOptions& options, VolumesOf volumesOf, ShotUse use);

}  // namespace scrim
