// SPDX-License-Identifier: Apache-2.0
// Stage 1 of a batch: splats a field, or several of one topology together, into sheets. Densities, albedos, emission
// and temperatures are all fields; extinction is computed from some of them (extinction_sum.h).
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/splat/plane_stack.h>
#include <scrim/engine/splat/splatter.h>
#include <scrim/volume/tile_levels.h>

#include <array>
#include <limits>
#include <vector>

namespace scrim {

class FieldPlanes {
  public:
    /// How a field is splatted.
    struct Settings {
        Real scale = 1;                                 ///< factor on every voxel
        Real most = std::numeric_limits<float>::max();  ///< scaled voxels are clamped to this
        int stepsPerVoxel = 8;                          ///< of its footprints, see FootprintTable
        int before = 0, behind = 0;                     ///< sheets kept on either side of a batch
    };

    /// Splats onto the cells of `lattice`, which is the sheets' own or a view's. Fields, `dials`, `sheets` and
    /// `lattice` must outlive this object. The fields of a placement must have the topology of the first one
    /// (haveOneTopology); each has its own planes. Several placements, each with the same number of fields, add up in
    /// the same planes. The memory that a placement needs exists only during the batches that it reaches into.
    FieldPlanes(const std::vector<std::vector<ViewField>>& placements, const Settings& settings, const Dials& dials,
                const Sheets& sheets, const Lattice& lattice, int batchSheets);
    ~FieldPlanes();

    /// Begins the batch [firstSheet, firstSheet + count), which must follow the batch before if
    /// sheets beside batches are kept. It is splatted in consecutive phases, each of independent
    /// tasks; then all planes are finished, independently of one another.
    void beginBatch(int firstSheet, int count);
    static constexpr int kPhases = 2;
    int tasks(int phase) const { return static_cast<int>(m_tasks[std::size_t(phase)].size()); }
    /// Runs one task. Returns the footprints that were added. Blocks that touch none of the tiles
    /// in `needed` are culled, and so are those that `cull` rejects.
    std::uint64_t splat(int phase, int task, const NeededTiles* needed, const TileCull& cull);
    int planesToFinish() const { return m_readySheet - m_firstReady; }
    void finish(int plane);

    /// The plane of a sheet of the batch or beside it. Planes form a ring, so that every sheet is splatted only once.
    int planeOf(int sheet) const { return (sheet - m_origin + m_settings.before) % planes().planes(); }
    /// Planes [0, count) are those of the batch if the settings ask for no sheets beside it.
    const PlaneStack& planes(std::size_t field = 0) const { return m_planes[field]; }
    /// See PlaneStack::countFrom; 0 while a batch is splatted.
    void countFrom(int first) {
        for (PlaneStack& planes : m_planes) planes.countFrom(first);
    }

    std::size_t bytes() const;
    /// Upper bound on the bytes, known beforehand; `placements`: the first field of each.
    static std::size_t bytes(const std::vector<ViewField>& placements, const Settings& settings, const Dials& dials,
                             const Sheets& sheets, const Lattice& lattice, int batchSheets);

  private:
    struct Placement;
    void place(std::vector<ViewField> fields, std::vector<const float*> values = {});
    void placeTiles(const ViewField& field);
    void makeSplatter(Placement& placement) const;
    void prepare();
    void listTasks();
    int bands() const;

    const Lattice& m_lattice;
    const Sheets& m_sheets;
    const Dials& m_dials;
    Settings m_settings;
    Simd m_simd;
    std::vector<TileLevels> m_tiles;  // for the placements that have large tiles
    std::vector<Placement> m_placements;
    int m_bandTiles = 0;                     // height of the bands at which all splatters take turns
    std::size_t m_mostBytes = 0;             // largest bytes of splatters in any batch
    std::vector<PlaneStack> m_planes;        // one for each field
    int m_origin = -1;                       // first sheet of the first batch, which starts the ring of planes
    int m_firstReady = 0, m_readySheet = 0;  // sheets that the batch splats
    // The sheets [begin, end) that one task splats, and its band of rows.
    struct Task {
        int begin, end, band;
    };
    std::array<std::vector<Task>, kPhases> m_tasks;  // those in which there is something
};

}  // namespace scrim
