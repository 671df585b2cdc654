// SPDX-License-Identifier: Apache-2.0
// The fields of a run's volumes: loaded once, and kept as long as the next frame shows them too.
#pragma once

#include "guarded_load.h"
#include "options.h"

#include <scrim/render/assemble.h>
#include <scrim/scene/scene.h>
#include <scrim/scene/volume_file.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace scrim::cli {

using Fields = std::vector<VolumeFields>;

class FieldStore {
  public:
    FieldStore(LoadLimits limits, MessageSink messages) : m_limits(limits), m_messages(std::move(messages)) {}

    /// One field a volume of `scene`, null where `files` has none; forgets those of the frame before that
    /// this one does not use. `files[i]` is findVolumeFile's answer to volume i, ignored for sources. Throws
    /// Error.
    Fields fieldsOf(const Scene& scene, const std::vector<VolumeFile>& files);

    /// One field of a file, kept for the next `fieldsOf`.
    std::shared_ptr<const SparseField> fieldOf(const std::string& path, const std::string& grid);

  private:
    using Key = std::vector<std::string>;

    void loadMissing(const std::string& path, const std::vector<std::string>& grids);
    void makeMissing(const SceneVolume& volume);

    LoadLimits m_limits;
    MessageSink m_messages;
    std::map<Key, std::shared_ptr<const SparseField>> m_fields;
};

/// What the disk has for each volume of `scene`; sources count as present.
std::vector<VolumeFile> findFiles(const Scene& scene);

/// Bytes that the fields take, each counted once.
std::size_t bytesOf(const Fields& fields);

}  // namespace scrim::cli
