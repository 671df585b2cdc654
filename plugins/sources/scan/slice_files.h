// SPDX-License-Identifier: Apache-2.0
// The files of a scan that lies in many: those of a folder of the disk, or those that one file holds in place of a
// folder (scrim_source.h). Readers see no difference.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace scan {

/// A file of a series: either of the disk, or a part of the file that holds all of them.
struct SliceFile {
    std::string name;                    ///< within the folder
    std::string path;                    ///< of the file that is opened
    std::int64_t begin = 0, bytes = -1;  ///< the part of it; -1: all

    /// All bytes, or the first `most` of them; fewer where the file cannot be read.
    std::string contents(std::int64_t most = -1) const;
};

/// Whether these are the first bytes of a DICOM or a TIFF file; the first kStart of them are enough.
bool beginsAsDicom(const std::string& bytes);
bool beginsAsTiff(const std::string& bytes);
constexpr std::int64_t kStart = 132;

/// True for folders, and for files that hold one.
bool isFolder(const std::string& path);

/// The files of a folder, or of a file that holds one, by name. Throws "PATH: ..." where they are incomplete.
std::vector<SliceFile> filesIn(const std::string& folder);

/// True where the name of `path` has a '*', which stands for any characters, and no file is called so.
bool isPattern(const std::string& path);

/// The files whose names match the pattern `path`, in its folder or in the file that holds one under that name.
std::vector<SliceFile> filesMatching(const std::string& path);

}  // namespace scan
