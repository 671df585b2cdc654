// SPDX-License-Identifier: Apache-2.0
// Bakes the light of a shot's frame into grids, for renderers that know nothing of Scrim.
#pragma once

#include <scrim/shot/shot.h>
#include <scrim/volume/vdb_write.h>

#include <string>
#include <utility>
#include <vector>

namespace scrim {

struct BakeRequest {
    std::vector<std::string> lights;  ///< names of the lights to bake; none: all
    bool emission = false;            ///< also bakes the radiance that media scatter, and their extinction
    bool indirect = false;            ///< also bakes light that has scattered before: its mean radiance and its flux
};

struct BakedShot {
    bool skipped = false;  ///< MissingPolicy::skip skipped the frame; all else is then empty
    std::vector<VdbGrid> grids;
    std::vector<std::pair<std::string, std::string>> metadata;  ///< metadata of the file
};

/// Makes, for each volume, one grid for each light that lights it: the light that arrives at its voxels through all
/// volumes and past all solids. With `emission` it also makes "emission" and "density" (extinction per world unit).
/// With `indirect` it also makes "indirect" and "indirect_flux" (or "indirect_flux_r", "_g" and "_b", where light has
/// colours) of volumes that scatter light more than once. In a scene of one volume a grid is named as its light, else
/// "VOLUME.LIGHT". Grids lie where the scene places the volume. They hold colours where light or extinction is
/// coloured, in the output's colour space, which must be linear. The frame is a single moment: the shutter is ignored.
/// Throws Error.
BakedShot bakeShot(const Shot& shot, int frame, const BakeRequest& request, const RenderOptions& options = {});

}  // namespace scrim
