// SPDX-License-Identifier: Apache-2.0
// The outer structure of a .vdb file, checked before OpenVDB sees a byte of it.
//
// OpenVDB believes the lengths it reads: one flipped byte in a name's length makes it allocate gigabytes. The header,
// the descriptors and each grid's metadata form a simple chain of lengths and offsets that must end exactly at the end
// of the file. Walking it costs microseconds and catches every truncation and most damage outside of the voxels. The
// contents of a grid's tree are left to OpenVDB (and to the process that guards it).
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
    /// How a grid lies in a NanoVDB file.
    struct Nano {
        std::uint32_t type = 0;   ///< nanovdb::GridType
        std::uint16_t codec = 0;  ///< 0: none, 1: zip, 2: blosc
        std::uint64_t bytes = 0;  ///< in memory
    };
    struct Grid {
        std::string name;         ///< without the suffix OpenVDB adds to tell equal names apart
        std::string type;         ///< "Tree_float_5_4_3", ...
        std::string codec;        ///< "zip + active values", "blosc", "none", ...
        std::string gridClass;    ///< "fog volume", "level set", ...; "" where the metadata does not say
        bool instance = false;    ///< the grid has no tree of its own, but uses that of another grid
        std::uint64_t begin = 0;  ///< start of the bytes of its descriptor and its data
        std::uint64_t end = 0;
        /// Active bounds, inclusive, if the writer stored them in the metadata.
        std::optional<Int3> isLower, isUpper;
        std::string map;          ///< kind of its transform: "UniformScaleMap", ...
        std::uint64_t mapAt = 0;  ///< position of the first byte of the transform's numbers
        /// In a NanoVDB file, where `begin` and `end` are those of the grid alone, and there is no map.
        std::optional<Nano> nano = {};
    };
    std::uint32_t fileVersion = 0;
    std::uint32_t libraryMajor = 0;
    std::uint32_t libraryMinor = 0;
    std::string creator;      ///< the program that wrote the file, by the file's metadata; "": unknown
    bool isNewer = false;     ///< the version is newer than all that are known here; what follows may be missing
    bool hasOffsets = false;  ///< the file was written to disk, not to a pipe
    bool isNano = false;      ///< a NanoVDB file (nano_layout.h), whose versions are NanoVDB's
    std::string points{};     ///< "PLY" or "NumPy": a file of points (point_file.h), which has no versions
    /// Position of the number of grids (int32), which ends the header; only with offsets.
    std::uint64_t gridsBegin = 0;
    /// Empty where the file does not say where grids begin (no offsets, or before version 222).
    std::vector<Grid> grids;
};

/// Of an OpenVDB or a NanoVDB file, or of points. Throws Error(input) "path: not a VDB file (...)"
/// or "path: truncated or damaged:
/// ...".
VdbLayout checkVdbLayout(const VdbBytes& bytes);
VdbLayout checkVdbLayout(const std::string& path, std::span<const char> bytes);

}  // namespace scrim
