// SPDX-License-Identifier: Apache-2.0
// The light of a shot's frame as grids, for renderers that know nothing of Scrim.
#pragma once

#include <scrim/shot/shot.h>
#include <scrim/volume/vdb_write.h>

#include <string>
#include <utility>
#include <vector>

namespace scrim {

struct BakeRequest {
    std::vector<std::string> lights;  ///< names; none: all
    bool emission = false;            ///< also what media scatter, and their extinction
};

struct BakedShot {
    bool skipped = false;  ///< by MissingPolicy::skip; the rest is empty then
    std::vector<VdbGrid> grids;
    std::vector<std::pair<std::string, std::string>> metadata;  ///< of the file
};

/// Of each volume a grid for each light that lights it: what arrives at its voxels, through all volumes and past all
/// solids; with the request's `emission` also "emission" and "density" (extinction per world unit). In a scene of one
/// volume grids are called as the light, else "VOLUME.LIGHT". They lie where the scene has the volume, and hold colours
/// where light or extinction have any, in the output's colour space, which must be linear. A moment: no shutter is
/// open. Throws Error.
BakedShot bakeShot(const Shot& shot, int frame, const BakeRequest& request, const RenderOptions& options = {});

}  // namespace scrim
