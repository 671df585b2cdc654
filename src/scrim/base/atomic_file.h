// SPDX-License-Identifier: Apache-2.0
// Output files appear whole or not at all: they are written beside their place and renamed into it. Apart
// from the writers, since every one of them needs it and none should know how it is done.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace scrim {

/// One output file under way. Write to `tempPath()` by any means, close it, then `commit()`; without that the
/// destructor removes what was written and the old file, if any, stays as it was. Not for use from several
/// threads at once; different AtomicFiles are independent, also across machines that share the folder.
class AtomicFile {
  public:
    /// Creates an empty temporary file in the folder of `path`: hidden, of a name nobody else has, with the
    /// extension of `path`, since libraries choose formats by it. Makes missing folders, which go again with a
    /// file that is not committed. Throws an Error of kind `output` where a folder cannot be made or written
    /// to, or where `path` is something other than a regular file (renaming over a device such as /dev/null
    /// would destroy it).
    explicit AtomicFile(std::string path);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    const std::string& path() const { return m_path; }
    const std::string& tempPath() const { return m_tempPath; }

    /// Brings the temporary file to the disk and renames it over `path`. Throws an Error of kind `output`;
    /// the temporary file is then still removed by the destructor. At most once.
    void commit();

  private:
    void open();
    void makeFolders();
    void removeMadeFolders() noexcept;

    std::string m_path;
    std::string m_tempPath;
    std::vector<std::string> m_madeFolders;
    int m_file = -1;  ///< holds the lock that tells others that the writer is there
    int m_slot = -1;  ///< in the registry of uncommitted files; negative where that is full
    bool m_committed = false;
};

/// Writes `bytes` to `path` through an AtomicFile. Throws an Error of kind `output`.
void writeWholeFile(const std::string& path, std::string_view bytes);

/// Removes the temporary files of this process that are not committed. For signal handlers: it calls only
/// async-signal-safe functions. Not more than 64 files are remembered at a time; files of a parent process,
/// in a fork, are left to the parent.
void removeUncommittedFiles() noexcept;

/// Removes temporary files in `folder` ("": the current one) whose writers are gone: killed, before they could do so
/// themselves. Those of other machines that share the folder go after a day.
void removeAbandonedFiles(const std::string& folder) noexcept;

}  // namespace scrim
