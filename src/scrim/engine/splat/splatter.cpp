// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/splatter.h>

#include <scrim/engine/splat/splat_block.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace scrim {
namespace {

// How far the position in a table may be from the true one, in sheets: half a step, and a whole one to have floats'
// rounding in it too.
double rounding(const FootprintTable& table) {
    return 1.0 / table.sheetSteps();
}

// The sheets that footprints of voxels at depths [lower, upper] may be written to, before and behind.
int firstTouched(const FootprintTable& table, double lower) {
    return static_cast<int>(std::floor(lower - rounding(table))) + table.firstSheet();
}
int lastTouched(const FootprintTable& table, double upper) {
    return static_cast<int>(std::floor(upper + rounding(table))) + table.firstSheet() + table.sheets() - 1;
}

}  // namespace

struct FieldSplatter::Target {
    BlockSplat splat;
    PlaneStack* planes;
    int firstPlane;
    const TileCull* cull;
    std::uint64_t footprints = 0;
};

FieldSplatter::FieldSplatter(const SparseField& field, const Mat4& tsFromIs, Kernel kernel, int stepsPerVoxel,
                             float scale, FootprintLookup lookup, float most, Simd simd)
    : m_field(field),
      m_tsFromIs(tsFromIs),
      m_scale(scale),
      m_most(most),
      m_simd(simd),
      m_table(kernel, tsFromIs, footprintSteps(tsFromIs, stepsPerVoxel).texel,
              footprintSteps(tsFromIs, stepsPerVoxel).sheet, lookup),
      m_order(tsFromIs) {
    Bounds lattice;
    for (const Vec3& corner : Bounds{Vec3(0), Vec3(kBlockEdge - 1)}.corners())
        lattice.include(transformVector(tsFromIs, corner));
    // Slopes reach a step beyond the kernel.
    const double texelStep = 1.0 / m_table.texelSteps();
    const Vec3 reach = m_table.extent() + Vec3(texelStep, texelStep, 2 * rounding(m_table));
    m_blockLower = lattice.lower - reach;
    m_blockUpper = lattice.upper + reach;
    m_sheetSpan = lastTouched(m_table, lattice.size().z) - firstTouched(m_table, 0) + 2;

    std::vector<std::int32_t> first(field.blockCount());
    for (std::size_t b = 0; b < first.size(); ++b) {
        const double n = transformPoint(tsFromIs, Vec3(field.blockOrigins[b])).z + lattice.lower.z;
        first[b] = firstTouched(m_table, n);
    }
    m_byFirstSheet.resize(first.size());
    std::iota(m_byFirstSheet.begin(), m_byFirstSheet.end(), 0U);
    std::stable_sort(m_byFirstSheet.begin(), m_byFirstSheet.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return first[a] < first[b]; });
    m_firstSheets.reserve(first.size());
    for (const std::uint32_t b : m_byFirstSheet) m_firstSheets.push_back(first[b]);
}

SplatWork FieldSplatter::splat(int firstSheet, int lastSheet, PlaneStack& planes, int firstPlane,
                               const TileCull& cull) const {
    Target target{{&m_order, &m_table, planes.plane(firstPlane), planes.planeStride(), planes.rowStride(), firstSheet,
                   lastSheet, m_scale, m_most, planes.width(), planes.height(), false, m_simd},
                  &planes,
                  firstPlane,
                  &cull};

    const auto begin = std::lower_bound(m_firstSheets.begin(), m_firstSheets.end(), firstSheet - m_sheetSpan);
    const auto end = std::lower_bound(begin, m_firstSheets.end(), lastSheet);
    for (auto it = begin; it != end; ++it) {
        const std::uint32_t b = m_byFirstSheet[static_cast<std::size_t>(it - m_firstSheets.begin())];
        splatOneBlock(transformPoint(m_tsFromIs, Vec3(m_field.blockOrigins[b])), m_field.block(b), target);
    }

    std::array<float, kBlockVoxels> constant;
    for (const ConstantTile& tile : m_field.tiles) {
        constant.fill(tile.value);
        splatTile(tile.origin, tile.edge, constant.data(), target);
    }
    return {0, target.footprints};
}

