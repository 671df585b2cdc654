// SPDX-License-Identifier: Apache-2.0
// Finds the grid of a file, or of a volume source, that a request means. It uses names and types
// only, so that grids can be chosen before any of them is read.
#pragma once

#include <scrim/volume/grid_request.h>
#include <scrim/volume/vdb_layout.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// A grid that can be chosen.
struct GridOffer {
    std::string name;
    std::string type = kFloat;  ///< as OpenVDB writes it into files: "Tree_float_5_4_3"
    std::string gridClass{};    ///< "fog volume", "level set", "staggered", or anything else

    static constexpr const char* kFloat = "Tree_float_5_4_3";
    static constexpr const char* kPoints = "Tree_ptdataidx32_5_4_3";

    bool isReal() const;            ///< float (also if saved as half) or double
    bool isScalar() const;          ///< real, int32, int64, bool or mask (a mask is 1 in its voxels)
    bool isVector() const;          ///< vectors of three real numbers
    bool isPoints() const;          ///< points, which become a density
    std::string valueType() const;  ///< OpenVDB's word for the values: "float", "vec3s", "int32", ...
};

/// All grids of a file whose layout is known.
std::vector<GridOffer> offersOf(const VdbLayout& layout);

/// The grid that a request means.
struct GridChoice {
    std::size_t grid = 0;                  ///< index of the offer
    int component = GridRequest::kScalar;  ///< component of a vec3 grid, else kScalar
};

/// The grid that `request` means among `offers`; no value if there is none.
///
/// For a scalar, `grid` is the name, or "name[i]" for the i-th grid (from 0) of that name. "NAME.x" to "NAME.z" and
/// "NAME.r" to "NAME.b" stand for the components of a vec3 grid NAME where no grid has the whole name. "" stands for
/// the grid called "density", else the first fog volume, else the first grid that is not a level set, else the first
/// grid; real grids come before others, and points last. For a colour see GridRequest; it accepts "name[i]", too.
std::optional<GridChoice> chooseGrid(const std::vector<GridOffer>& offers, const GridRequest& request);

/// The grid of any type called `name`, or "name[i]"; no value if there is none.
std::optional<std::size_t> chooseNamed(const std::vector<GridOffer>& offers, const std::string& name);

/// The name by which a request finds grid `i`: "density", or "density[1]" where the name is not unique.
std::string callName(const std::vector<GridOffer>& offers, std::size_t i);

/// Why `chooseGrid` finds nothing: which grids there are and what was expected.
std::string whyNoGrid(const std::vector<GridOffer>& offers, const GridRequest& request);

/// "'density' (float), 'v' (vec3s)", or "none".
std::string listOf(const std::vector<GridOffer>& offers);

/// The names by which requests find the scalar grids: "density", or "density[0]", "density[1]"
/// where a name is not unique, or "[0]" for a grid without a name.
std::vector<std::string> scalarNames(const std::vector<GridOffer>& offers);

}  // namespace scrim
