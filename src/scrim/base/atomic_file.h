// SPDX-License-Identifier: Apache-2.0
// Output files that appear completely or not at all: they are written beside their place and renamed into it. This is
// separate from the writers, since each of them needs it and none should know how it is done.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

namespace scrim {

/// One output file that is being written. Write to `tempPath()` by any means, close it, then call `commit()`. Without
/// that the destructor removes what was written, and the old file, if any, stays as it was. Must not be used from
/// several threads at once; different AtomicFiles are independent, also across machines that share the folder.
///
/// To others it looks as if the file had been written in place. A symbolic link stays, and the file it leads to is
/// replaced, or made where there is none yet. A file that is replaced hands on its permissions, and its owner and group
/// where this process may give files away. Only further hard links keep the old content.
class AtomicFile {
  public:
    /// Creates an empty temporary file in the folder of the file that `path` means: hidden, with a unique name and the
    /// extension of `path`, since libraries choose formats by it. Makes missing folders, which are removed again with a
    /// file that is not committed. Throws an Error of kind `output` where a folder cannot be made or written to, where
    /// links cannot be followed, or where `path` is something other than a regular file (renaming over a device such as
    /// /dev/null would destroy it).
    explicit AtomicFile(std::string path);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    const std::string& path() const { return m_path; }
    const std::string& tempPath() const { return m_tempPath; }

    /// Flushes the temporary file to disk and renames it over `path`. May be called once. Throws an
    /// Error of kind `output`; the destructor then still removes the temporary file.
    void commit();

  private:
    /// Who may use a file.
    struct Ownership {
        mode_t mode = 0;
        uid_t user = 0;
        gid_t group = 0;
    };

    void checkPlace();
    void open();
    void makeFolders();
    void handOnOwnership() const;
    void removeMadeFolders() noexcept;

    std::string m_path;    ///< as given, for messages
    std::string m_target;  ///< where the symbolic links at `m_path` lead; `m_path` where there are none
    std::string m_tempPath;
    std::optional<Ownership> m_replaced;  ///< of the file that was there
    std::vector<std::string> m_madeFolders;
    int m_file = -1;  ///< holds a lock, which tells others that the writer is alive
    int m_slot = -1;  ///< index in the registry of uncommitted files; negative where that is full
    bool m_committed = false;
};

/// Writes `bytes` to `path` through an AtomicFile. Throws an Error of kind `output`.
void writeWholeFile(const std::string& path, std::string_view bytes);

/// Removes this process's temporary files that are not committed. For signal handlers: it calls only async-signal-safe
/// functions. At most 64 files are remembered at a time. After a fork, the files of the parent are left to the parent.
void removeUncommittedFiles() noexcept;

/// Removes temporary files in `folder` ("": the current one) whose writers were killed before they
/// could remove them. Those of other machines that share the folder are removed after a day.
void removeAbandonedFiles(const std::string& folder) noexcept;

}  // namespace scrim
