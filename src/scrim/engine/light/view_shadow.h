// SPDX-License-Identifier: Apache-2.0
// The shadow buffer of the paper, on its light's own raster: for per-view splatting alone.
#pragma once

#include <scrim/engine/light/shadow_buffer.h>
#include <scrim/geometry/lattice.h>

#include <vector>

namespace scrim {

/// The paper's shadow buffer: a raster aligned with its light (or with the image plane), into which the light's own
/// footprints are splatted, sheet by sheet (ZC02 section 3.2; Fig. 5, lines 10, 14 and 17). Nothing is resampled on the
/// way, since a cell is one light ray. Shading maps its points to the buffer by ZC02 eq. 4.
class ViewShadow final : public Shadow {
  public:
    ViewShadow(const Lattice& raster, const Sheets& sheets, ShadowFilter filter, int batchSheets, Simd simd = {});

    void beginBatch(int firstSheet, int count, const PlaneStack&, const PlaneStack&) override {
        m_firstSheet = firstSheet;
        m_count = count;
    }
    int taskCount() const override { return m_raster.height / kTileEdge; }
    /// `extinction` has this raster.
    std::uint64_t attenuate(int task, const PlaneStack& extinction, const std::vector<const Surface*>&) override;
    void lookUpTile(int s, int texelX, int texelY, Real* tau) const override;
    void lookUpPoints(int s, const Real* u, const Real* v, int count, Real* tau) const override;

    std::size_t bytes() const override { return (m_tau.size() + m_path.size() + m_entry.size()) * sizeof(Real); }
    static std::size_t bytes(const Lattice& raster, int batchSheets);

  private:
    const Real* entry(int s) const { return m_entry.data() + std::size_t(s) * m_tau.size(); }

    Lattice m_raster;
    Simd m_simd;
    bool m_nearest;
    int m_firstSheet = 0, m_count = 0;
    std::vector<Real> m_path;   // world length of each cell's ray through a sheet
    ZeroedArray<Real> m_tau;    // at entry of the next batch
    ZeroedArray<Real> m_entry;  // at entry of each sheet of the batch
};

}  // namespace scrim
