// SPDX-License-Identifier: Apache-2.0
// What a scan holds, as two small grids in place of its samples, since grids are all that a source makes.
#pragma once

#include "scan.h"

#include <scrim/volume/scrim_source.h>

namespace scan {

/// The grid "histogram": voxel (i, 0, 0) is how many samples have the value that is its x in the world, or lie within
/// half a voxel of it. And a grid "samples of uint8, right-anterior-superior", say, with the scan's transform, whose
/// voxels are the first and the last sample. Returns 0, or what the host said.
int describe(const scrim_host* host, const Scan& scan);

}  // namespace scan
