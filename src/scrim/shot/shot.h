// SPDX-License-Identifier: Apache-2.0
// A shot: a scene file, or an asset that is framed and lit, with everything that its frames need.
// This is how to render from C++:
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
/// Shots share no state: any number of them may be used at the same time, each from one thread at a time. Only
/// third-party volume sources may forbid that (volume/scrim_source.h). Nothing is printed, and no signal is handled.
///
/// All members throw Error, of the kind `memory` where memory is insufficient; those that take
/// RenderOptions also pass on what its functions throw. A scene that was built or changed in code
/// is checked against the ranges of scene files whenever it is used (scene/check_scene.h).
class Shot {
  public:
    /// Opens a scene (.toml) or an asset (.vdb, or a scan: .nrrd, .nhdr, .nii, .nii.gz, .hdr), which is framed and lit.
    /// The asset is not read yet. An override is "key.path=value": "camera.fov=20", "light.key.intensity=3". Throws
    /// Error(usage) for other files, Error(input) where the scene or an override is wrong.
    static Shot open(const std::string& path, const std::vector<std::string>& overrides = {},
                     const OpenOptions& options = {});

    /// Opens a scene whose text is in memory. Messages call it `name`; its paths are relative to
    /// `folder` ("": the current folder). Throws as `open` does.
    static Shot parse(const std::string& toml, const std::string& name, const std::string& folder,
                      const std::vector<std::string>& overrides = {}, const OpenOptions& options = {});

    /// Makes a shot of a scene that was built in code; its values are checked like those of a file.
    /// The options `resolution` and `checkedFrame` are ignored.
    static Shot make(Scene scene, const OpenOptions& options = {});

    /// The path as passed to `open`, the name passed to `parse`, or Scene::file.
    const std::string& path() const;
    bool isAsset() const;

    /// The frames for which the shot's sequences have files, ascending; {1} without sequences.
    std::vector<int> frames() const;

    /// The scene as it was read when the shot was opened, at OpenOptions::checkedFrame. An asset's
    /// camera, lights and density are not known yet.
    const Scene& opened() const;

    /// The scene at a frame. The first call reads an asset in order to frame it.
    Scene scene(int frame, const RenderOptions& options = {});

    /// The scene as TOML with its overrides and those in `more`; "" where it was built in code. The
    /// first call reads an asset.
    std::string toml(const std::vector<std::string>& more = {}, const RenderOptions& options = {});

    /// Overrides more values of the text from now on, as `open` does. Where the scene would be
    /// wrong then, throws Error(input), and changes nothing.
    void set(const std::vector<std::string>& overrides);

    /// Gives the volume called `name` grids that were made in code, in place of those of a file or
    /// source. The scene chooses among them by their names.
    void setVolume(const std::string& name, std::vector<SparseField> grids);

    /// The plan of a frame: what rendering it would do.
    ShotPlan plan(int frame, const RenderOptions& options = {});
    ShotPlan plan(Scene scene, const RenderOptions& options = {});

    /// Loads the frame's files, plans, renders and verifies it. Pixels do not depend on the number of threads, and all
    /// of them are finite: throws Error(render) where light exceeds the range of floats.
    ShotFrame render(int frame, const RenderOptions& options = {});
    /// Renders a scene that was obtained from `scene()` and changed. The metadata still contains the text of the shot.
    /// Keyed values are fixed at the frame, so they cause no motion blur; velocities still do.
    ShotFrame render(Scene scene, const RenderOptions& options = {});

    /// Makes the scene's preview of a frame from its picture, which was written before. Throws
    /// Error(input) where the picture cannot be read.
    void previewFromPicture(int frame, const RenderOptions& options = {});

    /// The colour config, for conversion of colours into the working space.
    const ColourConfig& colour() const;

    Shot(Shot&&) noexcept;
    Shot& operator=(Shot&&) noexcept;
    ~Shot();

  private:
    struct Content;
    explicit Shot(std::unique_ptr<Content> content);
    /// A shot without a scene.
    static Shot withStores(const OpenOptions& options);
    /// Reads the scene from its text.
    void begin(const OpenOptions& options);
    friend class ShotStudy;       // study/shot_study.h
    friend class ShotSteadiness;  // study/shot_steadiness.h
    friend std::vector<SceneFile> filesReadBy(const Shot& shot, const std::vector<int>& frames);  // shot/shot_files.h
    friend BakedShot bakeShot(const Shot& shot, int frame, const BakeRequest& request,
                              const RenderOptions& options);  // shot/bake_shot.h

    std::unique_ptr<Content> m_content;
};

}  // namespace scrim
