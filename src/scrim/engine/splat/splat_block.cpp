// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/splat_block.h>

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/splat/splat_block.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// Voxels whose addresses are computed together, ahead of their footprints.
constexpr int kChunk = 32;

constexpr std::int32_t kNoSheet = 1 << 29;  // of voxels that are left out: past every last sheet

struct Chunk {
    alignas(64) RealIndex table[kChunk];  // index of the quantised fraction
    alignas(64) RealIndex texel[kChunk];  // offset of the footprint's first texel in its plane
    alignas(64) RealIndex sheet[kChunk];  // first sheet of the footprint
    alignas(64) Real restU[kChunk];       // what rounding left, in steps
    alignas(64) Real restV[kChunk];
    alignas(64) Real restN[kChunk];
};

HWY_INLINE int log2Of(int powerOfTwo) {
    int log2 = 0;
    while ((1 << log2) < powerOfTwo) ++log2;
    return log2;
}

// Addresses of voxels [k, k + kChunk) of the order (reading past its end is harmless: see the caller).
template <bool kClipped>
HWY_ATTR void locate(const BlockSplat& splat, const BlockSplat::Place& place, int k, Chunk& chunk) {
    const hn::ScalableTag<Real> df;
    const hn::RebindToSigned<decltype(df)> di;
    const FootprintTable& table = *splat.table;
    const int log2Texel = log2Of(table.texelSteps()), log2Sheet = log2Of(table.sheetSteps());
    const auto texelMask = hn::Set(di, table.texelSteps() - 1), sheetMask = hn::Set(di, table.sheetSteps() - 1);

    for (int i = 0; i < kChunk; i += static_cast<int>(hn::Lanes(df))) {
        // Positions in quantisation steps, rounded to the nearest.
        const auto at = [&](Real fraction, const auto& offsets, int steps, Real* rest) {
            const auto offset = hn::LoadU(df, offsets.data() + k + i);
            const auto position = hn::Add(hn::Set(df, fraction), offset);
            const auto inSteps = hn::MulAdd(position, hn::Set(df, static_cast<Real>(steps)), hn::Set(df, Real(0.5)));
            const auto rounded = hn::Floor(inSteps);
            hn::StoreU(hn::Sub(hn::Sub(inSteps, rounded), hn::Set(df, Real(0.5))), df, rest + i);
            return hn::ConvertTo(di, rounded);
        };
        const auto u = at(place.fractionU, splat.order->offsetU, table.texelSteps(), chunk.restU);
        const auto v = at(place.fractionV, splat.order->offsetV, table.texelSteps(), chunk.restV);
        const auto n = at(place.fractionN, splat.order->offsetN, table.sheetSteps(), chunk.restN);

        const auto whole = [&](auto position, int log2Steps, int first) {
            return hn::Add(hn::ShiftRightSame(position, log2Steps), hn::Set(di, first));
        };
        const auto column = whole(u, log2Texel, place.wholeU + table.firstColumn());
        const auto row = whole(v, log2Texel, place.wholeV + table.firstRow());
        hn::StoreU(hn::Add(hn::Mul(row, hn::Set(di, splat.rowStride)), column), di, chunk.texel + i);
        auto sheet = whole(n, log2Sheet, place.wholeN + table.firstSheet());
        if constexpr (kClipped) {
            const auto outside = hn::Or(hn::Or(hn::Lt(column, hn::Zero(di)), hn::Lt(row, hn::Zero(di))),
                                        hn::Or(hn::Gt(column, hn::Set(di, splat.width - table.rowStride())),
                                               hn::Gt(row, hn::Set(di, splat.height - table.rows()))));
            sheet = hn::IfThenElse(outside, hn::Set(di, kNoSheet), sheet);
        }
        hn::StoreU(sheet, di, chunk.sheet + i);

        auto entry = hn::ShiftLeftSame(hn::And(v, texelMask), log2Texel);
        entry = hn::ShiftLeftSame(hn::Or(entry, hn::And(u, texelMask)), log2Sheet);
        hn::StoreU(hn::Or(entry, hn::And(n, sheetMask)), di, chunk.table + i);
    }
}

// Weights that go with their slopes, in parts `part` apart, at `rest` steps from where they were tabulated.
template <class D>
struct Slopes {
    hn::Vec<D> u, v, n;

    HWY_ATTR HWY_INLINE Slopes(D d, const Real (&rest)[3])
        : u(hn::Set(d, rest[0])), v(hn::Set(d, rest[1])), n(hn::Set(d, rest[2])) {}
    HWY_ATTR HWY_INLINE hn::Vec<D> weights(D d, const Real* from, int part) const {
        const auto sum = hn::MulAdd(u, hn::LoadU(d, from + part), hn::LoadU(d, from));
        return hn::MulAdd(n, hn::LoadU(d, from + 3 * part), hn::MulAdd(v, hn::LoadU(d, from + 2 * part), sum));
    }
};

// One footprint, into the same texels of one field or of several: value[f] * weights on `rows` rows of `width` texels, a
// multiple of 4, from texels[f] on.
struct Footprint {
    const Real* weights;
    int part;       // floats from part to part of the table
    Real rest[3];   // steps from where the weights were tabulated
    int rows, width;
    std::ptrdiff_t rowStride;
};

template <class D, int kFields>
HWY_ATTR HWY_INLINE void addTo(D d, hn::Vec<D> weights, const Real* value, Real* const* texels, std::ptrdiff_t at,
                               int fields) {
    for (int f = 0; f < (kFields > 0 ? kFields : fields); ++f) {
        Real* to = texels[f] + at;
        hn::StoreU(hn::MulAdd(hn::Set(d, value[f]), weights, hn::LoadU(d, to)), d, to);
    }
}

