// SPDX-License-Identifier: Apache-2.0
// The paper's shadow buffer: a raster that is aligned with its light (or with the image plane), into which the light's
// own footprints are splatted, sheet by sheet (ZC02 section 3.2; Fig. 5, lines 10, 14 and 17). Nothing is resampled
// on the way: a cell is one light ray. Shading maps its points to the buffer after ZC02 eq. 4.
#pragma once

#include <scrim/geometry/sheets.h>
#include <scrim/geometry/view_raster.h>
#include <scrim/engine/light/shadow_buffer.h>
#include <scrim/engine/splat/plane_stack.h>

#include <cstdint>
#include <vector>

namespace scrim {

class ViewShadow final : public ShadowLookup {
  public:
    ViewShadow(const ViewRaster& raster, const Sheets& sheets, ShadowFilter filter, int batchSheets, Simd simd = {});

    void beginBatch(int firstSheet, int count) {
        m_firstSheet = firstSheet;
        m_count = count;
    }
    /// Independent tasks of a batch: rows of tiles.
    int taskCount() const { return m_raster.height / kTileEdge; }
    /// Carries one row of tiles through the batch's sheets; `extinction` is of this raster. Returns light samples.
    std::uint64_t attenuate(int task, const PlaneStack& extinction);

    void lookUpTile(int s, int texelX, int texelY, float* tau) const override;
    void lookUpPoints(int s, const float* u, const float* v, float* tau) const override;

    std::size_t bytes() const { return (m_tau.size() + m_path.size() + m_entry.size()) * sizeof(float); }
    static std::size_t bytes(const ViewRaster& raster, int batchSheets);

  private:
    const float* entry(int s) const { return m_entry.data() + static_cast<std::size_t>(s) * m_tau.size(); }

    ViewRaster m_raster;
    Simd m_simd;
    bool m_nearest;
    int m_firstSheet = 0, m_count = 0;
    std::vector<float> m_path;   // world length of each cell's ray through a sheet
    std::vector<float> m_tau;    // at entry of the next batch
    std::vector<float> m_entry;  // at entry of each sheet of the batch
};

}  // namespace scrim
