// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/splat_block.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/splat/splat_block.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// Voxels whose addresses are computed together, before their footprints are added.
constexpr int kChunk = 32;

constexpr int kAhead = 4, kLinesAhead = 12;
constexpr std::int32_t kNoSheet = 1 << 29;  // first sheet of culled voxels: beyond every last sheet

struct Chunk {
    alignas(64) RealIndex table[kChunk];  // index of the quantised fraction
    alignas(64) RealIndex texel[kChunk];  // offset of the footprint's first texel in its plane
    alignas(64) RealIndex sheet[kChunk];  // first sheet of the footprint
    alignas(64) Real restU[kChunk];       // rest after rounding, in steps
    alignas(64) Real restV[kChunk];
    alignas(64) Real restN[kChunk];
    alignas(64) Real value[BlockSplat::kMost][kChunk];  // for each field
    // The voxels that contribute to the sheets: their pieces, and the offset of the first texel in all planes.
    RealIndex voxels[2 * kChunk];
    std::uint32_t piece[kChunk], lastPiece[kChunk];
    std::ptrdiff_t at[kChunk];
    int live;
};

HWY_INLINE int log2Of(int powerOfTwo) {
    int log2 = 0;
    while ((1 << log2) < powerOfTwo) ++log2;
    return log2;
}

// The place of a block in texel space: its first voxel is at whole + fraction on each axis. The two
// are separate, so that floats only hold offsets within a block, however large the raster is.
struct Place {
    std::int32_t wholeU, wholeV, wholeN;
    Real fractionU, fractionV, fractionN;
};

