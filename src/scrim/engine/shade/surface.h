// SPDX-License-Identifier: Apache-2.0
// Classification of a tile's worth of samples of one sheet (ZC02 Fig. 5, lines 12 and 13): field in, extinction,
// colour and normals out.
//
// Along each eye ray the field is linear between its values on the planes of this sheet and its two neighbours; the
// transfer function is averaged over the part of that run that lies within the sheet (transfer_table.h).
//
// Normals come from central differences over a voxel on either side (ZC02 section 3.1), within the sheet and across
// sheets, but along the axes of the volume's own lattice instead of the sheet's: there they are the differences at
// lattice points, interpolated, and do not hang on how the sheets happen to lie.
#pragma once

#include <scrim/base/simd.h>
#include <scrim/geometry/sheets.h>
#include <scrim/engine/shade/shade_tile.h>
#include <scrim/engine/shade/transfer.h>

namespace scrim {

/// What a sheet and its neighbours know of a field: planes of one raster, in a ring. Samples are given in its cells,
/// with the slopes that eye rays have there: none in a raster that is aligned with the eye.
struct ValuePlanes {
    const float* planes;         ///< of the whole ring
    std::ptrdiff_t planeStride;  ///< floats
    int ring;                    ///< number of planes
    int here;                    ///< the sheet's own
    int width, height;
    Simd simd = {};

    /// The plane `steps` sheets away, |steps| < ring.
    const float* at(int steps) const { return planes + (here + steps + ring) % ring * planeStride; }
};

/// The field at both faces and in the middle of a sheet, from its values on the planes of sheets n - 1, n and n + 1.
///
/// Those are means over sheets, and between them the field is taken to be linear. Either makes it smoother than it is:
/// over a sheet, by a 24th and on average by a twelfth of the second difference. An eighth of it is taken away again
/// (as unblur.h does within the sheet), which halves the error of sharp transfer functions.
struct SheetRun {
    float front, middle, back;
};
inline SheetRun runThroughSheet(float before, float here, float behind) {
    const float blur = 0.125f * (before - 2 * here + behind);
    const auto sharp = [blur](float value) { return value > blur ? value - blur : 0.0f; };
    return {sharp(0.5f * (before + here)), sharp(here), sharp(0.5f * (here + behind))};
}

/// The differences that normals come from.
struct GradientStep {
    Vec3 rsVoxel[3];        ///< one voxel along each axis of the lattice, in the raster's cells and sheets
    Mat3 ssFromDifference;  ///< takes differences over two voxels to the gradient in sweep space, per world unit
    int reach = 1;          ///< sheets that classification looks to either side
};
GradientStep gradientStep(const Mat4& rsFromIs, const Mat3& ssFromWs, const Mat4& wsFromIs);

/// Classified samples: of the eye's segments through the sheet.
struct ClassifiedTile {
    alignas(64) float front[kTileSize];  ///< the field where the segments begin, in their middle, where they end
    alignas(64) float middle[kTileSize];
    alignas(64) float back[kTileSize];
    alignas(64) float extinction[kTileSize];   ///< mean, per world unit
    alignas(64) float emission[3][kTileSize];  ///< mean of extinction times colour
    alignas(64) float normal[3][kTileSize];    ///< unit, in sweep space, out of the denser side
    alignas(64) float weight[kTileSize];       ///< of the normal, see normalWeight
};

/// Fills in the field and `extinction`; false (and all of the latter 0) where the samples show nothing.
bool classifyExtinction(const ValuePlanes& planes, const SampleTile& samples, const Sheets& sheets,
                        const TransferTable& table, ClassifiedTile& out);

/// Fills in the rest, after classifyExtinction.
void classifySurface(const ValuePlanes& planes, const SampleTile& samples, const GradientStep& step,
                     double vagueGradient, const TransferTable& table, ClassifiedTile& out);

}  // namespace scrim
