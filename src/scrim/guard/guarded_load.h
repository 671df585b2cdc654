// SPDX-License-Identifier: Apache-2.0
// Internal: reads .vdb files and pictures, and runs volume sources that read files, in a child process under limits.
// Readers can crash on damaged files, and then the child dies and this process says so. The child is one of the program
// `scrim-load` (load_job.h); the result comes back through shared memory (field_transfer.h, picture_transfer.h).
#pragma once

#include <scrim/base/messages.h>
#include <scrim/image/picture_module.h>
#include <scrim/solid/mesh_module.h>
#include <scrim/volume/grid_request.h>
#include <scrim/guard/load_job.h>
#include <scrim/guard/load_options.h>
#include <scrim/volume/source_parameters.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_info.h>

#include <cstdint>
#include <string>
#include <vector>

namespace scrim {

/// Fields that a child reads while this process does something else. Where this ends before it is taken, so does the
/// child.
class GuardedFields {
  public:
    /// Lets a child begin to read. Throws Error where the file cannot be opened, or no child started.
    GuardedFields(const std::string& path, const std::vector<GridRequest>& requests, const LoadOptions& options);

    /// Waits for the child, and takes over what it read. Once. Throws as `loadFields` (load_fields.h); calls
    /// `checkpoint` every few milliseconds.
    std::vector<SparseField> take(const MessageSink& messages, const Checkpoint& checkpoint);

    const std::string& path() const { return m_path; }
    const std::vector<GridRequest>& requests() const { return m_requests; }
    /// Whether the path still names the file that was opened, and nobody has written to it.
    bool isCurrent() const;

  private:
    /// What tells versions of a file from one another.
    struct Identity {
        std::uint64_t device = 0, inode = 0, size = 0;
        std::int64_t seconds = 0, nanoseconds = 0;
        bool operator==(const Identity&) const = default;
    };
    static Identity identityOf(const std::string& path);

    std::string m_path;
    std::vector<GridRequest> m_requests;
    Identity m_identity;
    Descriptor m_transfer;
    LoadJob m_job;
};

/// As `loadFields` and `loadInfo`.
std::vector<SparseField> guardedFields(const std::string& path, const std::vector<GridRequest>& requests,
                                       const LoadOptions& options, const MessageSink& messages,
                                       const Checkpoint& checkpoint);
VdbFileInfo guardedInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint);

/// What the module of pictures (picture_module.h) makes of a regular file. Throws Error as `loadFields`.
FilePicture guardedPicture(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint);

/// Its header alone.
PictureHeader guardedHeader(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint);

/// The depths of a channel; "": of the one that must be it.
FileDepth guardedDepth(const std::string& path, const std::string& channel, const LoadOptions& options,
                       const Checkpoint& checkpoint);

/// An OBJ or PLY file. What is wrong with it is its `problem`. Throws Error as `loadFields`.
FileMesh guardedMesh(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint);

/// What the source in the shared object `source` makes of these parameters, of which one is `path`. It finds that file
/// and one other beside it, which it asks for, and nothing else. Throws Error as `sourceFields` (load_fields.h).
std::vector<SparseField> guardedSource(const std::string& source, const SourceParameters& parameters,
                                       const std::string& path, const LoadOptions& options, const MessageSink& messages,
                                       const Checkpoint& checkpoint);

}  // namespace scrim
