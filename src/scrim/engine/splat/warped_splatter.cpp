// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/warped_splatter.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace scrim {
namespace {

// The map to texel space in which the middle ray is upright and texels are finer.
Mat4 tableFromIs(const Mat4& tsFromIs, const Vec2& slope, double finer) {
    Mat4 upright(1.0);
    upright[0].x = finer;
    upright[1].y = finer;
    upright[2].x = -slope.x * finer;
    upright[2].y = -slope.y * finer;
    return upright * tsFromIs;
}

// The slope of the view's ray through the middle of the field.
Vec2 middleSlope(const SparseField& field, const Mat4& tsFromIs, const Lattice& raster) {
    const Vec3 at = raster.place(transformPoint(tsFromIs, field.isBounds().center()));
    const Vec3 ray =
        at.z > 0 ? raster.rayThrough(at.x, at.y) : raster.rayThrough(0.5 * raster.width, 0.5 * raster.height);
    return {ray.x / ray.z, ray.y / ray.z};
}

}  // namespace

struct WarpedSplatter::Target {
    int firstSheet, lastSheet;
    PlaneStack* planes;
    int firstPlane;
    const TileCull* cull;
    std::uint64_t footprints = 0;
};

WarpedSplatter::WarpedSplatter(const SparseField& field, const Mat4& tsFromIs, const Lattice& raster, Kernel kernel,
                               int stepsPerVoxel, Real scale, Real most)
    : m_field(field),
      m_tsFromIs(tsFromIs),
      m_raster(raster),
      m_scale(scale),
      m_most(most),
      m_finer(footprintSteps(tsFromIs, stepsPerVoxel).texel),
      m_slope(middleSlope(field, tsFromIs, raster)),
      m_table(kernel, tableFromIs(tsFromIs, m_slope, m_finer), {2, footprintSteps(tsFromIs, stepsPerVoxel).sheet}),
      m_extent(m_table.extent().x / m_finer, m_table.extent().y / m_finer, m_table.extent().z) {
    const Bounds lattice = extentOf(kBlockEdge, tsFromIs);
    m_first = lattice.lower.z;
    m_last = lattice.upper.z;
}

std::uint64_t WarpedSplatter::splat(int firstSheet, int lastSheet, PlaneStack& planes, int firstPlane,
                                    const TileCull& cull) const {
    Target target{firstSheet, lastSheet, &planes, firstPlane, &cull};
    for (std::size_t b = 0; b < m_field.blockCount(); ++b)
        splatOneBlock(m_field.blockOrigins[b], m_field.block(b), target);
    std::array<float, kBlockVoxels> constant;
    for (const ConstantTile& tile : m_field.tiles) {
        constant.fill(tile.value);
        splatTile(tile.origin, tile.edge, constant.data(), target);
    }
    return target.footprints;
}

void WarpedSplatter::splatTile(const Int3& origin, int edge, const float* values, Target& target) const {
    if (edge == kBlockEdge) return splatOneBlock(origin, values, target);
    const Bounds ts = transformed(m_tsFromIs, Bounds{Vec3(origin), Vec3(origin + Int3(edge - 1))});
    if (ts.upper.z + m_extent.z + 1 < target.firstSheet || ts.lower.z - m_extent.z - 1 > target.lastSheet) return;
    const int half = edge / 2;
    for (int i = 0; i < 8; ++i) splatTile(origin + half * Int3(i >> 2 & 1, i >> 1 & 1, i & 1), half, values, target);
}

void WarpedSplatter::splatOneBlock(const Int3& origin, const float* values, Target& target) const {
    const double n = transformPoint(m_tsFromIs, Vec3(origin)).z;
    if (n + m_last + m_extent.z + 1 < target.firstSheet || n + m_first - m_extent.z - 1 > target.lastSheet) return;
    for (int x = 0; x < kBlockEdge; ++x)
        for (int y = 0; y < kBlockEdge; ++y)
            for (int z = 0; z < kBlockEdge; ++z) {
                const Real value = std::min(values[blockOffset(x, y, z)] * m_scale, m_most);
                if (value != 0) splatVoxel(transformPoint(m_tsFromIs, Vec3(origin + Int3(x, y, z))), value, target);
            }
}

