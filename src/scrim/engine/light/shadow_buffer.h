// SPDX-License-Identifier: Apache-2.0
// Shadow buffers: a raster of optical depth for each light, carried from sheet to sheet (ZC02 section 3.2).
//
// The buffer holds optical depth instead of the paper's opacity: sums of tau keep their precision
// where 1 - alpha would lose it, and the light is e^-tau of it (eq. 5). For each sheet of a batch
// the buffer also keeps tau where light enters the sheet, which shading reads.
#pragma once

#include <scrim/engine/model/plan.h>
#include <scrim/base/real.h>
#include <scrim/base/zeroed_array.h>
#include <scrim/engine/splat/plane_stack.h>
#include <scrim/engine/splat/surface.h>
#include <scrim/geometry/sheets.h>
#include <scrim/scene/dials.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace scrim {

/// The shadow of all volumes in one light, carried from batch to batch.
class Shadow {
  public:
    virtual ~Shadow() = default;
    /// Prepares sheets [firstSheet, firstSheet + count), whose planes are in `extinction`.
    /// `covered` has active tiles wherever there is extinction or the shadow will be looked up.
    virtual void beginBatch(int firstSheet, int count, const PlaneStack& extinction, const PlaneStack& covered) = 0;
    /// The number of independent tasks of the batch, which are tiles of one row.
    virtual int taskCount() const = 0;
    /// Carries the tiles of one task through the sheets of the batch: keeps tau at entry, then adds
    /// each sheet's extinction times the path through it. `surfaces`: if there are any, all
    /// extinction is theirs, and buffers that are resampled from the shared sheets classify it
    /// along their own rays. Returns the number of light samples taken.
    virtual std::uint64_t attenuate(int task, const PlaneStack& extinction,
                                    const std::vector<const Surface*>& surfaces) = 0;
    /// After all of `attenuate`: compensates for the blur of later look-ups in sheet s of the batch.
    virtual void prefilter(int /*s*/) {}
    /// Tau at entry into sheet s of the batch for the 16 x 16 texels from (texelX, texelY), in rows of 16.
    virtual void lookUpTile(int s, int texelX, int texelY, Real* tau) const = 0;
    /// The same at `count` arbitrary texel positions, a multiple of 16 and at most 256.
    virtual void lookUpPoints(int s, const Real* u, const Real* v, int count, Real* tau) const = 0;
    /// The number of sheets before a sheet of the batch that lookUpBefore reaches.
    static constexpr int kBefore = Surface::kBefore - Surface::kBehind;
    /// Tau at entry into sheet s - `back`, on the light's rays that cross sheet s at `count` positions. `known` becomes
    /// 0 where that sheet has no extinction near the ray, or lies before the light: tau is then undefined.
    virtual void lookUpBefore(int /*s*/, int /*back*/, const Real* /*u*/, const Real* /*v*/, int count, Real* /*tau*/,
                              std::uint8_t* known) const {
        std::fill_n(known, count, std::uint8_t{0});
    }
    /// Makes look-ups valid where a sheet has no extinction, too: other levels may have some there.
    virtual void lookUpAnywhere() {}
    /// Tau behind all sheets so far, on the light's rays that pass `count` positions on the plane N
    /// = `plane`, wherever that is.
    virtual void lookUpNow(double /*plane*/, const Real* /*u*/, const Real* /*v*/, int count, Real* tau) const {
        std::fill_n(tau, count, Real(0));
    }
    /// The same within the only sheet of the batch, of whose tau the fraction `part` is counted.
    virtual void lookUpWithin(double plane, Real /*part*/, const Real* u, const Real* v, int count, Real* tau) const {
        lookUpNow(plane, u, v, count, tau);
    }
    /// The cells of the light's rays through a box of texels on the plane N = `plane`; and whether
    /// any cell there, or next to it, has met active tiles so far.
    virtual Box2<double> cellsOf(const Box2<double>& texels, double /*plane*/) const { return texels; }
    virtual bool anyMet(const Box2<double>& /*cells*/) const { return false; }
    virtual std::size_t bytes() const = 0;
};

/// A buffer that is resampled from the shared sheets. Only tiles of the raster that the sheet's
/// active texels can see are touched.
class ShadowBuffer final : public Shadow {
  public:
    /// `lookUps`: the number of bilinear look-ups between this buffer and the picture: one where
    /// pixels look into it, two where texels do and pixels look at the texels. See `prefilter`.
    /// `looksBefore`: lookUpBefore will be called.
    ShadowBuffer(const LightView& view, const Sheets& sheets, ShadowFilter filter, int lookUps, int batchSheets,
                 Simd simd = {}, bool looksBefore = false);

