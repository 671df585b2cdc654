// SPDX-License-Identifier: Apache-2.0
// Stage 2b of a batch: classification (ZC02 Fig. 5, lines 12 and 13). The field of a classified volume in its sheets,
// with some sheets more on either side for gradients; the extinction that its transfer function gives to lights, at
// texels; and what the eye sees of it at the samples of a tile: extinction, colour and normals.
//
// Along each eye ray the field is linear between its values on the planes of this sheet and its two neighbours; the
// transfer function is averaged over the part of that run that lies within the sheet (transfer.h).
//
// Normals come from central differences over a voxel on either side (ZC02 section 3.1), within the sheet and across
// sheets, but along the axes of the volume's own lattice instead of the sheet's: there they are the differences at
// lattice points, interpolated, and do not depend on how the sheets happen to lie.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/samples.h>
#include <scrim/engine/splat/transfer.h>
#include <scrim/engine/splat/field_planes.h>
#include <scrim/engine/splat/plane_sampling.h>

namespace scrim {

/// Classified samples: of the eye's segments through the sheet.
struct ClassifiedTile {
    alignas(64) Real front[kTileSize];  ///< the field where the segments begin, in their middle, where they end
    alignas(64) Real middle[kTileSize];
    alignas(64) Real back[kTileSize];
    alignas(64) Real extinction[kTileSize];   ///< mean, per world unit
    alignas(64) Real emission[3][kTileSize];  ///< mean of extinction times colour
    alignas(64) Real normal[3][kTileSize];    ///< unit, in sweep space, out of the denser side
    alignas(64) Real weight[kTileSize];       ///< of the normal, see normalWeight
};

class Surface {
  public:
    /// `volume` is a classified one and must outlive this, as `sheets` and `lattice`. `voxel`: unit of the dials.
    Surface(const ViewVolume& volume, const Dials& dials, const Sheets& sheets, const Lattice& lattice, int batchSheets,
            double voxel);

    /// Of the field, to be splatted before all that follows.
    FieldPlanes& field() { return m_field; }
    const FieldPlanes& field() const { return m_field; }
    /// Begins a batch; that of `field` is begun apart.
    void beginBatch(int firstSheet) { m_firstSheet = firstSheet; }

    /// Classifies the texels of sheet firstSheet + p for the lights: `extinction`, planes [0, count).
    void classifyTexels(int p);
    const PlaneStack& extinction() const { return m_extinction; }

    /// Classifies what the eye sees at positions `at` of the lattice on sheet firstSheet + p. `tile`: of the lattice,
    /// where it is a perspective view's. False, with an extinction of 0, where the samples show nothing.
    bool classify(int p, const SampleTile& at, const Int2& tile, ClassifiedTile& out) const;

    std::size_t bytes() const;
    /// An upper estimate beforehand.
    static std::size_t bytes(const ViewVolume& volume, const Dials& dials, const Sheets& sheets, const Lattice& lattice,
                             int batchSheets);
    /// Sheets on either side of a batch that gradients reach into.
    static int halo(const ViewVolume& volume, const Sheets& sheets);

  private:
    // The differences that normals come from.
    struct GradientStep {
        Vec3 rsVoxel[3];        // one voxel along each axis of the lattice, in the raster's cells and sheets
        Mat3 ssFromDifference;  // takes differences over two voxels to the gradient in sweep space, per world unit
    };
    GradientStep stepFor(const Mat4& rsFromTs) const;
    GradientStep stepAt(int p, const Int2& tile) const;
    FloatPlane plane(int p, int steps) const;
    void sampleRun(int p, const SampleTile& at, ClassifiedTile& run) const;
    void sampleBetween(int p, const SampleTile& at, const Vec3& tsOffset, Real* out) const;
    void findNormals(int p, const SampleTile& at, const GradientStep& step, ClassifiedTile& out) const;

    const Sheets& m_sheets;
    const Lattice& m_lattice;
    Mat4 m_wsFromIs;
    Simd m_simd;
    TransferTable m_table;
    double m_vagueGradient;
    GradientStep m_step;  // of a parallel lattice: the same everywhere
    FieldPlanes m_field;
    PlaneStack m_extinction;
    int m_firstSheet = 0;
};

}  // namespace scrim
