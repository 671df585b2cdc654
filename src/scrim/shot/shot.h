// SPDX-License-Identifier: Apache-2.0
// A shot: a scene file, or an asset that is framed and lit, with all that its frames need. This is the way to render
// from C++:
//
//     auto shot = scrim::Shot::open("shot.toml", {"camera.fov=20"});
//     auto frame = shot.render(7);
//     frame.write("plume.####.exr");
#pragma once

#include <scrim/image/colour.h>
#include <scrim/scene/scene.h>
#include <scrim/shot/shot_frame.h>
#include <scrim/shot/shot_options.h>
#include <scrim/volume/sparse_field.h>

#include <memory>
#include <string>
#include <vector>

namespace scrim {

struct SceneFile;
struct BakedShot;
struct BakeRequest;

/// Volumes and slides are loaded when a frame needs them, and kept as long as the next frame needs them, too.
///
/// Shots share no state: any number of them may be used at the same time, each from one thread at a time. Only volume
/// sources of others may forbid that (volume/scrim_source.h). Nothing is printed, and no signal is handled.
///
/// All members throw Error, of the kind `memory` where there is not enough of it; those that take RenderOptions also
/// what its functions throw. A scene that was built in code, or changed, is held to the ranges of files whenever it is
/// used (scene/check_scene.h).
class Shot {
  public:
    /// Opens a scene (.toml) or an asset (.vdb, or a scan: .nrrd, .nhdr, .nii, .nii.gz), which is framed and lit. An
    /// asset is not read yet. An override is "key.path=value": "camera.fov=20", "light.key.intensity=3". Throws
    /// Error(usage) for other files, Error(input) where the scene or an override is wrong.
    static Shot open(const std::string& path, const std::vector<std::string>& overrides = {},
                     const OpenOptions& options = {});

    /// A scene whose text is in memory. Messages call it `name`; its paths are relative to `folder` ("": the current
    /// one). Throws as `open`.
    static Shot parse(const std::string& toml, const std::string& name, const std::string& folder,
                      const std::vector<std::string>& overrides = {}, const OpenOptions& options = {});

    /// A shot of a scene that was built in code, whose values are checked as those of a file are. `resolution` and
    /// `checkedFrame` of the options do not count.
    static Shot make(Scene scene, const OpenOptions& options = {});

    /// As it was opened, or its name, or Scene::file.
    const std::string& path() const;
    bool isAsset() const;

    /// The frames that the shot names: those for which its sequences have files, ascending; {1} without sequences.
    std::vector<int> frames() const;

    /// The scene as it was read when the shot was opened, at OpenOptions::checkedFrame. Camera, lights and density of
    /// an asset are not known yet.
    const Scene& opened() const;

    /// The scene at a frame. The first call reads an asset, to frame it.
    Scene scene(int frame, const RenderOptions& options = {});

    /// The scene as TOML, with the overrides, and `more` of them; "" where it was built in code. The first call reads
    /// an asset.
    std::string toml(const std::vector<std::string>& more = {}, const RenderOptions& options = {});

    /// Gives the volume that is called `name` grids that were made in code, instead of those of a file or source. The
    /// scene chooses among them by their names.
    void setVolume(const std::string& name, std::vector<SparseField> grids);

    /// Says what rendering would do.
    ShotPlan plan(int frame, const RenderOptions& options = {});
    ShotPlan plan(Scene scene, const RenderOptions& options = {});

    /// Loads what the frame needs, plans, renders and verifies it. Pixels do not depend on the number of threads. All
    /// of them are finite: throws Error(render) where light is brighter than floats reach.
    ShotFrame render(int frame, const RenderOptions& options = {});
    /// The same for a scene of `scene()` that was changed by hand. The metadata still has the text of the shot. Keys
    /// are values of the frame then, and do not blur it; velocities do.
    ShotFrame render(Scene scene, const RenderOptions& options = {});

    /// Makes the scene's preview of a frame from its picture, which was written before. Throws Error(input) where that
    /// cannot be read.
    void previewFromPicture(int frame, const RenderOptions& options = {});

    /// For colours that are given in other spaces than the working space.
    const ColourConfig& colour() const;

    Shot(Shot&&) noexcept;
    Shot& operator=(Shot&&) noexcept;
    ~Shot();

  private:
    struct Content;
    explicit Shot(std::unique_ptr<Content> content);
    /// An empty one.
    static Shot withStores(const OpenOptions& options);
    /// Reads the text that it holds.
    void begin(const OpenOptions& options);
    friend class ShotStudy;                                                                       // study/shot_study.h
    friend std::vector<SceneFile> filesReadBy(const Shot& shot, const std::vector<int>& frames);  // shot/shot_files.h
    friend BakedShot bakeShot(const Shot& shot, int frame, const BakeRequest& request,
                              const RenderOptions& options);  // shot/bake_shot.h

    std::unique_ptr<Content> m_content;
};

}  // namespace scrim