// Computes the addresses of voxels [k, k + kChunk) of the order (reading beyond its end is harmless: see the caller).
template <bool kClipped>
HWY_ATTR void locate(const BlockSplat& splat, const Place& place, int k, Chunk& chunk) {
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

// Positions between the steps of the table, in steps.
struct Rest {
    Real u, v, n;
};

template <class D>
HWY_ATTR HWY_INLINE hn::Vec<D> weightsAt(D d, const Real* piece, const Rest& rest) {
    constexpr int kPart = FootprintPieces::kRows * FootprintPieces::kColumns;
    const auto sum = hn::MulAdd(hn::Set(d, rest.u), hn::LoadU(d, piece + kPart), hn::LoadU(d, piece));
    return hn::MulAdd(hn::Set(d, rest.n), hn::LoadU(d, piece + 3 * kPart),
                      hn::MulAdd(hn::Set(d, rest.v), hn::LoadU(d, piece + 2 * kPart), sum));
}

template <class D, int kFields>
HWY_ATTR HWY_INLINE void addTo(D d, hn::Vec<D> weights, const Real* value, Real* const* texels, std::ptrdiff_t at,
                               int fields) {
    for (int f = 0; f < (kFields > 0 ? kFields : fields); ++f) {
        Real* to = texels[f] + at;
        hn::StoreU(hn::MulAdd(hn::Set(d, value[f]), weights, hn::LoadU(d, to)), d, to);
    }
}

// Adds one piece of a footprint to the same texels of one field or of several, from texels[f] + at
// on: value[f] times its weights.
template <int kFields>
HWY_ATTR HWY_INLINE void addPiece(const Real* piece, const Rest& rest, const Real* value, Real* const* texels,
                                  std::ptrdiff_t at, std::ptrdiff_t rowStride, int fields) {
    constexpr int kColumns = FootprintPieces::kColumns;
#if HWY_TARGET != HWY_SCALAR
    const hn::CappedTag<Real, 8> both;
    if (hn::Lanes(both) == 8) {
        const hn::Half<decltype(both)> row;
        const auto weights = weightsAt(both, piece, rest);
        addTo<decltype(row), kFields>(row, hn::LowerHalf(row, weights), value, texels, at, fields);
        addTo<decltype(row), kFields>(row, hn::UpperHalf(row, weights), value, texels, at + rowStride, fields);
        return;
    }
#endif
    const hn::CappedTag<Real, kColumns> d;
    for (int r = 0; r < FootprintPieces::kRows; ++r)
        for (int i = 0; i < kColumns; i += static_cast<int>(hn::Lanes(d)))
            addTo<decltype(d), kFields>(d, weightsAt(d, piece + r * kColumns + i, rest), value, texels,
                                        at + r * rowStride + i, fields);
}

// Reads the values of the chunk's voxels [begin, end), and finds those that contribute to the sheets.
template <int kFields>
HWY_ATTR void findLive(const BlockSplat& splat, const float* const* values, int k, int begin, int end, Chunk& chunk) {
    const hn::ScalableTag<Real> df;
    const hn::RebindToSigned<decltype(df)> di;
    const int fields = kFields > 0 ? kFields : splat.fields;
    const auto beforeFirst = hn::Set(di, splat.firstSheet - splat.table->sheets()), last = hn::Set(di, splat.lastSheet);
    chunk.live = 0;
    for (int f = 0; f < fields; ++f)
        for (int i = 0; i < kChunk; ++i)
            chunk.value[f][i] = std::min(values[f][splat.order->index[k + i]] * splat.scale, splat.most);
    for (int i = 0; i < kChunk; i += static_cast<int>(hn::Lanes(df))) {
        auto most = hn::Load(df, chunk.value[0] + i);
        for (int f = 1; f < fields; ++f) most = hn::Max(most, hn::Load(df, chunk.value[f] + i));
        const auto sheet = hn::Load(di, chunk.sheet + i), voxel = hn::Iota(di, i);
        const auto within = hn::And(hn::Gt(voxel, hn::Set(di, begin - 1)), hn::Lt(voxel, hn::Set(di, end)));
        const auto reaches = hn::And(hn::Gt(sheet, beforeFirst), hn::Lt(sheet, last));
        const auto shows = hn::RebindMask(di, hn::Gt(most, hn::Zero(df)));
        chunk.live += static_cast<int>(
            hn::CompressBlendedStore(voxel, hn::And(hn::And(within, reaches), shows), di, chunk.voxels + chunk.live));
    }
}

template <bool kClipped, int kFields>
HWY_ATTR std::uint64_t splatRange(const BlockSplat& splat, const Place& place, const float* const* values, int first,
                                  int second) {
    // These are copies, because the compiler must assume that writing texels changes the data behind pointers.
    const FootprintPieces& pieces = *splat.pieces;
    const int sheets = splat.table->sheets(), fields = kFields > 0 ? kFields : splat.fields;
    const std::ptrdiff_t planeStride = splat.planeStride, rowStride = splat.rowStride;
    const int firstSheet = splat.firstSheet, lastSheet = splat.lastSheet;
    const Real* const weights = pieces.weights();
    const std::uint32_t* const kinds = pieces.kinds();
    const std::ptrdiff_t* const offsets = splat.offsets;
    const std::array<Real*, BlockSplat::kMost> planes = splat.planes;
    std::uint64_t footprints = 0;
    Chunk chunk;

    for (int k0 = first; k0 < second; k0 += kChunk) {
        // The last chunk starts early enough to stay within the 512 voxels; its first part was done before.
        const int k = std::min(k0, kBlockVoxels - kChunk);
        locate<kClipped>(splat, place, k, chunk);
        findLive<kFields>(splat, values, k, k0 - k, second - k, chunk);
        for (int l = 0; l < chunk.live; ++l) {
            const std::ptrdiff_t i = chunk.voxels[l];
            const int sheet = static_cast<int>(chunk.sheet[i]);
            const int from = std::max(0, firstSheet - sheet), to = std::min(sheets, lastSheet - sheet);
            const std::uint32_t* begins = pieces.begins(std::size_t(chunk.table[i]));
            chunk.piece[l] = begins[from];
            chunk.lastPiece[l] = begins[to];
            chunk.at[l] = (sheet - firstSheet) * planeStride + chunk.texel[i];
            footprints += static_cast<std::uint64_t>(to - from);
        }
        for (int l = 0; l < chunk.live; ++l) {
            // The entries of the table are scattered over memory.
            const int ahead = std::min(l + kAhead, chunk.live - 1);
            __builtin_prefetch(kinds + chunk.piece[ahead]);
            const Real* next = weights + std::size_t(chunk.piece[ahead]) * FootprintPieces::kFloats;
            for (int line = 0; line < kLinesAhead; ++line) __builtin_prefetch(next + line * 16);
            const std::ptrdiff_t i = chunk.voxels[l];
            const Rest rest{chunk.restU[i], chunk.restV[i], chunk.restN[i]};
            Real value[BlockSplat::kMost];
            for (int f = 0; f < fields; ++f) value[f] = chunk.value[f][i];
            for (std::uint32_t p = chunk.piece[l], last = chunk.lastPiece[l]; p < last; ++p)
                addPiece<kFields>(weights + std::size_t(p) * FootprintPieces::kFloats, rest, value, planes.data(),
                                  chunk.at[l] + offsets[kinds[p]], rowStride, fields);
        }
    }
    return footprints;
}

// Separate versions for one field, which is the usual case, and for several.
template <int kFields>
HWY_ATTR std::uint64_t splatFields(const BlockSplat& splat, const Place& place, const float* const* values, int first,
                                   int second) {
    return splat.clipped ? splatRange<true, kFields>(splat, place, values, first, second)
                         : splatRange<false, kFields>(splat, place, values, first, second);
}

HWY_ATTR std::uint64_t splatBlockOnTarget(const BlockSplat& splat, const Vec3& ts, const float* const* values,
                                          int first, int second) {
    const Vec3 whole(std::floor(ts.x), std::floor(ts.y), std::floor(ts.z));
    const Place place{static_cast<std::int32_t>(whole.x), static_cast<std::int32_t>(whole.y),
                      static_cast<std::int32_t>(whole.z), static_cast<Real>(ts.x - whole.x),
                      static_cast<Real>(ts.y - whole.y),  static_cast<Real>(ts.z - whole.z)};
    return splat.fields == 1 ? splatFields<1>(splat, place, values, first, second)
                             : splatFields<0>(splat, place, values, first, second);
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

namespace {

struct Voxel {
    Vec3 ts;
    std::int32_t index;
    int bucket;   // floor of N
    int turn;     // round in which it is taken from its quarter
    int quarter;  // of the block's extent in (U, V)
};

// Takes the voxels of each bucket in turns, one from each quarter of the block's extent in (U, V).
void dealOut(std::array<Voxel, kBlockVoxels>& voxels) {
    Vec3 middle(0);
    for (const Voxel& v : voxels) middle += v.ts / double(kBlockVoxels);
    for (auto first = voxels.begin(); first != voxels.end();) {
        const auto last = std::find_if(first, voxels.end(), [&](const Voxel& v) { return v.bucket != first->bucket; });
        int dealt[4] = {0, 0, 0, 0};
        for (auto v = first; v != last; ++v) {
            v->quarter = (v->ts.x < middle.x ? 0 : 1) + (v->ts.y < middle.y ? 0 : 2);
            v->turn = dealt[v->quarter]++;
        }
        std::stable_sort(first, last, [](const Voxel& a, const Voxel& b) {
            return std::tie(a.turn, a.quarter) < std::tie(b.turn, b.quarter);
        });
        first = last;
    }
}

}  // namespace

LatticeOrder::LatticeOrder(const Mat4& tsFromIs) {
    std::array<Voxel, kBlockVoxels> voxels;
    for (int x = 0; x < kBlockEdge; ++x)
        for (int y = 0; y < kBlockEdge; ++y)
            for (int z = 0; z < kBlockEdge; ++z) {
                const int i = blockOffset(x, y, z);
                const Vec3 ts = transformVector(tsFromIs, Vec3(x, y, z));
                voxels[i] = {ts, i, static_cast<int>(std::floor(ts.z)), 0, 0};
            }
    std::stable_sort(voxels.begin(), voxels.end(), [](const Voxel& a, const Voxel& b) { return a.bucket < b.bucket; });
    dealOut(voxels);

    m_firstBucket = voxels.front().bucket;
    for (std::size_t k = 0; k < voxels.size(); ++k) {
        const Voxel& v = voxels[k];
        while (static_cast<int>(m_bucketBegin.size()) <= v.bucket - m_firstBucket)
            m_bucketBegin.push_back(static_cast<int>(k));
        offsetU[k] = static_cast<Real>(v.ts.x);
        offsetV[k] = static_cast<Real>(v.ts.y);
        offsetN[k] = static_cast<Real>(v.ts.z);
        index[k] = v.index;
    }
    m_bucketBegin.push_back(kBlockVoxels);
}

std::pair<int, int> LatticeOrder::between(double lower, double upper) const {
    const int buckets = static_cast<int>(m_bucketBegin.size()) - 1;
    const auto begin = [&](double n) {
        const double bucket = std::clamp(std::floor(n) - m_firstBucket, 0.0, double(buckets));
        return m_bucketBegin[bucket];
    };
    return {begin(lower), begin(upper + 1)};
}

HWY_EXPORT(splatBlockOnTarget);

std::uint64_t splatBlock(const BlockSplat& splat, const Vec3& ts, const float* const* values, int first, int second) {
    return SCRIM_ON_TARGET(splat.simd, splatBlockOnTarget)(splat, ts, values, first, second);
}

}  // namespace scrim
#endif
