// SPDX-License-Identifier: Apache-2.0
// Which grid of a file, or of a volume source, a request means. Needs names and types only, so that grids can
// be chosen before any of them is read.
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
    std::string gridClass{};    ///< "fog volume", "level set", "staggered", else anything

    static constexpr const char* kFloat = "Tree_float_5_4_3";

    bool isScalar() const;          ///< float (also saved as half) or double
    bool isVector() const;          ///< three of those
    std::string valueType() const;  ///< OpenVDB's word for what it holds: "float", "vec3s", "int32", ...
};

/// All grids of a file whose layout is known.
std::vector<GridOffer> offersOf(const VdbLayout& layout);

/// What a request means.
struct GridChoice {
    std::size_t grid = 0;                  ///< the place of the offer
    int component = GridRequest::kScalar;  ///< of a vec3 grid, else kScalar
};

/// What `request` means among `offers`; none where they do not have it.
///
/// Of a scalar `grid` is the name, or "name[i]" for the i-th (from 0) of that name; "" stands for the one called
/// "density", else the first fog volume, else the first that is not a level set, else the first. Of a colour see
/// GridRequest; "name[i]" is understood there, too.
std::optional<GridChoice> chooseGrid(const std::vector<GridOffer>& offers, const GridRequest& request);

/// Why `chooseGrid` finds nothing: what is there and what was expected.
std::string whyNoGrid(const std::vector<GridOffer>& offers, const GridRequest& request);

/// The names by which requests find the scalar grids: "density", or "density[0]", "density[1]" where a name is not
/// unique, or "[0]" for one without a name.
std::vector<std::string> scalarNames(const std::vector<GridOffer>& offers);

}  // namespace scrim
