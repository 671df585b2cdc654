// SPDX-License-Identifier: Apache-2.0
// Splats fields into sheets: active voxels only, block by block in a fixed order, and constant
// tiles as blocks that are never allocated (algorithm, "Feeding the splatter").
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/splat/footprint.h>
#include <scrim/engine/splat/plane_stack.h>
#include <scrim/engine/splat/splat_block.h>
#include <scrim/geometry/spaces.h>
#include <scrim/volume/sparse_field.h>

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace scrim {

/// Returns true for a box of tiles if nobody sees what is splatted there (the occlusion map of ZC02 Fig. 5).
using TileCull = std::function<bool(const Box2<int>&)>;

/// The extent, in texel space, of a cube of `edge` voxels from its first voxel on.
Bounds extentOf(int edge, const Mat4& tsFromIs);

/// Splats a field onto the sheets' own texels, or onto the cells of a parallel view.
class FieldSplatter {
  public:
    /// `field` must outlive this object. `tsFromIs` maps its index space to texel space. Voxel values are multiplied by
    /// `scale` and clamped to `most`; positions are quantised to `stepsPerVoxel`.
    FieldSplatter(const SparseField& field, const Mat4& tsFromIs, Kernel kernel, int stepsPerVoxel, Real scale,
                  Real most = std::numeric_limits<float>::max(), Simd simd = {});
    FieldSplatter(FieldSplatter&&) noexcept;
    ~FieldSplatter();

    /// Splats `field`, which must outlive this object, together with the first field, whose footprints and scale it
    /// shares. See haveOneTopology; at most BlockSplat::kMost fields together.
    void join(const SparseField& field);

    /// Replaces the values of the field's blocks by others, 512 each.
    void useValues(std::vector<const float*> values) { m_values.front() = std::move(values); }

    /// Bytes of what is known of each block of a field.
    static std::size_t bytesOfBlocks(const SparseField& field);

    /// Finds where blocks of few voxels have them, so that the rest of such a block costs nothing.
    /// To be called after `join` and `useValues`.
    void tighten();

    std::size_t tableBytes() const { return m_pieces.bytes(); }
    /// Rows of tiles in a band. Setting more than needed lets several splatters take turns at the same bands.
    int bandTiles() const { return m_bandTiles; }
    void useBands(int tiles) { m_bandTiles = tiles; }
    int bands(const PlaneStack& planes) const { return (planes.tilesY() + m_bandTiles - 1) / m_bandTiles; }

    /// Sets marked[b] for the bands b of `planes` in which something may touch sheets [firstSheet, lastSheet).
    void markBands(int firstSheet, int lastSheet, const PlaneStack& planes, std::vector<std::uint8_t>& marked) const;

    /// Adds the field to sheets [firstSheet, lastSheet). The mean over each sheet's thickness of the reconstructed
    /// field times scale, at texel centres, is added to planes firstPlane + [0, lastSheet - firstSheet), for which
    /// `begin` was called. Returns the number of footprints (voxel and sheet pairs). Different threads may call it at
    /// once for different planes. Footprints that are not completely on the planes are culled, and so are blocks that
    /// `cull` rejects. `planes`: one for each field, the first one and those that joined it. `band`: splats only the
    /// blocks of one of `bands(planes)` bands of rows. Neighbouring bands share rows, but every second band may be
    /// splatted at once. Without a band all are splatted, those with even numbers first.
    std::uint64_t splat(int firstSheet, int lastSheet, std::span<PlaneStack> planes, int firstPlane,
                        const TileCull& cull, int band) const;
    std::uint64_t splat(int firstSheet, int lastSheet, std::span<PlaneStack> planes, int firstPlane,
                        const TileCull& cull = {}) const;
    std::uint64_t splat(int firstSheet, int lastSheet, PlaneStack& planes, int firstPlane,
                        const TileCull& cull = {}) const {
        return splat(firstSheet, lastSheet, std::span<PlaneStack>(&planes, 1), firstPlane, cull);
    }

  private:
    struct Target;
    static bool isScattered(const SparseField& field);
    Bounds tsBoxOf(const Int3& origin, int edge) const;
    Box2<int> tilesUnder(const Vec3& tsOrigin, const Bounds& reach) const;
    bool touches(std::uint32_t block, int firstSheet, int lastSheet) const {
        return m_touched.empty() || (m_touched[block].first < lastSheet && m_touched[block].second > firstSheet);
    }
    int bandOf(int row, int bands) const;
    int bandOf(const Vec3& tsOrigin, int bands) const { return bandOf(tilesUnder(tsOrigin, m_reach).y0, bands); }
    void prefetchBlock(std::uint32_t block) const;
    Bounds liveVoxels(std::size_t block) const;
    void splatOneBlock(const Vec3& tsOrigin, const Bounds& reach, const float* const* values, Target& target) const;
    void splatTile(const Int3& origin, int edge, const float* values, Target& target) const;

    const SparseField& m_field;
    std::vector<std::vector<const float*>> m_values;  // for each block, of the first field and of those that joined it
    Mat4 m_tsFromIs;
    Real m_scale, m_most;
    Simd m_simd;
    FootprintTable m_table;  // without its weights
    FootprintPieces m_pieces;
    LatticeOrder m_order;
    struct SheetOrder;
    template <class Origin>
    void addOrder(std::vector<std::uint32_t> numbers, int edge, const Origin& origin);
    std::vector<std::uint32_t> tilesTouching(int firstSheet, int lastSheet) const;

    std::vector<std::int32_t> m_rows;  // of each block: the first row of tiles that it may touch
    Vec3 m_footprint;                  // half the extent of a voxel's footprint in texel space
    Bounds m_reach;                    // offsets of a block's voxels in texel space, including their footprints
    std::vector<Bounds> m_live;        // the same for each block's voxels that are not 0; empty: not known
    std::vector<std::pair<std::int32_t, std::int32_t>> m_touched;  // the sheets [first, second) that these may touch
    std::vector<SheetOrder> m_orders;                              // of the blocks, and of each size of tiles
    int m_bandTiles;                                               // rows of tiles in a band, more than a block touches
};

}  // namespace scrim
