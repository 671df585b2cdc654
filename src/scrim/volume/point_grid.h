// SPDX-License-Identifier: Apache-2.0
// Internal: reads OpenVDB's point grids, and makes grids of the voxels that points become. Only the
// .cpp files that use OpenVDB include this header.
#pragma once

#include <scrim/volume/point_cloud.h>
#include <scrim/volume/point_raster.h>
#include <scrim/volume/vdb_info.h>

#include <functional>
#include <string>
#include <vector>

#include <openvdb/openvdb.h>

namespace scrim {

/// True for an OpenVDB grid of points.
bool isPointGrid(const openvdb::GridBase& grid);

/// The points of such a grid, with those attributes of numbers or of vectors of three for whose names `wanted` is true,
/// and their radii and densities. Throws Error(input), without a file, where its points are damaged.
PointCloud pointsOf(const openvdb::GridBase& grid, const std::function<bool(const std::string&)>& wanted);

/// The attributes of points but their places, in the order of their names: "pscale (float), v (vec3s)".
std::string attributesOf(const openvdb::GridBase& grid);
std::string attributesOf(const PointCloud& cloud);

/// Adds what is known of points to their description.
void describePoints(const PointCloud& cloud, GridInfo& info);

/// The density of the points (null attribute) as a fog volume, or means of one of their attributes.
openvdb::GridBase::Ptr gridOf(const PointRaster& raster, const PointBlocks& blocks, const PointAttribute* attribute,
                              const std::string& name);

}  // namespace scrim
