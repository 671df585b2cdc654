// SPDX-License-Identifier: Apache-2.0
#include <scrim/splat/field_splatter.h>

#include <scrim/splat/splat_block.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace scrim {

struct FieldSplatter::Target {
    BlockSplat splat;
    PlaneStack* planes;
    int firstPlane;
    std::uint64_t footprints = 0;
};

FieldSplatter::FieldSplatter(const SparseField& field, const Mat4& tsFromIs, Kernel kernel, int stepsPerVoxel,
                             float scale)
    : m_field(field),
      m_tsFromIs(tsFromIs),
      m_scale(scale),
      m_table(kernel, tsFromIs, footprintSteps(tsFromIs, stepsPerVoxel).texel,
              footprintSteps(tsFromIs, stepsPerVoxel).sheet),
      m_order(tsFromIs) {
    Bounds lattice;
    for (const Vec3& corner : Bounds{Vec3(0), Vec3(kBlockEdge - 1)}.corners())
        lattice.include(transformVector(tsFromIs, corner));
    m_blockLower = lattice.lower - m_table.extent();
    m_blockUpper = lattice.upper + m_table.extent();
    m_sheetSpan = static_cast<int>(std::ceil(m_blockUpper.z - m_blockLower.z)) + 1;

    std::vector<std::int32_t> first(field.blockCount());
    for (std::size_t b = 0; b < first.size(); ++b) {
        const double n = transformPoint(tsFromIs, Vec3(field.blockOrigins[b])).z + m_blockLower.z;
        first[b] = static_cast<std::int32_t>(std::floor(n));
    }
    m_byFirstSheet.resize(first.size());
    std::iota(m_byFirstSheet.begin(), m_byFirstSheet.end(), 0U);
    std::stable_sort(m_byFirstSheet.begin(), m_byFirstSheet.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return first[a] < first[b]; });
    m_firstSheets.reserve(first.size());
    for (const std::uint32_t b : m_byFirstSheet) m_firstSheets.push_back(first[b]);
}

SplatWork FieldSplatter::splat(int firstSheet, int lastSheet, PlaneStack& planes, int firstPlane) const {
    Target target{{&m_order, &m_table, planes.plane(firstPlane), planes.planeStride(), planes.rowStride(),
                   firstSheet, lastSheet, m_scale},
                  &planes,
                  firstPlane};

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
    if (ts.upper.z + m_table.extentN() <= target.splat.firstSheet ||
        ts.lower.z - m_table.extentN() >= target.splat.lastSheet)
        return;
    if (edge == kBlockEdge) return splatOneBlock(transformPoint(m_tsFromIs, Vec3(origin)), values, target);
    const int half = edge / 2;
    for (int i = 0; i < 8; ++i)
        splatTile(origin + half * Int3(i >> 2 & 1, i >> 1 & 1, i & 1), half, values, target);
}

void FieldSplatter::splatOneBlock(const Vec3& ts, const float* values, Target& target) const {
    const BlockSplat& splat = target.splat;
    const auto [first, second] =
        m_order.between(splat.firstSheet - m_table.extentN() - ts.z,
                        splat.lastSheet + m_table.extentN() - ts.z);
    if (first == second) return;

    // Activate the tiles under the block, once for each sheet that it may touch.
    const auto tile = [](double texel) { return static_cast<int>(std::floor(texel)) / kTileEdge; };
    const int tx0 = tile(ts.x + m_blockLower.x), tx1 = tile(ts.x + m_blockUpper.x + 1);
    const int ty0 = tile(ts.y + m_blockLower.y), ty1 = tile(ts.y + m_blockUpper.y + 1);
    const int s0 = std::max(splat.firstSheet, static_cast<int>(std::floor(ts.z + m_blockLower.z)));
    const int s1 = std::min(splat.lastSheet, static_cast<int>(std::floor(ts.z + m_blockUpper.z)) + 1);
    for (int s = s0; s < s1; ++s)
        for (int ty = ty0; ty <= ty1; ++ty)
            for (int tx = tx0; tx <= tx1; ++tx)
                target.planes->activate(target.firstPlane + s - splat.firstSheet, tx, ty);

    const Vec3 whole = glm::floor(ts);
    const BlockPlace place{static_cast<std::int32_t>(whole.x), static_cast<std::int32_t>(whole.y),
                           static_cast<std::int32_t>(whole.z), static_cast<float>(ts.x - whole.x),
                           static_cast<float>(ts.y - whole.y), static_cast<float>(ts.z - whole.z)};
    target.footprints += splatBlock(splat, place, values, first, second);
}

}  // namespace scrim
