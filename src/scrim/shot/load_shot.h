// SPDX-License-Identifier: Apache-2.0
// The first step of every plan, render and study: loads a scene and all files that it names into memory.
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

/// What a shot keeps in memory between frames; several shots may share it.
struct ShotStores {
    explicit ShotStores(ColourConfig config) : colour(config), fields(LoadOptions{}), slides(std::move(config)) {}

    ColourConfig colour;
    FieldStore fields;
    SlideStore slides;
    MeshStore meshes = {};
    std::shared_ptr<CoarserLevels> levels = std::make_shared<CoarserLevels>();
    DepthStore depths = {};
};

struct LoadedShot {
    Scene scene;  ///< its slides, holdout and meshes are loaded
    std::vector<VolumeFile> files;
    Fields fields;                         ///< one entry for each of the scene's volumes
    std::size_t slideBytes = 0;            ///< memory of slides, meshes and depth pictures
    std::shared_ptr<const Solids> solids;  ///< null: there are no solids
    std::shared_ptr<CoarserLevels> levels = {};

    /// The scene by its text, a number of frames after the frame; empty: nothing moves, or it is not needed.
    std::function<Scene(double)> textAt = {};

    /// The scene `t` frames after its frame, with the files that are loaded for this frame. Throws Error.
    Scene sceneAt(double t) const;
    /// The scene one frame after that, as far as its text tells: camera and places of volumes.
    Scene nextAt(double t) const;
    /// The fields with the times by which velocities move them until `t` frames after the frame,
    /// and in the frame after.
    Fields fieldsAt(double t) const;

    /// The scene `t` frames after the frame, with its fields where the files have them and without
    /// the data of the layer `motion`. `lod` is the dial's value.
    ViewScene viewAt(double t, const RenderOptions& options, double lod, VolumesOf volumesOf) const;
    /// The same of `at`, a scene of that time.
    ViewScene viewOf(Scene at, double t, const RenderOptions& options, double lod, VolumesOf volumesOf) const;

    /// The scene that the engine renders, with `lod` as the dial's value. Throws Error(memory)
    /// where volumes and slides leave nothing of the options' limit.
    ViewScene view(const RenderOptions& options, double lod, VolumesOf volumesOf) const;
};

enum class ShotUse { plan, render };

/// `load` with the memory limit of `options`.
LoadOptions limited(LoadOptions load, const RenderOptions& options);

/// Makes `store` load as `load` and `options` say.
void listenTo(FieldStore& store, const LoadOptions& load, const RenderOptions& options);

/// The scene with the changes that the options ask for, checked (scene/check_scene.h). A scene that
/// was built in code gets defaults for what it leaves out.
Scene withOptions(Scene scene, const RenderOptions& options, const ShotStores& stores);

/// Loads all files that `scene` names. Returns no value where a file is missing and the frame is to
/// be skipped; the message about that depends on `use`.
std::optional<LoadedShot> loadShot(ShotStores& stores, const LoadOptions& load, Scene scene,
                                   const RenderOptions& options, VolumesOf volumesOf, ShotUse use);

}  // namespace scrim
