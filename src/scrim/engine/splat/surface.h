// SPDX-License-Identifier: Apache-2.0
// Stage 2b of a batch: classification (ZC02 Fig. 5, lines 12 and 13). It holds the field of a classified volume in its
// sheets, with one more on either side; the extinction that its transfer function gives at texels, for lights; and what
// the eye sees of it at the samples of a tile: extinction, colour and normals.
//
// Along each eye ray the field is linear between its values on the planes of this sheet and its two neighbours. The
// transfer function is averaged over the part of that course that lies within the sheet (TransferTable).
//
// The splats tell where rays may meet something. There, what the eye sees is looked up in the
// volume's own field: between texels the splatted field is smoother than that, and a surface would
// show it as dents. Lights, whose rays cross many sheets before their shadows show, take the
// splatted field, but at the border of the field where the first trace of a value shows (isRim).
//
// Normals come from central differences over a voxel to either side (ZC02 section 3.1), along the
// axes of the volume's own lattice. Their lengths may weight extinction.
//
// Where the volume is clipped, the part of each ray's course that lies within the clip is
// classified in place of the whole. It is exact for one face, and sharp within a sheet.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/splat/field_planes.h>
#include <scrim/engine/splat/plane_stack.h>
#include <scrim/engine/splat/transfer_table.h>
#include <scrim/scene/classified.h>
#include <scrim/base/simd.h>
#include <scrim/volume/field_sampler.h>

#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

namespace scrim {

/// Classified samples of a tile's rays, the eye's or a light's, on their way through a sheet. Who follows the rays from
/// sheet to sheet keeps it, so that each plane is looked up once; who turns to other rays calls `leave`.
struct ClassifiedTile {
    static constexpr int kNoSheet = std::numeric_limits<int>::min();
    void leave() { sheet = exactSheet = kNoSheet; }

    bool halves = false;                    ///< `firstHalf` is asked for
    int count = kTileSize;                  ///< of samples that are asked for; a multiple of 16
    int sheet = kNoSheet;                   ///< of `planes`
    int exactSheet = kNoSheet;              ///< of `leaves`
    alignas(64) Real planes[3][kTileSize];  ///< the field of the splats on sheet n - 1, n, n + 1, at n % 3
    alignas(64) Real leaves[kTileSize];  ///< the volume's own field where the segments end; NaN: it was not asked for
    alignas(64) Real front[kTileSize];   ///< the field where the segments begin, in their middle, and where they end
    alignas(64) Real middle[kTileSize];
    alignas(64) Real back[kTileSize];
    alignas(64) Real extinction[kTileSize];   ///< mean, per world unit
    alignas(64) Real firstHalf[kTileSize];    ///< with `halves`: of the half of each segment where it begins
    alignas(64) Real emission[3][kTileSize];  ///< mean of extinction times colour
    alignas(64) Real normal[3][kTileSize];    ///< unit, in sweep space, pointing out of the denser side
    alignas(64) Real weight[kTileSize];       ///< weight of the normal, see normalWeight
};

class Surface {
  public:
    /// `volume` must be classified, and must outlive this object, as must `sheets` and `lattice`.
    /// `voxel`: unit of the dials.
    Surface(const ViewVolume& volume, const Dials& dials, const Sheets& sheets, const Lattice& lattice, int batchSheets,
            double voxel);

    /// The field, which must be splatted before all that follows.
    FieldPlanes& field() { return m_field; }
    const FieldPlanes& field() const { return m_field; }
    /// Begins a batch; the batch of `field` is begun separately.
    void beginBatch(int firstSheet) { m_firstSheet = firstSheet; }

    /// Classifies the texels of sheet firstSheet + p for the lights; the result is in `extinction`, planes [0, count).
    /// Without `values`, the tiles that may show something are active, and hold zeros.
    void classifyTexels(int p, bool values);
    const PlaneStack& extinction() const { return m_extinction; }

    /// The mean extinction, per world unit, that a light's rays meet in sheet firstSheet + p. They cross the sheet's
    /// middle plane at `at`, with its slopes (eyeA, eyeB). Returns false, with an extinction of 0, if there is none.
    bool meanExtinction(int p, const SampleTile& at, ClassifiedTile& out) const;
    /// The same for the rays through 16 x 16 cells of a light's raster, from `cell` on.
    /// `open`: as in classify; the others are as the splats have them.
    bool meanExtinction(int p, const LightView& view, const Int2& cell, const std::uint8_t* open,
                        ClassifiedTile& out) const;

