// SPDX-License-Identifier: Apache-2.0
// Footprints: what one voxel's kernel adds to the texels of the sheets that it reaches (ZC02 section 2).
//
// A footprint depends only on the voxel's fractional position relative to texels and sheets, so it is tabulated over
// quantised fractions. Each weight is the mean of the kernel over the sheet's thickness, along w through the texel's
// centre. It is integrated numerically once, so that every kernel, rotation, shear and anisotropic voxel is equally
// cheap. Because one cumulative integral along w serves all sheets, the weights of a texel sum over the sheets to the
// kernel's line integral for every thickness.
//
// Rounding a position to its step moves the voxel. That is an error of first order in the step,
// which flickers when a camera or a light moves, and which shows in gradients. A table may
// therefore also hold the slopes of its weights; the remaining error is of second order.
#pragma once

#include <scrim/base/real.h>
#include <scrim/geometry/spaces.h>
#include <scrim/volume/kernel.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scrim {

class FootprintTable {
  public:
    /// How finely positions are resolved: powers of two in [2, 128].
    struct Steps {
        int texel;            ///< per texel along U and V
        int sheet;            ///< per sheet along N
        bool sloped = false;  ///< the weights at the nearest step are corrected by their slopes there
    };
    /// `tsFromIs`: the grid's map to texel space, of which only the linear part counts.
    FootprintTable(Kernel kernel, const Mat4& tsFromIs, const Steps& steps);

    int texelSteps() const { return m_steps.texel; }
    int sheetSteps() const { return m_steps.sheet; }

    // A position is rounded to the nearest step, so that lattices which coincide with the steps are exact. For a voxel
    // at the rounded position (U, V, N), the footprint covers columns floor(U) + firstColumn() + [0, columns()), rows
    // likewise, and sheets floor(N) + firstSheet() + [0, sheets()).
    int firstColumn() const { return m_first.x; }
    int firstRow() const { return m_first.y; }
    int firstSheet() const { return m_first.z; }
    int columns() const { return m_count.x; }
    int rows() const { return m_count.y; }  ///< at least 2
    int sheets() const { return m_count.z; }
    /// columns() rounded up to a multiple of 4; weights beyond columns() are 0.
    int rowStride() const { return m_rowStride; }
    int partStride() const { return m_rowStride * rows(); }
    /// Floats per sheet. A sheet has one part, its weights, or four: weights, and their changes
    /// over one step in U, V and N.
    int sheetStride() const { return partStride() * (m_steps.sloped ? 4 : 1); }
    const Vec3& extent() const { return m_extent; }  ///< half the kernel's extent, in texels and sheets

    /// Offset of the weights for quantised fractions, each below its number of steps. There are
    /// sheets() x parts x rows() x rowStride() weights.
    std::size_t offset(int stepU, int stepV, int stepN) const {
        return std::size_t((stepV * m_steps.texel + stepU) * m_steps.sheet + stepN) *
               std::size_t(sheetStride() * sheets());
    }
    const Real* weights() const { return m_weights.data(); }
    /// Keeps only the geometry, for users that have the pieces.
    void dropWeights() { m_weights = {}; }
    std::size_t bytes() const { return m_weights.size() * sizeof(Real); }

    /// Bytes of a table, without building it.
    static std::size_t bytes(Kernel kernel, const Mat4& tsFromIs, const Steps& steps);

  private:
    struct Shape;
    static Shape shapeOf(Kernel kernel, const Mat4& tsFromIs, const Steps& steps);
    void fill(Kernel kernel, const Mat3& isFromTs, int stepV);
    void addSlopes(int stepV);

    Steps m_steps;
    int m_rowStride = 0;
    Vec3 m_extent{0};
    Int3 m_first{0}, m_count{0};  // columns, rows, sheets
    std::vector<Real> m_weights;
};

/// The footprints of a sloped table, divided into pieces of two rows of four texels on one sheet. Empty pieces are left
/// out: the table's entries are as large as its largest footprint, and about half of a footprint is empty.
class FootprintPieces {
  public:
    static constexpr int kRows = 2, kColumns = 4;
    /// Eight weights, row by row, and their changes over one step in U, V and N.
    static constexpr int kFloats = 4 * kRows * kColumns;

    explicit FootprintPieces(const FootprintTable& table);

    /// Offsets of the kinds of pieces from a footprint's first texel, in planes with these strides.
    std::vector<std::ptrdiff_t> offsets(std::ptrdiff_t planeStride, std::ptrdiff_t rowStride) const;

    /// The pieces of entry e are those from begins(e)[0] to begins(e)[sheets()] - 1; those of its
    /// sheet s begin at begins(e)[s].
    const std::uint32_t* begins(std::size_t entry) const { return m_begins.data() + entry * m_beginStride; }
    const std::uint32_t* kinds() const { return m_kinds.data(); }
    const Real* weights() const { return m_pieces.front().values.data(); }
    std::size_t bytes() const;

  private:
    struct alignas(64) Piece {
        std::array<Real, kFloats> values;
    };
    std::size_t m_beginStride;
    std::vector<Int3> m_places;  // of each kind: column, row and sheet of its first weight
    std::vector<std::uint32_t> m_begins;
    std::vector<std::uint32_t> m_kinds;
    std::vector<Piece> m_pieces;
};

/// How finely positions are quantised: powers of two, with at least 3/4 of `stepsPerVoxel` for a voxel of the size that
/// `tsFromIs` gives it, and at least four a texel but for voxels of 8 texels and more.
FootprintTable::Steps footprintSteps(const Mat4& tsFromIs, int stepsPerVoxel);

/// The same for a table with slopes. Where the grid lies along texels and the eye or light looks
/// along one of its axes, footprints of the linear kernel have kinks in rows and columns, and there
/// are at least 32 steps a voxel as far as the table stays small.
FootprintTable::Steps slopedSteps(Kernel kernel, const Mat4& tsFromIs, int stepsPerVoxel);

}  // namespace scrim
