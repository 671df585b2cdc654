// SPDX-License-Identifier: Apache-2.0
// Internal: fields as cells get them, and the voxels of a block whose axes are those of the world, all at once: the
// part that a voxel gives to a cell is then a product of one factor for each axis, so that a block is three products of
// small matrices, one axis after the other, instead of a loop over the cells of each voxel.
#ifndef SCRIM_CELL_MEDIA_PARTS
#define SCRIM_CELL_MEDIA_PARTS

#include <scrim/base/real.h>
#include <scrim/base/split_mix.h>
#include <scrim/engine/cells/cell_grid.h>
#include <scrim/scene/view_scene.h>
#include <scrim/volume/sparse_field.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scrim {

/// A field that is deposited into cells, and the factors on a voxel's value for each destination row.
struct Deposit {
    const SparseField* field;
    Mat4 wsFromIs;
    const ViewVolume* classified = nullptr;  ///< if set, its extinction is deposited instead of the field's value
    struct Share {
        std::vector<Real>* row;
        double factor;
        int colour = -1;  ///< of the transfer function, which multiplies the extinction; -1: none does
    };
    std::vector<Share> shares;
    bool tents = false;    ///< voxels are tents, as they are interpolated, and not cubes
    bool eighths = false;  ///< cells have so few voxels that each part of a voxel counts

    /// The transfer function is taken of the interpolated field, since where it bends its mean is not that of voxels:
    /// as a sum over voxels, light that has scattered was 3 % too dark in a brain.
    bool between() const { return classified && classified->classified->scatters; }
};

/// Half the edges of the box along the world's axes around a voxel.
inline Vec3 halfVoxel(const Mat4& wsFromIs) {
    Vec3 half(0);
    for (int axis = 0; axis < 3; ++axis) half += 0.5 * glm::abs(Vec3(wsFromIs[axis]));
    return half;
}

/// Calls visit(centre, half, volume in voxels) for a voxel; if the deposit is taken between voxels, for its eight
/// parts, or for one place of theirs that is drawn by lot and stands for all. `half`: as halfVoxel has it.
template <class Visit>
void forParts(const Deposit& deposit, const Int3& voxel, const Vec3& half, const Visit& visit) {
    const auto center = [&](int part) {
        const Vec3 within = 0.5 * Vec3(part & 1, part >> 1 & 1, part >> 2 & 1) - 0.25;
        return transformPoint(deposit.wsFromIs, Vec3(voxel) + within);
    };
    if (!deposit.between()) return visit(transformPoint(deposit.wsFromIs, Vec3(voxel)), half, 1.0);
    const auto lot = splitMix((std::uint64_t(std::uint32_t(voxel.x)) << 42) ^
                              (std::uint64_t(std::uint32_t(voxel.y)) << 21) ^ std::uint64_t(std::uint32_t(voxel.z)));
    if (!deposit.eighths) return visit(center(static_cast<int>(lot >> 61)), half, 1.0);
    for (int part = 0; part < 8; ++part) visit(center(part), 0.5 * half, 0.125);
}

/// The cells that an interval meets, and the fraction of it in each of them; of a tent, twice as
/// wide, its values in the middle of cells.
struct CellParts {
    int first, count;
    double center, half;
    bool tent;

    CellParts(double middle, double halfEdge, bool isTent) : center(middle), half(halfEdge), tent(isTent) {
        const double reach = tent ? 2 * half : half;
        first = static_cast<int>(std::floor(center - reach));
        count = static_cast<int>(std::floor(center + reach)) - first + 1;
    }
    double part(int i) const {
        const double begin = first + i - center;
        if (tent) return std::max(0.0, 1 - 0.5 * std::abs(begin + 0.5) / half) / (2 * half);
        return std::max(0.0, std::min(half, begin + 1) - std::max(-half, begin)) / (2 * half);
    }
};

/// The parts of the voxels along one edge of a block.
struct EdgeParts {
    int first = 0, count = 0;                ///< cells
    std::size_t stride = 0;                  ///< of `parts`: `count` and what fills the last vector
    int begin[kBlockEdge], end[kBlockEdge];  ///< the cells of each voxel, from `first` on
    std::vector<Real> parts;                 ///< [voxel][cell]

