// SPDX-License-Identifier: Apache-2.0
// Describes a scan by two small grids in place of its samples, since a source can make nothing but grids.
#pragma once

#include "scan.h"

#include <scrim/volume/scrim_source.h>

namespace scan {

/// Emits two grids. In "histogram", voxel (i, 0, 0) counts the samples whose value is the voxel's x in the world, or
/// within half a voxel of it. The other grid is named "samples of uint8, right-anterior-superior", "samples of uint8 in
/// micron", "... in unknown steps" or the like, has the scan's transform, and its voxels are the first and the last
/// sample. Returns 0, or the host's error.
int describe(const scrim_host* host, const Scan& scan);

}  // namespace scan
