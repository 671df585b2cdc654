// SPDX-License-Identifier: Apache-2.0
// The description of a .vdb file and of its grids: plain data without OpenVDB's types, so that it
// can be printed, sent to another process and tested separately.
#pragma once

#include <scrim/geometry/spaces.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

struct GridInfo {
    std::string name;       ///< as in the file; may be empty, and several grids may share one name
    std::string valueType;  ///< OpenVDB's word: "float", "double", "vec3s", "int32", "bool", "ptdataidx32", ...
    std::string gridClass;  ///< "fog volume", "level set", "staggered" or "unknown"
    std::string codec;      ///< "zip + active values", "blosc + active values", "none", ...; "" if unknown
    bool savedAsHalf = false;
    std::uint64_t activeVoxels = 0;  ///< in leaves
    std::uint64_t activeTiles = 0;   ///< constant regions above leaf level
    Vec3 voxelSize{1.0};             ///< world units; for a grid that is not affine, in the middle of its active bounds
    bool affine = true;
    Mat4 wsFromIs{1.0};  ///< identity where the transform is not affine
    Int3 isLower{0};     ///< active bounds, inclusive; an empty grid has isUpper < isLower
    Int3 isUpper{-1};
    double minValue = 0;  ///< over finite active values of a usable grid, 0 without any
    double maxValue = 0;
    std::uint64_t nonFinite = 0;  ///< active voxels, including those of tiles, that are NaN or infinite
    std::uint64_t negative = 0;   ///< active voxels, including those of tiles, below 0
    bool usable = false;          ///< a field can be made from it: GridOffer::isScalar
    std::string problem;          ///< why it could not be read although the file is sound; all else is then 0
    /// Of a grid of points: their number, their attributes as "pscale (float), v (vec3s)", and a box around their
    /// places. `minValue` and `maxValue` are those of their radii; 0 where they have none.
    std::uint64_t points = 0;
    std::string attributes;
    Vec3 wsLower{0}, wsUpper{0};
    bool colour = false;  ///< one field for each component can be made from it, since it is a vec3 grid of such numbers
};

struct VdbFileInfo {
    std::string path;
    std::uint32_t fileVersion = 0;   ///< version of the file format, 222 to 225 these days
    std::uint32_t libraryMajor = 0;  ///< version of the OpenVDB that wrote it
    std::uint32_t libraryMinor = 0;
    bool isNano = false;      ///< a NanoVDB file, and the versions are NanoVDB's
    std::string pointFormat;  ///< "PLY" or "NumPy": a file of points, without versions
    std::uint64_t fileBytes = 0;
    std::vector<std::pair<std::string, std::string>> metadata;  ///< of the file ("creator", ...), clipped
    std::vector<GridInfo> grids;                                ///< in the file's order
};

}  // namespace scrim
