// SPDX-License-Identifier: Apache-2.0
// The fields of a run's volumes: loaded once, and kept as long as the next frame shows them too.
#pragma once

#include "guarded_load.h"
#include "options.h"

#include <scrim/shot/assemble.h>
#include <scrim/scene/scene.h>
#include <scrim/scene/volume_file.h>

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace scrim::cli {

using Fields = std::vector<VolumeFields>;

class FieldStore {
  public:
    FieldStore(LoadLimits limits, MessageSink messages) : m_limits(limits), m_messages(std::move(messages)) {}

    /// What each volume of `scene` needs, all null where `files` has none; forgets the fields of the frame before that
    /// this one does not use. `files[i]` is findVolumeFile's answer to volume i, ignored for sources. Grids that
    /// nothing is made of are not read: of a volume whose densities count for nothing only what it emits, of one that
    /// the picture has no use for (`unseen`) none, unless all of the scene's are wanted. Throws Error.
    Fields fieldsOf(const Scene& scene, const std::vector<VolumeFile>& files, VolumesOf volumesOf = VolumesOf::picture);

    /// One field of a file, kept for the next `fieldsOf`.
    std::shared_ptr<const SparseField> fieldOf(const std::string& path, const GridRequest& request);

  private:
    /// A file, or a source with its parameters.
    using Origin = std::vector<std::string>;
    using Key = std::pair<Origin, GridRequest>;
    struct Use {
        const SceneVolume* volume = nullptr;
        GridRequest request;
        std::string where;  ///< of the request in the scene; "": nothing is said about it
    };

    static Origin originOf(const SceneVolume& volume, const VolumeFile& file);
    static std::vector<Use> usesOf(const SceneVolume& volume);
    static std::vector<std::string> unseenOf(const Scene& scene, const std::vector<VolumeFile>& files);
    void load(const Origin& origin, const std::vector<Use>& missing);
    void make(const Origin& origin, const std::vector<Use>& missing);

    LoadLimits m_limits;
    MessageSink m_messages;
    std::map<Key, std::shared_ptr<const SparseField>> m_fields;
};

/// What the disk has for each volume of `scene`; sources count as present.
std::vector<VolumeFile> findFiles(const Scene& scene);

/// Bytes that the fields take, each counted once.
std::size_t bytesOf(const Fields& fields);

}  // namespace scrim::cli
