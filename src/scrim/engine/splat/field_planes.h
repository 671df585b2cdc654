// SPDX-License-Identifier: Apache-2.0
// Stage 1 of a batch: one scalar field splatted into sheets. Densities, albedos, emission and temperatures are all fields;
// what is extinct there is made of some of them (extinction_sum.h).
#pragma once

#include <scrim/engine/plan/culling.h>
#include <scrim/engine/splat/plane_stack.h>
#include <scrim/engine/splat/splatter.h>

#include <limits>
#include <variant>
#include <vector>

namespace scrim {

class FieldPlanes {
  public:
    /// How a field is splatted.
    struct Settings {
        float scale = 1;                                  ///< times every voxel
        float most = std::numeric_limits<float>::max();   ///< scaled voxels count as this above it
        int stepsPerVoxel = 8;                            ///< of its footprints, see FootprintTable
        int halo = 0;                                     ///< sheets kept on either side of a batch
    };

    /// Onto the cells of `lattice`, the sheets' own or a view's. The field, `sheets` and `lattice` must outlive this.
    FieldPlanes(const ViewField& field, const Settings& settings, const Dials& dials, const Sheets& sheets,
                const Lattice& lattice, int batchSheets);

    /// Begins the batch [firstSheet, firstSheet + count); returns the number of independent splatting tasks.
    int beginBatch(int firstSheet, int count);
    /// Returns the footprints that were added. Blocks that touch none of the tiles of `needed` are culled, and so are
    /// those that `cull` names.
    std::uint64_t splat(int task, const NeededTiles* needed, const TileCull& cull);

    /// Planes of sheets in a ring, so that every sheet is splatted once: the plane of a sheet of the batch or its halo.
    int planeOf(int sheet) const { return (sheet - m_origin + m_settings.halo) % m_planes.planes(); }
    /// Without a halo planes [0, count) are those of the batch.
    const PlaneStack& planes() const { return m_planes; }

    std::size_t bytes() const;
    /// An upper estimate beforehand.
    static std::size_t bytes(const ViewField& field, const Settings& settings, const Dials& dials, const Sheets& sheets,
                             const Lattice& lattice, int batchSheets);

  private:
    struct Run {
        int sheet, count;
    };

    const Lattice& m_lattice;
    Settings m_settings;
    std::variant<FieldSplatter, WarpedSplatter> m_splatter;
    PlaneStack m_planes;
    int m_origin = -1;  // the first sheet of the first batch, whose planes lie as it wants them
    int m_readySheet = 0;
    std::vector<Run> m_runs;
};

}  // namespace scrim
