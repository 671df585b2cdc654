// SPDX-License-Identifier: Apache-2.0
// Internal: the points of a file, and what requests mean among them. Points are a density by the
// name of their grid, and each of their attributes is a grid by its own name or "GRID.NAME".
#pragma once

#include <scrim/volume/grid_choice.h>
#include <scrim/volume/point_raster.h>

#include <compare>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <openvdb/openvdb.h>

namespace scrim {

class PointSet {
  public:
    /// Messages about the points, which are kept until somebody can hear them.
    using Notes = std::vector<std::pair<Severity, std::string>>;

    /// The points of offer `place`, as voxels. `path` starts every message. Throws Error.
    /// `listed`: lists of the points are among what is wanted.
    void add(std::size_t place, PointCloud cloud, const PointLook& look, const std::string& path, bool listed,
             Notes& notes);
    bool empty() const { return m_rasters.empty(); }

    /// The fields of those of the requests that mean points; values lie in `memory`.
    std::map<GridRequest, SparseField> fields(const std::vector<GridOffer>& offers,
                                              const std::set<GridRequest>& requests, BlockMemory& memory) const;

    /// The same as whole grids, each once. `place` is that of the points for a density, and none for an attribute.
    struct Made {
        std::optional<std::size_t> place;
        openvdb::GridBase::Ptr grid;
    };
    std::vector<Made> grids(const std::vector<GridOffer>& offers, const std::set<GridRequest>& requests) const;

  private:
    /// What a request means.
    struct Use {
        std::size_t place = 0;
        std::string attribute;  ///< "": the density
        bool swept = false;
        std::string name;  ///< of the grid
        auto operator<=>(const Use&) const = default;
    };
    SparseField list(const std::vector<GridOffer>& offers, const GridRequest& request, BlockMemory& memory) const;
    std::optional<std::pair<Use, int>> useOf(const std::vector<GridOffer>& offers, const GridRequest& request) const;
    PointBlocks blocksOf(const Use& use) const;

    std::map<std::size_t, PointRaster> m_rasters;  ///< by the offers' places
    PointLook m_look;
};

/// True if one of the requests is for a list of points.
bool wantsLists(const std::set<GridRequest>& requests);

/// True if one of the requests may mean the attribute called `name`.
bool mayMean(const std::set<GridRequest>& requests, const std::string& name);

}  // namespace scrim
