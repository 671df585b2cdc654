// SPDX-License-Identifier: Apache-2.0
// The fields of volumes. They are loaded once and kept as long as the next frame shows them, too.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/shot/assemble.h>
#include <scrim/shot/between_files.h>
#include <scrim/shot/density_detail.h>
#include <scrim/scene/scene.h>
#include <scrim/scene/volume_file.h>
#include <scrim/volume/grid_request.h>
#include <scrim/guard/guarded_load.h>
#include <scrim/guard/load_options.h>
#include <scrim/shot/scan_info.h>
#include <scrim/shot/shaded_field.h>
#include <scrim/volume/source_parameters.h>

#include <compare>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace scrim {

using Fields = std::vector<VolumeFields>;

class FieldStore {
  public:
    explicit FieldStore(LoadOptions options, MessageSink messages = {})
        : m_options(std::move(options)), m_messages(std::move(messages)) {}

    /// Sets how further files are loaded and who receives messages. Loads call `checkpoint`, which may throw.
    void listen(LoadOptions options, MessageSink messages, Checkpoint checkpoint);

    /// Gives the volume named `volume` these grids in place of those of a file or source.
    void setGrids(const std::string& volume, std::vector<SparseField> grids);
    bool hasGrids(const std::string& volume) const { return m_grids.contains(volume); }

    /// The file of each volume of `scene`, as found on disk. Sources and volumes whose grids were set count as present.
    std::vector<VolumeFile> filesOf(const Scene& scene) const;

    /// The fields that each volume of `scene` needs; all null where `files` has no file. Forgets fields of the previous
    /// frame that this one does not use. `files[i]` is findVolumeFile's answer for volume i and is ignored for sources.
    /// Grids that nothing is computed from are not read: only the emission of a volume whose density does not matter,
    /// and nothing of a volume that the picture has no use for (`culled`), unless all volumes of the scene are wanted.
    /// Throws Error.
    Fields fieldsOf(const Scene& scene, const std::vector<VolumeFile>& files, VolumesOf volumesOf = VolumesOf::picture);

    /// Starts child processes that read what `fieldsOf` with the same arguments would load from files; it then takes
    /// over their results. Errors and messages appear only then. Does nothing unless loading is guarded. All children
    /// together may take `memory` bytes (0: no limit); what that does not suffice for is not read ahead.
    void readAhead(const Scene& scene, const std::vector<VolumeFile>& files, VolumesOf volumesOf, std::size_t memory);
    /// Bytes that the children of `readAhead` may take together.
    std::size_t memoryAhead() const;

    /// One field of a file; it is kept for the next `fieldsOf`.
    std::shared_ptr<const SparseField> fieldOf(const std::string& path, const GridRequest& request);
    /// The first field that a source makes; it is kept likewise.
    std::shared_ptr<const SparseField> sourceField(const std::string& source, const SourceParameters& parameters);
    /// The contents of a scan.
    ScanInfo scanInfo(const std::string& path) const;

  private:
    /// Where fields come from: `edit` is the text of what is done to the grids; "": nothing.
    struct FromFile {
        std::string path, edit;
        auto operator<=>(const FromFile&) const = default;
    };
    struct FromCode {
        std::string volume, edit;  ///< the volume whose grids were set
        auto operator<=>(const FromCode&) const = default;
    };
    struct FromSource {
        std::string source;
        SourceParameters parameters;
        std::string edit;
        auto operator<=>(const FromSource&) const = default;
    };
    using Origin = std::variant<FromFile, FromCode, FromSource>;
    using Key = std::pair<Origin, GridRequest>;
    struct Use {
        const SceneVolume* volume = nullptr;
        std::shared_ptr<const GridEdit> edit = nullptr;  ///< what is done to the volume's grids; null: nothing
        GridRequest request;
        std::string where;  ///< where the scene names the grid; "": messages do not mention it
    };

    using Grids = std::vector<std::shared_ptr<const SparseField>>;

    bool isFile(const SceneVolume& volume) const;
    Origin originOf(const SceneVolume& volume, const VolumeFile& file) const;
    static std::vector<Use> usesOf(const SceneVolume& volume, const VolumeFile& file, bool blurred);
    bool listsPoints(const Scene& scene, const SceneVolume& volume, const VolumeFile& file) const;
    /// The grids of one volume, at its moment between two files where it lies between them.
    class GridsOf;
    std::vector<std::string> culledOf(const Scene& scene, const std::vector<VolumeFile>& files) const;
    /// The requests for each origin, which are read in one go; each request once.
    using Uses = std::map<Origin, std::vector<Use>>;
    Uses usesOf(const Scene& scene, const std::vector<VolumeFile>& files, const std::vector<bool>& shown) const;
    std::vector<bool> shownOf(const Scene& scene, const std::vector<VolumeFile>& files,
                              const std::vector<std::string>& culled, VolumesOf volumesOf) const;
    void dropKnown(Uses& uses) const;
    VolumeFields fieldsOf(const Scene& scene, const SceneVolume& volume, const VolumeFile& file, bool blurred);
    void addDensity(const Scene& scene, const SceneVolume& volume, GridsOf& grids, VolumeFields& fields);
    void checkRoom(const Scene& scene, const std::vector<VolumeFile>& files) const;
    void dropSources(Fields& all);
    std::set<FieldPointer> loadedFields() const;
    std::vector<SparseField> fieldsOf(const std::string& path, const std::vector<GridRequest>& requests,
                                      const GridEdit* edit);
    std::optional<std::vector<SparseField>> readBefore(const std::string& path,
                                                       const std::vector<GridRequest>& requests, const GridEdit* edit);
    void begin(const FromFile& file, const std::vector<Use>& missing, const LoadOptions& options);
    void loadFiles(const Uses& uses);
    void load(const FromFile& file, const std::vector<Use>& missing);
    void make(const Origin& origin, const std::vector<Use>& missing);
    void makeEdited(const Origin& origin, const std::vector<Use>& missing, const Grids& grids);
    Grids generated(const SceneVolume& volume) const;

    LoadOptions m_options;
    MessageSink m_messages;
    Checkpoint m_checkpoint;
    std::map<std::string, Grids> m_grids;  ///< grids that were set, by volume
    std::map<Key, std::shared_ptr<const SparseField>> m_fields;
    BetweenStore m_between;
    FieldShader m_shader;
    DetailMaker m_detail;
    /// Fields that children are reading: those of the next frame, or of further files of this one.
    std::vector<GuardedFields> m_ahead;
};

/// Bytes that the fields take, each counted once.
std::size_t bytesOf(const Fields& fields);

}  // namespace scrim
