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
    alignas(64) std::int32_t table[kChunk];  // index of the quantised fraction
    alignas(64) std::int32_t texel[kChunk];  // offset of the footprint's first texel in its plane
    alignas(64) std::int32_t sheet[kChunk];  // first sheet of the footprint
    alignas(64) float restU[kChunk];         // what rounding left, in steps
    alignas(64) float restV[kChunk];
    alignas(64) float restN[kChunk];
};

HWY_INLINE int log2Of(int powerOfTwo) {
    int log2 = 0;
    while ((1 << log2) < powerOfTwo) ++log2;
    return log2;
}

// Addresses of voxels [k, k + kChunk) of the order (reading past its end is harmless: see the caller).
template <bool kClipped>
HWY_ATTR void locate(const BlockSplat& splat, const BlockPlace& place, int k, Chunk& chunk) {
    const hn::ScalableTag<float> df;
    const hn::RebindToSigned<decltype(df)> di;
    const FootprintTable& table = *splat.table;
    const int log2Texel = log2Of(table.texelSteps()), log2Sheet = log2Of(table.sheetSteps());
    const auto texelMask = hn::Set(di, table.texelSteps() - 1), sheetMask = hn::Set(di, table.sheetSteps() - 1);

    for (int i = 0; i < kChunk; i += static_cast<int>(hn::Lanes(df))) {
        // Positions in quantisation steps, rounded to the nearest.
        const auto at = [&](float fraction, const auto& offsets, int steps, float* rest) {
            const auto offset = hn::LoadU(df, offsets.data() + k + i);
            const auto position = hn::Add(hn::Set(df, fraction), offset);
            const auto inSteps = hn::MulAdd(position, hn::Set(df, static_cast<float>(steps)), hn::Set(df, 0.5f));
            const auto rounded = hn::Floor(inSteps);
            hn::StoreU(hn::Sub(hn::Sub(inSteps, rounded), hn::Set(df, 0.5f)), df, rest + i);
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

    HWY_ATTR HWY_INLINE Slopes(D d, const float (&rest)[3])
        : u(hn::Set(d, rest[0])), v(hn::Set(d, rest[1])), n(hn::Set(d, rest[2])) {}
    HWY_ATTR HWY_INLINE hn::Vec<D> weights(D d, const float* from, int part) const {
        const auto sum = hn::MulAdd(u, hn::LoadU(d, from + part), hn::LoadU(d, from));
        return hn::MulAdd(n, hn::LoadU(d, from + 3 * part), hn::MulAdd(v, hn::LoadU(d, from + 2 * part), sum));
    }
};

// Adds value * weights to `rows` rows of `width` texels, a multiple of 4. Rows of four are taken in pairs: in the table
// they lie side by side.
template <int kWidth>
HWY_ATTR HWY_INLINE void addFootprint(const float* HWY_RESTRICT weights, int part, float value, const float (&rest)[3],
                                   int rows, int width, float* HWY_RESTRICT texels, std::ptrdiff_t rowStride) {
    const hn::CappedTag<float, 4> d;
    const auto scale = hn::Set(d, value);
    int row = 0;
#if HWY_TARGET != HWY_SCALAR
    if constexpr (kWidth == 4) {
        const hn::CappedTag<float, 8> d8;
        if (hn::Lanes(d8) == 8) {
            const Slopes<decltype(d8)> slopes(d8, rest);
            const hn::Half<decltype(d8)> half;
            for (; row + 1 < rows; row += 2, weights += 8, texels += 2 * rowStride) {
                const auto both = slopes.weights(d8, weights, part);
                float* next = texels + rowStride;
                const auto s = hn::Set(half, value);
                hn::StoreU(hn::MulAdd(s, hn::LowerHalf(half, both), hn::LoadU(half, texels)), half, texels);
                hn::StoreU(hn::MulAdd(s, hn::UpperHalf(half, both), hn::LoadU(half, next)), half, next);
            }
        }
    }
#endif
    const Slopes<decltype(d)> slopes(d, rest);
    for (; row < rows; ++row, weights += width, texels += rowStride)
        for (int i = 0; i < width; i += 4)
            hn::StoreU(hn::MulAdd(scale, slopes.weights(d, weights + i, part), hn::LoadU(d, texels + i)), d,
                       texels + i);
}

template <int kWidth, bool kClipped>
HWY_ATTR std::uint64_t splatRange(const BlockSplat& splat, const BlockPlace& place, const float* values, int first,
                                  int second) {
    // Copies, because the compiler must assume that writing texels changes what pointers lead to.
    const FootprintTable& table = *splat.table;
    const int rows = table.rows(), width = table.rowStride(), sheets = table.sheets();
    const int part = table.partStride();
    const std::ptrdiff_t sheetStride = table.sheetStride();
    const std::ptrdiff_t entryStride = sheetStride * sheets;
    const std::ptrdiff_t planeStride = splat.planeStride, rowStride = splat.rowStride;
    const int firstSheet = splat.firstSheet, lastSheet = splat.lastSheet;
    const float scale = splat.scale, most = splat.most;
    const float* const allWeights = table.weights();
    const std::int32_t* const index = splat.order->index.data();
    float* const planes = splat.planes;
    std::uint64_t footprints = 0;
    Chunk chunk;

    for (int k0 = first; k0 < second; k0 += kChunk) {
        // The last chunk starts early enough to stay within the 512 voxels; its head was done before.
        const int k = std::min(k0, kBlockVoxels - kChunk);
        locate<kClipped>(splat, place, k, chunk);
        const int end = std::min(kChunk, second - k);
        for (int i = k0 - k; i < end; ++i) {
            const float value = std::min(values[index[k + i]] * scale, most);
            if (value == 0) continue;
            const int sheet = chunk.sheet[i];
            if (kClipped && sheet == kNoSheet) continue;
            const int from = std::max(0, firstSheet - sheet);
            const int to = std::min(sheets, lastSheet - sheet);
            const float* weights = allWeights + chunk.table[i] * entryStride + from * sheetStride;
            float* texels = planes + (sheet + from - firstSheet) * planeStride + chunk.texel[i];
            for (int s = from; s < to; ++s, weights += sheetStride, texels += planeStride)
                addFootprint<kWidth>(weights, part, value, {chunk.restU[i], chunk.restV[i], chunk.restN[i]}, rows, width,
                                     texels, rowStride);
            footprints += static_cast<std::uint64_t>(std::max(0, to - from));
        }
    }
    return footprints;
}

HWY_ATTR std::uint64_t splatBlockOnTarget(const BlockSplat& splat, const BlockPlace& place, const float* values,
                                          int first, int second) {
    if (splat.clipped) return splatRange<0, true>(splat, place, values, first, second);
    return splat.table->rowStride() == 4 ? splatRange<4, false>(splat, place, values, first, second)
                                         : splatRange<0, false>(splat, place, values, first, second);
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(splatBlockOnTarget);

std::uint64_t splatBlock(const BlockSplat& splat, const BlockPlace& place, const float* values, int first, int second) {
    return SCRIM_ON_TARGET(splat.simd, splatBlockOnTarget)(splat, place, values, first, second);
}

}  // namespace scrim
#endif