    const LightView& view() const { return m_view; }

    /// Decides which tiles of the raster take part.
    void beginBatch(int firstSheet, int count, const PlaneStack& extinction, const PlaneStack& covered) override;
    void beginBatch(int firstSheet, int count, const PlaneStack& extinction) {
        beginBatch(firstSheet, count, extinction, extinction);
    }
    int taskCount() const override { return static_cast<int>(m_tasks.size()); }
    std::uint64_t attenuate(int task, const PlaneStack& extinction,
                            const std::vector<const Surface*>& surfaces) override;

    /// As PlaneStack::prefilter: subtracts from tau at entry a twelfth of its second differences
    /// for each look-up. The values that the buffer carries on are not changed.
    void prefilter(int s) override;

    void lookUpTile(int s, int texelX, int texelY, Real* tau) const override;
    void lookUpPoints(int s, const Real* u, const Real* v, int count, Real* tau) const override;
    void lookUpBefore(int s, int back, const Real* u, const Real* v, int count, Real* tau,
                      std::uint8_t* known) const override;

    void lookUpAnywhere() override { m_anywhere = true; }
    void lookUpNow(double plane, const Real* u, const Real* v, int count, Real* tau) const override;
    void lookUpWithin(double plane, Real part, const Real* u, const Real* v, int count, Real* tau) const override;
    Box2<double> cellsOf(const Box2<double>& texels, double plane) const override;
    bool anyMet(const Box2<double>& cells) const override;

    std::size_t bytes() const override;
    /// Upper bound on the bytes of a buffer.
    static std::size_t bytes(const LightView& view, const Sheets& sheets, int batchSheets, bool looksBefore = false);

  private:
    void lookUpPatch(int s, const LightView::Cells& map, const Real* u, const Real* v, int count, Real* tau) const;
    void leaveTheSource(double part, const FloatPlane& extinction);
    void keepLast();
    void listTasks();
    void meetTiles();
    FloatPlane planeOf(const Real* entry, const Box2<int>& window) const;
    FloatPlane entryPlane(int s) const { return planeOf(m_entry.data() + std::size_t(s) * entryStride(), m_window); }
    const std::uint8_t* usedIn(int s) const { return m_used.data() + std::size_t(s) * m_window.pixelCount(); }
    bool lit(int s) const { return m_window.width() > 0 && m_view.reaches(m_firstSheet + s); }

    LightView m_view;
    Simd m_simd;
    double m_thickness;  // of a sheet, world units
    bool m_nearest;
    Real m_prefiltering;      // factor on the second differences
    ZeroedArray<Real> m_tau;  // the whole raster: tau at entry of the next batch
    bool m_anywhere = false;
    std::vector<std::uint8_t> m_met;  // for each tile of the raster, whether it took part in any batch

    // The batch: a window of tiles of the raster, its entry planes, and which tiles take part in which sheet.
    int m_firstSheet = 0, m_count = 0;
    Box2<int> m_window;
    ZeroedArray<Real> m_entry;
    static constexpr std::uint8_t kUsed = 1;
    std::vector<std::uint8_t> m_used;  // [sheet][tileY][tileX] of the window: kUsed, or 0
    struct Task {
        int row, begin, end;  // tiles [begin, end) of a row of the window
    };
    std::vector<Task> m_tasks;  // those with tiles that take part, ascending
    // Calls visit(x) for the task's tiles, by their place in the window, that take part in sheet s.
    template <class Visit>
    void forUsed(int s, const Task& task, const Visit& visit) const {
        forTilesIn(usedIn(s) + task.row * m_window.width() + task.begin, task.end - task.begin, kUsed,
                   [&](int x) { visit(task.begin + x); });
    }

    // Window, entry planes and tiles of the last sheets before the batch, the very last sheet first.
    bool m_looksBefore;
    std::array<Box2<int>, kBefore> m_beforeWindow;
    std::array<std::vector<Real>, kBefore> m_beforeEntry;
    std::array<std::vector<std::uint8_t>, kBefore> m_beforeUsed;

    int windowWidth() const { return m_window.width() * kTileEdge; }
    std::size_t entryStride() const { return std::size_t(windowWidth()) * std::size_t(m_window.height() * kTileEdge); }
};

}  // namespace scrim
