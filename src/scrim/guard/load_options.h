// SPDX-License-Identifier: Apache-2.0
// How volumes, slides, and what volume sources read, are read from files.
#pragma once

#include <cstddef>
#include <string>

namespace scrim {

enum class VolumeLoading {
    /// In this process, and no other. Readers (OpenVDB's, Assimp's) can crash on a damaged file, and then this process
    /// crashes.
    plain,
    /// In a child process that can do nothing but read, under limits of memory and time, and slides' pictures, too. So
    /// do volume sources that are given a `file` (scrim_source.h): they find that file and one other of its folder.
    /// Where a reader crashes, an Error says so. The first such load starts the program `scrim-load` (once for volumes
    /// and sources, once for slides), which serves all others and ends with this process.
    guarded,
};

struct LoadOptions {
    VolumeLoading volumes = VolumeLoading::plain;
    std::string loader = {};  ///< guarded: path of the program `scrim-load`; "": the one installed with this library
    std::size_t memory = 0;   ///< guarded: bytes that the child may take, at least 1 GB; 0: depends on the file's size
    bool showStderr = false;  ///< guarded: shows what the child writes to stderr
};

}  // namespace scrim
