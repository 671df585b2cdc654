// SPDX-License-Identifier: Apache-2.0
// The fields of volumes: loaded once, and kept as long as the next frame shows them, too.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/shot/assemble.h>
#include <scrim/scene/scene.h>
#include <scrim/scene/volume_file.h>
#include <scrim/volume/grid_request.h>
#include <scrim/guard/guarded_load.h>
#include <scrim/guard/load_options.h>
#include <scrim/shot/scan_info.h>
#include <scrim/volume/source_parameters.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

using Fields = std::vector<VolumeFields>;

class FieldStore {
  public:
    explicit FieldStore(LoadOptions options, MessageSink messages = {})
        : m_options(std::move(options)), m_messages(std::move(messages)) {}

    /// How the next files are loaded, and who hears of it. Loads call `checkpoint`, which may throw.
    void listen(LoadOptions options, MessageSink messages, Checkpoint checkpoint);

    /// From now on the volumes that are called `volume` have these grids, instead of those of a file or source.
    void setGrids(const std::string& volume, std::vector<SparseField> grids);
    bool hasGrids(const std::string& volume) const { return m_grids.contains(volume); }

    /// What the disk has for each volume of `scene`; sources, and volumes whose grids were set, count as present.
    std::vector<VolumeFile> filesOf(const Scene& scene) const;

    /// What each volume of `scene` needs, all null where `files` has none; forgets the fields of the frame before that
    /// this one does not use. `files[i]` is findVolumeFile's answer to volume i, ignored for sources. Grids that
    /// nothing is made of are not read: of a volume whose densities count for nothing only what it emits, of one that
    /// the picture has no use for (`culled`) none, unless all of the scene's are wanted. Throws Error.
    Fields fieldsOf(const Scene& scene, const std::vector<VolumeFile>& files, VolumesOf volumesOf = VolumesOf::picture);

    /// Lets children read what `fieldsOf` would load from files for the same arguments; it then takes it over from
    /// them. Nothing is thrown or told about that before. Only where loading is guarded.
    void readAhead(const Scene& scene, const std::vector<VolumeFile>& files, VolumesOf volumesOf);

    /// One field of a file, kept for the next `fieldsOf`.
    std::shared_ptr<const SparseField> fieldOf(const std::string& path, const GridRequest& request);
    /// The first field that a source makes, kept likewise.
    std::shared_ptr<const SparseField> sourceField(const std::string& source, const SourceParameters& parameters);
    /// What a scan holds.
    ScanInfo scanInfo(const std::string& path) const;

  private:
    /// A file, a source with its parameters, or the name of a volume whose grids were set.
    using Origin = std::vector<std::string>;
    using Key = std::pair<Origin, GridRequest>;
    struct Use {
        const SceneVolume* volume = nullptr;
        GridRequest request;
        std::string where;  ///< of the request in the scene; "": nothing is said about it
    };

    using Grids = std::vector<std::shared_ptr<const SparseField>>;

    bool isFile(const SceneVolume& volume) const;
    Origin originOf(const SceneVolume& volume, const VolumeFile& file) const;
    static std::vector<Use> usesOf(const SceneVolume& volume, bool blurred);
    std::vector<std::string> culledOf(const Scene& scene, const std::vector<VolumeFile>& files) const;
    /// Of each origin, to be read in one go; every request once.
    using Uses = std::map<Origin, std::vector<Use>>;
    Uses usesOf(const Scene& scene, const std::vector<VolumeFile>& files, const std::vector<bool>& shown) const;
    std::vector<bool> shownOf(const Scene& scene, const std::vector<VolumeFile>& files,
                              const std::vector<std::string>& culled, VolumesOf volumesOf) const;
    void dropKnown(Uses& uses) const;
    std::vector<SparseField> fieldsOf(const std::string& path, const std::vector<GridRequest>& requests);
    std::optional<std::vector<SparseField>> readBefore(const std::string& path,
                                                       const std::vector<GridRequest>& requests);
    void load(const Origin& origin, const std::vector<Use>& missing);
    void make(const Origin& origin, const std::vector<Use>& missing);
    Grids generated(const SceneVolume& volume) const;

    LoadOptions m_options;
    MessageSink m_messages;
    Checkpoint m_checkpoint;
    std::map<std::string, Grids> m_grids;  ///< that were set, by volume
    std::map<Key, std::shared_ptr<const SparseField>> m_fields;
    std::vector<GuardedFields> m_ahead;  ///< being read
};

/// Bytes that the fields take, each counted once.
std::size_t bytesOf(const Fields& fields);

}  // namespace scrim