    /// `middle`: the centre of the first voxel, in cells; `step`: from a voxel to the next one.
    EdgeParts(double middle, double step, double half, bool tent) {
        const CellParts one(middle, half, tent), other(middle + (kBlockEdge - 1) * step, half, tent);
        first = std::min(one.first, other.first);
        count = std::max(one.first + one.count, other.first + other.count) - first;
        stride = std::size_t(count + kBlockEdge - 1) / kBlockEdge * kBlockEdge;
        parts.assign(kBlockEdge * stride, Real(0));
        for (int v = 0; v < kBlockEdge; ++v) {
            const CellParts of(middle + v * step, half, tent);
            begin[v] = of.first - first;
            end[v] = begin[v] + of.count;
            for (int i = 0; i < of.count; ++i)
                parts[std::size_t(v) * stride + std::size_t(begin[v] + i)] = static_cast<Real>(of.part(i));
        }
    }
};

/// Calls visit(cell, sum) for those stored cells whose sum, as spreadBlock makes them, is not 0.
template <class Visit>
void forCells(const CellGrid& grid, const std::array<EdgeParts, 3>& parts, const std::vector<Real>& sums,
              const Visit& visit) {
    const Int3 corner(parts[0].first, parts[1].first, parts[2].first);
    for (int x = 0; x < parts[0].count; ++x)
        for (int y = 0; y < parts[1].count; ++y) {
            const Real* row = sums.data() + std::size_t(x * parts[1].count + y) * parts[2].stride;
            std::ptrdiff_t cell = -1;
            for (int z = 0; z < parts[2].count; ++z, cell += cell < 0 ? 0 : kCellEdge * kCellEdge) {
                if (z == 0 || (corner.z + z) % kCellEdge == 0) cell = grid.index(corner + Int3(x, y, z));
                if (cell >= 0 && row[z] != 0) visit(std::size_t(cell), row[z]);
            }
        }
}

}  // namespace scrim
#endif

#if defined(SCRIM_CELL_MEDIA_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SCRIM_CELL_MEDIA_INL_H_
#undef SCRIM_CELL_MEDIA_INL_H_
#else
#define SCRIM_CELL_MEDIA_INL_H_
#endif

#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// to += factor * from, for `count` values in whole vectors.
HWY_ATTR HWY_INLINE void addScaled(Real factor, const Real* from, std::size_t count, Real* to) {
    const hn::CappedTag<Real, kBlockEdge> d;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d))
        hn::StoreU(hn::MulAdd(hn::Set(d, factor), hn::LoadU(d, from + i), hn::LoadU(d, to + i)), d, to + i);
}

// The sums over a block's voxels for each cell that they meet: [x][y][z], with parts[2].stride places along z.
HWY_ATTR void spreadBlock(const float* values, const std::array<EdgeParts, 3>& parts, std::vector<Real>& cells) {
    constexpr std::size_t kEdge = kBlockEdge, kSlice = kEdge * kEdge;
    alignas(64) Real voxels[kBlockVoxels];
    for (int i = 0; i < kBlockVoxels; ++i) voxels[i] = std::max(static_cast<Real>(values[i]), Real(0));
    const auto& [x, y, z] = parts;
    const std::size_t row = z.stride, slice = std::size_t(y.count) * row;
    std::vector<Real> alongX(std::size_t(x.count) * kSlice, Real(0));
    for (std::size_t v = 0; v < kEdge; ++v)
        for (int i = x.begin[v]; i < x.end[v]; ++i)
            addScaled(x.parts[v * x.stride + std::size_t(i)], voxels + v * kSlice, kSlice,
                      alongX.data() + std::size_t(i) * kSlice);
    cells.assign(std::size_t(x.count) * slice, Real(0));
    std::vector<Real> alongY(std::size_t(y.count) * kEdge);
    for (std::size_t i = 0; i < std::size_t(x.count); ++i) {
        std::fill(alongY.begin(), alongY.end(), Real(0));
        for (std::size_t v = 0; v < kEdge; ++v)
            for (int j = y.begin[v]; j < y.end[v]; ++j)
                addScaled(y.parts[v * y.stride + std::size_t(j)], alongX.data() + i * kSlice + v * kEdge, kEdge,
                          alongY.data() + std::size_t(j) * kEdge);
        for (std::size_t j = 0; j < std::size_t(y.count); ++j)
            for (std::size_t v = 0; v < kEdge; ++v)
                if (const Real value = alongY[j * kEdge + v]; value != 0)
                    addScaled(value, z.parts.data() + v * row, row, cells.data() + i * slice + j * row);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
