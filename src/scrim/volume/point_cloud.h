// SPDX-License-Identifier: Apache-2.0
// Points of a file: dust, sparks, spray. They are read from OpenVDB's point grids (point_grid.h),
// PLY and NumPy files (point_file.h), and become voxels by point_raster.h.
#pragma once

#include <scrim/geometry/spaces.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// A number, or three, of each point.
struct PointAttribute {
    std::string name;
    int width = 1;              ///< 1 or 3
    std::vector<float> values;  ///< `width` of each point
};

struct PointCloud {
    std::string name;
    std::vector<Vec3> positions;  ///< world units of the file; may hold anything
    std::vector<PointAttribute> attributes;
    double spacing = 0;  ///< usual distance of neighbours, where the file knows it; else 0

    const PointAttribute* attribute(const std::string& wanted) const {
        for (const PointAttribute& one : attributes)
            if (one.name == wanted) return &one;
        return nullptr;
    }
};

/// How points become voxels.
struct PointLook {
    double radius = 0;   ///< of all points, in world units of the file; 0: their own
    double scale = 1;    ///< factor on radii
    double voxel = 0;    ///< edge of voxels in world units of the file; 0: chosen by radii
    bool discs = false;  ///< a point weighs as much as its disc, else as its ball
    /// The eye sees the points themselves (PointRaster::list), and voxels only make their light;
    /// none: where they are small beside the voxels that are affordable.
    std::optional<bool> sharp = {};
    /// When velocities are looked at: at points that have moved for these times.
    double open = 0, close = 0;

    bool operator==(const PointLook&) const = default;
};

}  // namespace scrim