// A tile is cut into halves until its pieces are blocks or miss the sheets.
void FieldSplatter::splatTile(const Int3& origin, int edge, const float* values, Target& target) const {
    const Bounds is{Vec3(origin), Vec3(origin + Int3(edge - 1))};
    const Bounds ts = transformed(m_tsFromIs, is);
    if (lastTouched(m_table, ts.upper.z) < target.splat.firstSheet ||
        firstTouched(m_table, ts.lower.z) >= target.splat.lastSheet)
        return;
    if (edge == kBlockEdge) return splatOneBlock(transformPoint(m_tsFromIs, Vec3(origin)), values, target);
    const int half = edge / 2;
    for (int i = 0; i < 8; ++i) splatTile(origin + half * Int3(i >> 2 & 1, i >> 1 & 1, i & 1), half, values, target);
}

void FieldSplatter::splatOneBlock(const Vec3& ts, const float* values, Target& target) const {
    const BlockSplat& splat = target.splat;
    // All voxels whose entry in the table has one of the sheets, be it with zeros: which voxels are fed to a sheet,
    // and the count of footprints, must not hang on how sheets are spread over calls.
    const auto [first, second] =
        m_order.between(splat.firstSheet - m_table.firstSheet() - m_table.sheets() + 1 - rounding(m_table) - ts.z,
                        splat.lastSheet - m_table.firstSheet() - ts.z);
    if (first == second) return;

    // Activate the tiles under the block, once for each sheet that it may touch.
    const auto tile = [](double texel) { return static_cast<int>(std::floor(texel / kTileEdge)); };
    const int tx0 = tile(ts.x + m_blockLower.x), tx1 = tile(ts.x + m_blockUpper.x + 1);
    const int ty0 = tile(ts.y + m_blockLower.y), ty1 = tile(ts.y + m_blockUpper.y + 1);
    const int mostX = target.planes->tilesX() - 1, mostY = target.planes->tilesY() - 1;
    if (tx1 < 0 || ty1 < 0 || tx0 > mostX || ty0 > mostY) return;
    if (*target.cull && (*target.cull)(tx0, ty0, tx1, ty1)) return;
    // Tables reach a little beyond the kernel: a texel before it, and rows are rounded up behind it.
    constexpr double kBefore = 2, kBehind = 6;
    target.splat.clipped = ts.x + m_blockLower.x < kBefore || ts.y + m_blockLower.y < kBefore ||
                           ts.x + m_blockUpper.x > splat.width - kBehind ||
                           ts.y + m_blockUpper.y > splat.height - kBehind;
    const int s0 = std::max(splat.firstSheet, static_cast<int>(std::floor(ts.z + m_blockLower.z)));
    const int s1 = std::min(splat.lastSheet, static_cast<int>(std::floor(ts.z + m_blockUpper.z)) + 1);
    for (int s = s0; s < s1; ++s)
        for (int ty = std::max(ty0, 0); ty <= std::min(ty1, mostY); ++ty)
            for (int tx = std::max(tx0, 0); tx <= std::min(tx1, mostX); ++tx)
                target.planes->activate(target.firstPlane + s - splat.firstSheet, tx, ty);

    const Vec3 whole = glm::floor(ts);
    const BlockPlace place{static_cast<std::int32_t>(whole.x), static_cast<std::int32_t>(whole.y),
                           static_cast<std::int32_t>(whole.z), static_cast<float>(ts.x - whole.x),
                           static_cast<float>(ts.y - whole.y), static_cast<float>(ts.z - whole.z)};
    target.footprints += splatBlock(splat, place, values, first, second);
}

}  // namespace scrim
