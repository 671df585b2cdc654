// SPDX-License-Identifier: Apache-2.0
// The outer structure of a .vdb file, checked before OpenVDB sees a byte of it.
//
// OpenVDB believes the lengths it reads: one flipped byte in a name's length makes it allocate gigabytes. The
// header, the descriptors and each grid's metadata are a simple chain of lengths and offsets that must end
// exactly at the end of the file; walking it costs microseconds and catches every truncation and most damage
// outside the voxels. What is inside a grid's tree is OpenVDB's business (and that of the process that guards
// it).
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/volume/vdb_bytes.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace scrim {

struct VdbLayout {
    struct Grid {
        std::string name;         ///< without the suffix OpenVDB adds to tell equal names apart
        std::string type;         ///< "Tree_float_5_4_3", ...
        std::string codec;        ///< "zip + active values", "blosc", "none", ...
        std::string gridClass;    ///< "fog volume", "level set", ...; "" where its metadata do not say
        bool instance = false;    ///< has no tree of its own, but that of another grid
        std::uint64_t begin = 0;  ///< of the bytes of its descriptor and its data
        std::uint64_t end = 0;
        /// Active bounds, inclusive, as its writer noted them in its metadata, if it did.
        std::optional<Int3> isLower, isUpper;
        std::string map;          ///< the kind of its transform: "UniformScaleMap", ...
        std::uint64_t mapAt = 0;  ///< of the first byte of the transform's numbers
    };
    std::uint32_t fileVersion = 0;
    std::uint32_t libraryMajor = 0;
    std::uint32_t libraryMinor = 0;
    std::string creator;           ///< the program that wrote it, as it says in the file's metadata; "": it does not
    bool isNewer = false;          ///< than any version that is known here: what is said below may be missing
    bool hasOffsets = false;       ///< written to a file, not to a pipe
    std::uint64_t gridsBegin = 0;  ///< of the number of grids (int32), which ends the header; with offsets only
    std::vector<Grid> grids;       ///< empty where the file does not say where grids begin (no offsets, or before 222)
};

/// Throws Error(input) "path: not a VDB file (...)" or "path: truncated or damaged: ...".
VdbLayout checkVdbLayout(const VdbBytes& bytes);
VdbLayout checkVdbLayout(const std::string& path, std::span<const char> bytes);

}  // namespace scrim
