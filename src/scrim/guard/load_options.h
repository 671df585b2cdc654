// SPDX-License-Identifier: Apache-2.0
// How files of volumes, slides and volume sources are read.
#pragma once

#include <cstddef>
#include <string>

namespace scrim {

enum class VolumeLoading {
    /// In this process. Readers (OpenVDB's, Assimp's) can crash on a damaged file, and then this process crashes.
    plain,
    /// In a child process that can do nothing but read, under limits of memory and time. This includes slides' pictures
    /// and volume sources with a parameter `file` (scrim_source.h), which can open that file and one other of its
    /// folder. A crash of a reader becomes an Error. The first such load starts the program `scrim-load` (one for
    /// volumes and sources, one for slides), which serves all later loads and ends with this process.
    guarded,
};

struct LoadOptions {
    /// With less than this, the reader itself would take a sound small file for a damaged one.
    static constexpr std::size_t kLeastMemory = std::size_t{1} << 30;

    VolumeLoading volumes = VolumeLoading::plain;
    std::string loader = {};  ///< guarded: path of the program `scrim-load`; "": the one installed with this library
    /// Guarded: bytes that the child may take, at least kLeastMemory; 0: a limit that depends on the file's size.
    std::size_t memory = 0;
    bool showStderr = false;  ///< guarded: shows what the child writes to stderr
};

}  // namespace scrim
