// SPDX-License-Identifier: Apache-2.0
// How volume files are read.
#pragma once

#include <cstddef>
#include <string>

namespace scrim {

enum class VolumeLoading {
    /// In this process. OpenVDB's reader can crash on a damaged file, and then this process crashes.
    plain,
    /// In a child process under a memory limit. Where OpenVDB's reader crashes, an Error says so.
    guarded,
};

struct LoadOptions {
    VolumeLoading volumes = VolumeLoading::plain;
    std::string loader;       ///< guarded: path of the program `scrim`, which is the child
    std::size_t memory = 0;   ///< guarded: bytes that the child may take; 0: depends on the file's size
    int threads = 0;          ///< guarded: of the child; 0: up to 8
    bool showStderr = false;  ///< guarded: shows what the child writes to stderr
};

}  // namespace scrim
