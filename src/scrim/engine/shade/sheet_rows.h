// SPDX-License-Identifier: Apache-2.0
// Internal: what a shader collects of a tile's samples before it is shaded.
#pragma once

#include <scrim/engine/shade/sheet_shader.h>
#include <scrim/engine/splat/surface.h>

#include <vector>

namespace scrim {

// The data of a tile's samples. It is memory of the thread that only grows, so that shading a tile allocates nothing.
struct SheetShader::Rows {
    using Row = SheetShader::GivenRows::Row;
    std::vector<Row> total;      // sums over all volumes, by extinction channel
    std::vector<Row> seen;       // sums over the visible volumes, by extinction channel; only if some are not visible
    std::vector<Row> medium;     // the extinction of each medium
    std::vector<Row> scatter;    // the scattering of each medium, three colours each
    std::vector<Row> flow;       // the velocity in each medium, three axes each; only for the layer `motion`
    std::vector<Row> motion;     // to the right and up; only for that layer
    std::vector<Row> emission;   // of each source
    std::vector<Row> tauIn;      // by light, and then by extinction channel
    std::vector<Row> tauOut;     // by light; only if surfaces are alone (see surfacesAlone)
    std::vector<Row> unblocked;  // by light; only if solids cast shadows
    std::vector<Row> onCells;    // of each part of the light on cells, three colours each
    std::vector<Row> more;       // what the first halves of surfaces' segments have beyond the mean extinction
    std::vector<Row> coarser;    // positions on the sheet of a coarser level: u and v
    std::vector<Row> outputs;    // three colours for each output beside the beauty
    std::vector<ClassifiedTile> classified;
    std::vector<SheetMedium> media;
    std::vector<SheetSurface> surfaces;
    std::vector<SheetEmission> emissions, opacities;
    std::vector<SheetScattered> scattered;
};

}  // namespace scrim