    /// Classifies what the eye sees at positions `at` of the lattice on sheet firstSheet + p. `open`: null, or 256
    /// flags; samples whose flag is 0 are hidden and have an extinction of 0. `out`: that of the sheet before if the
    /// rays are the same. Returns false, with an extinction of 0, if the samples show nothing.
    bool classify(int p, const SampleTile& at, const std::uint8_t* open, ClassifiedTile& out) const;

    std::size_t bytes() const { return m_field.bytes() + m_extinction.bytes(); }
    /// Upper bound on the bytes, known beforehand.
    static std::size_t bytes(const ViewVolume& volume, const Dials& dials, const Sheets& sheets, const Lattice& lattice,
                             int batchSheets);
    /// The number of sheets on either side of a batch that are looked up. A ray's course takes one,
    /// and lights are followed from two sheets before.
    static constexpr int kBefore = 3, kBehind = 1;

  private:
    FloatPlane plane(int p, int steps) const;
    struct Some;
    // The place (x, y) of the lattice at N = n: in the axes of `m_faces`, (x W, y W, N, W); in the
    // volume's index space; and as a depth behind a face of the clip, in world units.
    glm::dvec4 latticePoint(double x, double y, double n) const {
        const double w = (1 - m_one.z * n) / (m_one.x * x + m_one.y * y + m_one.w);
        return {x * w, y * w, n, w};
    }
    Vec3 indexPoint(double x, double y, double n) const { return Vec3(m_isFromRs * latticePoint(x, y, n)); }
    double depthIn(std::size_t face, double x, double y, double n) const {
        return glm::dot(m_faces[face], latticePoint(x, y, n));
    }
    void cut(int p, const SampleTile& at, Real* front, Real* middle, Real* back, Real* share) const;
    template <class Read>
    void sampleRun(int p, ClassifiedTile& out, const Read& read) const;
    void sampleAlong(int p, const SampleTile& at, ClassifiedTile& out) const;
    template <class Rays>
    bool meanOfRun(int p, const std::uint8_t* open, const Rays& rays, ClassifiedTile& out) const;
    const FieldBrick* voxelsIn(const Bounds& is) const;
    template <class Shows>
    void sharpen(int p, const SampleTile& at, const std::uint8_t* open, ClassifiedTile& out, const Shows& shows) const;
    bool clearBetween(Real a, Real b) const;
    template <class Exact>
    std::pair<Real, Real> withEdge(const Vec3& from, const Vec3& to, Real a, Real b, const Exact& exact) const;
    bool isRim(Real least, Real most) const;
    bool showsAround(const std::array<FloatPlane, 3>& planes, int tx, int ty) const;
    std::pair<Real, Real> rangeAlong(const ClassifiedTile& run) const;
    bool anyShows(const ClassifiedTile& run, Real margin) const;
    void findSlopes(int p, Some& some) const;
    void weigh(int p, const SampleTile& at, const Real* share, Real* extinction) const;
    void findNormals(int p, const SampleTile& at, ClassifiedTile& out) const;

    const Sheets& m_sheets;
    Simd m_simd;
    std::shared_ptr<const Classified> m_look;
    TransferTable m_table;
    double m_vagueGradient;
    double m_voxel;
    std::vector<HalfSpace> m_clip;
    std::vector<glm::dvec4> m_faces;  // of the clip: rows whose product with (x W, y W, N, W) is the depth
    glm::dvec4 m_one;                 // the row whose product with (x W, y W, N, W) is 1
    glm::dmat4 m_isFromRs;            // maps (x W, y W, N, W) to index space
    FieldSampler m_exact;             // the volume's own field
    Real m_most;                      // its values are limited to this
    Real m_edge;                      // the least value that shows
    Real m_rim;                       // see isRim: in multiples of the range of values that a ray meets in a sheet
    Mat3 m_ssFromDifference;  // converts differences over two voxels to the gradient in sweep space, per world unit
    FieldPlanes m_field;
    PlaneStack m_extinction;
    int m_firstSheet = 0;
};

}  // namespace scrim