// Rows of four are taken in pairs: in the table they lie side by side.
template <int kWidth, int kFields>
HWY_ATTR HWY_INLINE void addFootprint(const Footprint& print, const Real* value, Real* const* texels, int fields) {
    const hn::CappedTag<Real, 4> d;
    const Real* HWY_RESTRICT weights = print.weights;
    std::ptrdiff_t at = 0;
    int row = 0;
#if HWY_TARGET != HWY_SCALAR
    if constexpr (kWidth == 4) {
        const hn::CappedTag<Real, 8> d8;
        if (hn::Lanes(d8) == 8) {
            const Slopes<decltype(d8)> slopes(d8, print.rest);
            const hn::Half<decltype(d8)> half;
            for (; row + 1 < print.rows; row += 2, weights += 8, at += 2 * print.rowStride) {
                const auto both = slopes.weights(d8, weights, print.part);
                addTo<decltype(half), kFields>(half, hn::LowerHalf(half, both), value, texels, at, fields);
                addTo<decltype(half), kFields>(half, hn::UpperHalf(half, both), value, texels, at + print.rowStride,
                                               fields);
            }
        }
    }
#endif
    const Slopes<decltype(d)> slopes(d, print.rest);
    for (; row < print.rows; ++row, weights += print.width, at += print.rowStride)
        for (int i = 0; i < print.width; i += static_cast<int>(hn::Lanes(d)))
            addTo<decltype(d), kFields>(d, slopes.weights(d, weights + i, print.part), value, texels, at + i, fields);
}

template <int kWidth, bool kClipped, int kFields>
HWY_ATTR std::uint64_t splatRange(const BlockSplat& splat, const BlockSplat::Place& place, const float* const* values,
                                  int first, int second) {
    // Copies, because the compiler must assume that writing texels changes what pointers lead to.
    const FootprintTable& table = *splat.table;
    const int sheets = table.sheets(), fields = kFields > 0 ? kFields : splat.fields;
    const std::ptrdiff_t sheetStride = table.sheetStride(), entryStride = sheetStride * sheets;
    const std::ptrdiff_t planeStride = splat.planeStride;
    const int firstSheet = splat.firstSheet, lastSheet = splat.lastSheet;
    const Real scale = splat.scale, most = splat.most;
    const Real* const allWeights = table.weights();
    const std::int32_t* const index = splat.order->index.data();
    const std::array<Real*, BlockSplat::kMost> planes = splat.planes;
    Footprint print{nullptr, table.partStride(), {}, table.rows(), table.rowStride(), splat.rowStride};
    std::uint64_t footprints = 0;
    Chunk chunk;

    for (int k0 = first; k0 < second; k0 += kChunk) {
        // The last chunk starts early enough to stay within the 512 voxels; its head was done before.
        const int k = std::min(k0, kBlockVoxels - kChunk);
        locate<kClipped>(splat, place, k, chunk);
        const int end = std::min(kChunk, second - k);
        for (int i = k0 - k; i < end; ++i) {
            Real value[BlockSplat::kMost], any = 0;
            for (int f = 0; f < fields; ++f) {
                value[f] = std::min(values[f][index[k + i]] * scale, most);
                any = std::max(any, value[f]);
            }
            if (any == 0) continue;
            const int sheet = chunk.sheet[i];
            if (kClipped && sheet == kNoSheet) continue;
            const int from = std::max(0, firstSheet - sheet);
            const int to = std::min(sheets, lastSheet - sheet);
            print.weights = allWeights + chunk.table[i] * entryStride + from * sheetStride;
            print.rest[0] = chunk.restU[i];
            print.rest[1] = chunk.restV[i];
            print.rest[2] = chunk.restN[i];
            std::ptrdiff_t at = (sheet + from - firstSheet) * planeStride + chunk.texel[i];
            for (int s = from; s < to; ++s, print.weights += sheetStride, at += planeStride) {
                Real* texels[BlockSplat::kMost];
                for (int f = 0; f < fields; ++f) texels[f] = planes[f] + at;
                addFootprint<kWidth, kFields>(print, value, texels, fields);
            }
            footprints += static_cast<std::uint64_t>(std::max(0, to - from));
        }
    }
    return footprints;
}

// Kept apart: one field, which is the usual case, and several.
template <int kFields>
HWY_ATTR std::uint64_t splatFields(const BlockSplat& splat, const BlockSplat::Place& place, const float* const* values,
                                   int first, int second) {
    if (splat.clipped) return splatRange<0, true, kFields>(splat, place, values, first, second);
    return splat.table->rowStride() == 4 ? splatRange<4, false, kFields>(splat, place, values, first, second)
                                         : splatRange<0, false, kFields>(splat, place, values, first, second);
}

HWY_ATTR std::uint64_t splatBlockOnTarget(const BlockSplat& splat, const BlockSplat::Place& place,
                                          const float* const* values, int first, int second) {
    return splat.fields == 1 ? splatFields<1>(splat, place, values, first, second)
                             : splatFields<0>(splat, place, values, first, second);
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(splatBlockOnTarget);

std::uint64_t splatBlock(const BlockSplat& splat, const BlockSplat::Place& place, const float* const* values, int first,
                         int second) {
    return SCRIM_ON_TARGET(splat.simd, splatBlockOnTarget)(splat, place, values, first, second);
}

}  // namespace scrim
#endif
