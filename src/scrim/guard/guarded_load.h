// SPDX-License-Identifier: Apache-2.0
// Internal: reads .vdb files and pictures, and runs volume sources that read files, in a child
// process under limits. Readers can crash on damaged files; then only the child dies, and this
// process reports it. The child belongs to the program `scrim-load` (load_job.h); the result comes
// back through shared memory (field_transfer.h, picture_transfer.h).
#pragma once

#include <scrim/base/messages.h>
#include <scrim/image/light_profile.h>
#include <scrim/image/picture_module.h>
#include <scrim/solid/mesh_module.h>
#include <scrim/volume/grid_edit.h>
#include <scrim/volume/grid_request.h>
#include <scrim/guard/load_job.h>
#include <scrim/guard/load_options.h>
#include <scrim/volume/source_parameters.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_info.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// Fields that a child reads while this process does something else. If this object is destroyed
/// before they are taken, the child ends, too.
class GuardedFields {
  public:
    /// Starts a child that reads, and edits if `edit` is not null. Throws Error where the file
    /// cannot be opened or no child can be started.
    GuardedFields(const std::string& path, const std::vector<GridRequest>& requests, const LoadOptions& options,
                  const GridEdit* edit = nullptr);

    /// Waits for the child and returns its fields. May be called once. Throws as `loadFields`
    /// (load_fields.h); calls `checkpoint` every few milliseconds.
    std::vector<SparseField> take(const MessageSink& messages, const Checkpoint& checkpoint);

    /// Bytes that the child may take.
    std::size_t memory() const { return m_job.memory(); }
    const std::string& path() const { return m_path; }
    const std::vector<GridRequest>& requests() const { return m_requests; }
    const std::optional<GridEdit>& edit() const { return m_edit; }
    /// True if the paths still name the files that were opened and nobody has written to them since.
    bool isCurrent() const;

  private:
    /// Attributes that distinguish versions of a file.
    struct Identity {
        std::uint64_t device = 0, inode = 0, size = 0;
        std::int64_t seconds = 0, nanoseconds = 0;
        bool operator==(const Identity&) const = default;
    };
    static Identity identityOf(const std::string& path);
    /// The identities of all files as these are now.
    std::vector<Identity> identities() const;

    std::string m_path;
    std::vector<GridRequest> m_requests;
    std::optional<GridEdit> m_edit;
    std::vector<Identity> m_identities;
    Descriptor m_transfer;
    LoadJob m_job;
};

/// As `loadFields` and `loadInfo`.
std::vector<SparseField> guardedFields(const std::string& path, const std::vector<GridRequest>& requests,
                                       const LoadOptions& options, const MessageSink& messages,
                                       const Checkpoint& checkpoint, const GridEdit* edit = nullptr);
/// After an edit, what expressions did is part of the metadata.
VdbFileInfo guardedInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint,
                        const GridEdit* edit = nullptr);

/// The picture that the module of pictures (picture_module.h) reads from a regular file. Throws Error as `loadFields`.
FilePicture guardedPicture(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint);

/// The header of a picture alone.
PictureHeader guardedHeader(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint);

/// The depths of a channel; "": of the only channel that can hold them.
FileDepth guardedDepth(const std::string& path, const std::string& channel, const LoadOptions& options,
                       const Checkpoint& checkpoint);

/// The candelas of a photometric file; a defect of the file is reported in its `problem`. Throws Error as `loadFields`.
FilePhotometry guardedPhotometry(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint);

/// The mesh of an OBJ or PLY file; a defect of the file is reported in its `problem`. Throws Error as `loadFields`.
FileMesh guardedMesh(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint);

/// All grids of a .vdb file after an edit, as the bytes of a .vdb file. Throws Error as `loadFields`.
std::string guardedFile(const std::string& path, const GridEdit& edit, const LoadOptions& options,
                        const MessageSink& messages, const Checkpoint& checkpoint);

/// As `editedFields`.
std::vector<SparseField> guardedEdit(const std::vector<SparseField>& grids, const std::string& name,
                                     const std::vector<GridRequest>& requests, const GridEdit& edit,
                                     const LoadOptions& options, const MessageSink& messages,
                                     const Checkpoint& checkpoint);

/// The fields that the source in the shared object `source` makes of these parameters, one of which
/// is `path`. The source can open that file and one other file beside it that it asks for, and no
/// others. Throws Error as `sourceFields` (load_fields.h).
std::vector<SparseField> guardedSource(const std::string& source, const SourceParameters& parameters,
                                       const std::string& path, const LoadOptions& options, const MessageSink& messages,
                                       const Checkpoint& checkpoint);

}  // namespace scrim