void WarpedSplatter::splatVoxel(const Vec3& ts, Real value, Target& target) const {
    // The quantised depth selects the entry, and with it the sheets.
    const int steps = m_table.sheetSteps();
    const auto depth = static_cast<int>(std::floor(ts.z * steps + 0.5));
    const int whole = depth >= 0 ? depth / steps : -((-depth + steps - 1) / steps);
    const Real* entry = m_table.weights() + m_table.offset(0, 0, depth - whole * steps);
    const int first = whole + m_table.firstSheet();
    for (int slab = 0; slab < m_table.sheets(); ++slab) {
        const int sheet = first + slab;
        if (sheet < target.firstSheet || sheet >= target.lastSheet) continue;
        // Moves along the middle ray to the sheet's middle, and from there into the view.
        const double away = sheet + 0.5 - ts.z;
        const Vec3 onPlane(ts.x + m_slope.x * away, ts.y + m_slope.y * away, sheet + 0.5);
        const Vec3 at = m_raster.place(onPlane);
        if (at.z <= 0) continue;  // behind the view
        const Mat4 map = m_raster.linearised(onPlane);
        const double a = map[0].x, b = map[1].x, c = map[0].y, d = map[1].y, determinant = a * d - b * c;
        const double reachX = std::abs(a) * m_extent.x + std::abs(b) * m_extent.y;
        const double reachY = std::abs(c) * m_extent.x + std::abs(d) * m_extent.y;
        const int x0 = static_cast<int>(std::max(0.0, std::ceil(at.x - reachX)));
        const int y0 = static_cast<int>(std::max(0.0, std::ceil(at.y - reachY)));
        const int x1 = static_cast<int>(std::min(m_raster.width - 1.0, std::floor(at.x + reachX)));
        const int y1 = static_cast<int>(std::min(m_raster.height - 1.0, std::floor(at.y + reachY)));
        if (x1 < x0 || y1 < y0 || determinant == 0) continue;
        const Box2<int> tiles{x0 / kTileEdge, y0 / kTileEdge, x1 / kTileEdge + 1, y1 / kTileEdge + 1};
        if (*target.cull && (*target.cull)(tiles)) continue;
        const int p = target.firstPlane + sheet - target.firstSheet;
        for (int ty = tiles.y0; ty < tiles.y1; ++ty)
            for (int tx = tiles.x0; tx < tiles.x1; ++tx) target.planes->activate(p, tx, ty);
        ++target.footprints;

        // The map from cells to columns and rows of the table.
        const Real* weights = entry + slab * m_table.sheetStride();
        const auto uX = static_cast<Real>(m_finer * d / determinant),
                   uY = static_cast<Real>(-m_finer * b / determinant);
        const auto vX = static_cast<Real>(-m_finer * c / determinant),
                   vY = static_cast<Real>(m_finer * a / determinant);
        const int columns = m_table.columns(), rows = m_table.rows(), stride = m_table.rowStride();
        for (int y = y0; y <= y1; ++y) {
            Real* row = target.planes->plane(p) + static_cast<std::ptrdiff_t>(y) * target.planes->rowStride();
            const auto dy = static_cast<Real>(y - at.y);
            for (int x = x0; x <= x1; ++x) {
                const auto dx = static_cast<Real>(x - at.x);
                const Real u = uX * dx + uY * dy - static_cast<Real>(m_table.firstColumn());
                const Real v = vX * dx + vY * dy - static_cast<Real>(m_table.firstRow());
                if (!(u >= 0 && v >= 0 && u < static_cast<Real>(columns - 1) && v < static_cast<Real>(rows - 1)))
                    continue;
                const int column = static_cast<int>(u), line = static_cast<int>(v);
                const Real fu = u - static_cast<Real>(column), fv = v - static_cast<Real>(line);
                const Real* w = weights + line * stride + column;
                const Real top = w[0] + fu * (w[1] - w[0]), bottom = w[stride] + fu * (w[stride + 1] - w[stride]);
                row[x] += value * (top + fv * (bottom - top));
            }
        }
    }
}

}  // namespace scrim
