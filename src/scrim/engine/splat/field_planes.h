// SPDX-License-Identifier: Apache-2.0
// Stages 1 and 2 for one volume: its field splatted into sheets, and what is extinct there.
//
// A medium's extinction is the field times a scale, so its sheets of field are its sheets of extinction. A classified
// volume keeps the field itself, with some sheets more on either side of the batch for gradients and for the
// transfer function's mean along a ray: a ring of planes, so that every sheet is splatted once.
//
// The raster may be the sheets' own, which all views share, or be aligned with one view.
#pragma once

#include <scrim/engine/plan/plan.h>
#include <scrim/engine/shade/surface.h>
#include <scrim/engine/splat/splatter.h>
#include <scrim/engine/splat/plane_stack.h>
#include <scrim/engine/splat/warped_splatter.h>

#include <optional>
#include <variant>
#include <vector>

namespace scrim {

class VolumePlanes {
  public:
    /// `volume` must outlive this. `voxel`: unit of the dials.
    VolumePlanes(const ViewVolume& volume, const Dials& dials, const Sheets& sheets, const ViewRaster& raster,
                 int batchSheets, double voxel);

    /// Begins the batch [firstSheet, firstSheet + count); returns the number of independent splatting tasks.
    int beginBatch(int firstSheet, int count);
    /// Blocks that touch none of the tiles of `needed` are left out, and so are those that `cull` does without.
    SplatWork splat(int task, const NeededTiles* needed, const TileCull& cull);
    /// Classifies sheet firstSheet + p; after all splatting. Nothing to do for a medium.
    void classify(int p);

    /// Extinction per world unit at texels, planes [0, count).
    const PlaneStack& extinction() const { return m_surface ? m_surface->extinction : m_values; }

    const ViewVolume& volume() const { return m_volume; }
    /// Of a classified volume: the field around sheet firstSheet + p, and what belongs to its transfer function.
    ValuePlanes values(int p) const;
    const TransferTable& table() const { return m_surface->table; }
    /// Differences for normals around the tile (tx, ty) of sheet firstSheet + p.
    GradientStep step(int p, int tx, int ty) const;
    /// Steps of a volume's footprints: surfaces take twice what the dial says, because normals show ripples best.
    static int footprintStepsOf(const ViewVolume& volume, const Dials& dials);
    /// Planes beyond those of a batch that a classified volume needs.
    static int halo(const ViewVolume& volume, const Sheets& sheets);
    double vagueGradient() const { return m_surface->vagueGradient; }
    std::size_t bytes() const;
    /// An upper estimate beforehand.
    static std::size_t bytes(const ViewVolume& volume, const Dials& dials, const Sheets& sheets,
                             const ViewRaster& raster, int batchSheets);

  private:
    struct Surface {
        TransferTable table;
        GradientStep step;  // of a parallel raster: the same everywhere
        double vagueGradient;
        PlaneStack extinction;
    };
    struct Run {
        int sheet, count;
    };
    GradientStep stepFor(const Mat4& rsFromTs) const;
    int planeOf(int sheet) const { return (sheet - m_origin + m_halo) % m_values.planes(); }

    const ViewVolume& m_volume;
    Simd m_simd;
    const Sheets& m_sheets;
    ViewRaster m_raster;
    bool m_shared;  // the raster is the sheets' own: views look between its texels
    int m_halo;     // sheets on either side of a batch
    std::variant<FieldSplatter, WarpedSplatter> m_splatter;
    PlaneStack m_values;
    std::optional<Surface> m_surface;  // classified volumes
    int m_origin = -1;                 // the first sheet of the first batch, whose planes lie as it wants them
    int m_firstSheet = 0, m_readySheet = 0;
    std::vector<Run> m_runs;
};

}  // namespace scrim
