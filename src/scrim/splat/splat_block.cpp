// SPDX-License-Identifier: Apache-2.0
#include <scrim/splat/splat_block.h>

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/splat/splat_block.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Voxels whose addresses are computed together, ahead of their footprints.
constexpr int kChunk = 32;

struct Chunk {
    alignas(64) std::int32_t table[kChunk];  // index of the quantised fraction
    alignas(64) std::int32_t texel[kChunk];  // offset of the footprint's first texel in its plane
    alignas(64) std::int32_t sheet[kChunk];  // first sheet of the footprint
};

// Addresses of voxels [k, k + kChunk) of the order (reading past its end is harmless: see the caller).
HWY_ATTR void locate(const BlockSplat& splat, const BlockPlace& place, int k, Chunk& chunk) {
    const hn::ScalableTag<float> df;
    const hn::RebindToSigned<decltype(df)> di;
    const FootprintTable& table = *splat.table;
    const int log2Steps = table.log2Steps();
    const auto steps = hn::Set(df, static_cast<float>(table.steps()));
    const auto mask = hn::Set(di, table.steps() - 1);

    for (int i = 0; i < kChunk; i += static_cast<int>(hn::Lanes(df))) {
        // Positions in whole quantisation steps.
        const auto at = [&](float fraction, const auto& offsets) {
            const auto offset = hn::LoadU(df, offsets.data() + k + i);
            return hn::ConvertTo(di, hn::Floor(hn::Mul(hn::Add(hn::Set(df, fraction), offset), steps)));
        };
        const auto u = at(place.fractionU, splat.order->offsetU);
        const auto v = at(place.fractionV, splat.order->offsetV);
        const auto n = at(place.fractionN, splat.order->offsetN);

        const auto whole = [&](auto position, int first) {
            return hn::Add(hn::ShiftRightSame(position, log2Steps), hn::Set(di, first));
        };
        const auto column = whole(u, place.wholeU + table.firstColumn());
        const auto row = whole(v, place.wholeV + table.firstRow());
        hn::StoreU(hn::Add(hn::Mul(row, hn::Set(di, splat.rowStride)), column), di, chunk.texel + i);
        hn::StoreU(whole(n, place.wholeN + table.firstSheet()), di, chunk.sheet + i);

        auto entry = hn::ShiftLeftSame(hn::And(v, mask), log2Steps);
        entry = hn::ShiftLeftSame(hn::Or(entry, hn::And(u, mask)), log2Steps);
        hn::StoreU(hn::Or(entry, hn::And(n, mask)), di, chunk.table + i);
    }
}

// Adds value * weights to `rows` rows of kVectors * 4 texels. kVectors = 0: any width.
template <int kVectors>
HWY_ATTR HWY_INLINE void addFootprint(const float* HWY_RESTRICT weights, float value, int rows, int rowFloats,
                                      float* HWY_RESTRICT texels, std::ptrdiff_t rowStride) {
    const hn::CappedTag<float, kVectors == 1 ? 4 : 8> d;
    const int step = static_cast<int>(hn::Lanes(d));
    const int width = kVectors > 0 ? kVectors * 4 : rowFloats;
    const auto scale = hn::Set(d, value);
    for (int row = 0; row < rows; ++row, weights += width, texels += rowStride)
        for (int i = 0; i < width; i += step)
            hn::StoreU(hn::MulAdd(scale, hn::LoadU(d, weights + i), hn::LoadU(d, texels + i)), d, texels + i);
}

template <int kVectors>
HWY_ATTR std::uint64_t splatRange(const BlockSplat& splat, const BlockPlace& place, const float* values,
                                  int first, int second) {
    const FootprintTable& table = *splat.table;
    const int rows = table.rows(), rowFloats = table.rowStride(), sheets = table.sheets();
    const std::ptrdiff_t sheetStride = table.sheetStride();
    const std::ptrdiff_t entryStride = sheetStride * sheets;
    std::uint64_t footprints = 0;
    Chunk chunk;

    for (int k0 = first; k0 < second; k0 += kChunk) {
        // The last chunk starts early enough to stay within the 512 voxels; its head was done before.
        const int k = std::min(k0, kBlockVoxels - kChunk);
        locate(splat, place, k, chunk);
        const int end = std::min(kChunk, second - k);
        for (int i = k0 - k; i < end; ++i) {
            const float value = values[splat.order->index[static_cast<std::size_t>(k + i)]] * splat.scale;
            if (value == 0) continue;
            const int sheet = chunk.sheet[i];
            const int from = std::max(0, splat.firstSheet - sheet);
            const int to = std::min(sheets, splat.lastSheet - sheet);
            const float* weights = table.weights() + chunk.table[i] * entryStride + from * sheetStride;
            float* texels = splat.planes + (sheet + from - splat.firstSheet) * splat.planeStride + chunk.texel[i];
            for (int s = from; s < to; ++s, weights += sheetStride, texels += splat.planeStride)
                addFootprint<kVectors>(weights, value, rows, rowFloats, texels, splat.rowStride);
            footprints += static_cast<std::uint64_t>(std::max(0, to - from));
        }
    }
    return footprints;
}

HWY_ATTR std::uint64_t splatBlockOnTarget(const BlockSplat& splat, const BlockPlace& place,
                                          const float* values, int first, int second) {
    switch (splat.table->rowStride()) {
        case 4: return splatRange<1>(splat, place, values, first, second);
        case 8: return splatRange<2>(splat, place, values, first, second);
        case 16: return splatRange<4>(splat, place, values, first, second);
        default: return splatRange<0>(splat, place, values, first, second);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(splatBlockOnTarget);

std::uint64_t splatBlock(const BlockSplat& splat, const BlockPlace& place, const float* values, int first,
                         int second) {
    return HWY_DYNAMIC_DISPATCH(splatBlockOnTarget)(splat, place, values, first, second);
}

}  // namespace scrim
#endif
