// SPDX-License-Identifier: Apache-2.0
// Shadow buffers: one raster of optical depth a light, carried from sheet to sheet (ZC02 section 3.2).
//
// The buffer holds optical depth instead of the paper's opacity: sums of tau keep their precision where
// 1 - alpha would lose it, and light is e^-tau of it (eq. 5). For each sheet of a batch it also keeps tau as it
// was when light entered the sheet; that is what shading reads. Only tiles of the raster that the sheet's active
// texels can see are touched.
#pragma once

#include <scrim/engine/light/light_view.h>
#include <scrim/engine/splat/plane_sampling.h>
#include <scrim/engine/splat/plane_stack.h>
#include <scrim/scene/dials.h>

#include <cstdint>
#include <vector>

namespace scrim {

/// What shading wants to know of a shadow buffer.
class ShadowLookup {
  public:
    virtual ~ShadowLookup() = default;
    /// Tau at entry of sheet s of the batch for the 16 x 16 texels from (texelX, texelY), rows of 16.
    virtual void lookUpTile(int s, int texelX, int texelY, float* tau) const = 0;
    /// The same at 256 arbitrary texel positions.
    virtual void lookUpPoints(int s, const float* u, const float* v, float* tau) const = 0;
};

class ShadowBuffer final : public ShadowLookup {
  public:
    /// `lookUps`: bilinear ones on the way from this buffer to the picture, one where pixels look into it, two where
    /// texels do that pixels then look at. See `sharpen`.
    ShadowBuffer(const LightView& view, const Sheets& sheets, ShadowFilter filter, int lookUps, int batchSheets,
                 Simd simd = {});

    const LightView& view() const { return m_view; }

    /// Prepares sheets [firstSheet, firstSheet + count), of which `extinction` holds the planes: decides which tiles of
    /// the raster take part. `covered` has active tiles wherever there is extinction, and wherever else the buffer will
    /// be looked into.
    void beginBatch(int firstSheet, int count, const PlaneStack& extinction, const PlaneStack& covered);
    void beginBatch(int firstSheet, int count, const PlaneStack& extinction) {
        beginBatch(firstSheet, count, extinction, extinction);
    }

    /// Number of independent tasks of the batch: rows of tiles.
    int taskCount() const { return m_windowTilesY; }

    /// Carries one row of tiles through the sheets of the batch: keeps tau at entry, then adds each sheet's
    /// extinction times the path through it. Returns the number of light samples taken.
    std::uint64_t attenuate(int task, const PlaneStack& extinction);

    /// Makes up beforehand for the blur of the look-ups to come, as unblur.h does for sheets: tau at entry of sheet s
    /// of the batch loses a twelfth of its second differences for each look-up. After all of `attenuate`; what the
    /// buffer carries on stays as it is.
    void sharpen(int s);

    void lookUpTile(int s, int texelX, int texelY, float* tau) const override;
    void lookUpPoints(int s, const float* u, const float* v, float* tau) const override;

    std::size_t bytes() const;
    /// Upper estimate of the bytes a buffer takes.
    static std::size_t bytes(const LightView& view, const Sheets& sheets, int batchSheets);

  private:
    void leaveTheSource(double part, const FloatPlane& extinction);
    FloatPlane entryPlane(int s) const;
    bool lit(int s) const { return m_windowTilesX > 0 && m_view.reaches(m_firstSheet + s); }

    LightView m_view;
    Simd m_simd;
    double m_thickness;  // of a sheet, world units
    bool m_nearest;
    float m_sharpening;        // times the second differences
    std::vector<float> m_tau;  // the whole raster: tau at entry of the next batch

    // The batch: a window of tiles of the raster, its entry planes and which tiles take part in which sheet.
    int m_firstSheet = 0, m_count = 0;
    int m_windowTileX = 0, m_windowTileY = 0, m_windowTilesX = 0, m_windowTilesY = 0;
    std::vector<float> m_entry;
    std::vector<std::uint8_t> m_used;  // [sheet][tileY][tileX] of the window

    int windowWidth() const { return m_windowTilesX * kTileEdge; }
    std::size_t entryStride() const {
        return static_cast<std::size_t>(windowWidth()) * static_cast<std::size_t>(m_windowTilesY * kTileEdge);
    }
};

}  // namespace scrim
