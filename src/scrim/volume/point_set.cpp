// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/point_set.h>

#include <scrim/volume/point_grid.h>

#include <algorithm>
#include <string_view>

namespace scrim {
namespace {

constexpr std::string_view kLetters = "xyzrgb";

/// The name without ".x" to ".z" or ".r" to ".b" at its end, and the component that this means; kScalar without one.
std::pair<std::string, int> withoutComponent(const std::string& name) {
    const std::size_t dot = name.rfind('.');
    if (dot == std::string::npos || dot + 2 != name.size()) return {name, GridRequest::kScalar};
    const std::size_t letter = kLetters.find(name[dot + 1]);
    if (letter == kLetters.npos) return {name, GridRequest::kScalar};
    return {name.substr(0, dot), static_cast<int>(letter % 3)};
}

}  // namespace

bool mayMean(const std::set<GridRequest>& requests, const std::string& name) {
    return std::any_of(requests.begin(), requests.end(), [&](const GridRequest& request) {
        for (const std::string& wanted : {request.grid, withoutComponent(request.grid).first})
            if (wanted == name || wanted.ends_with("." + name)) return true;
        return false;
    });
}

bool wantsLists(const std::set<GridRequest>& requests) {
    return std::any_of(requests.begin(), requests.end(), [](const GridRequest& r) { return isList(r.part); });
}

void PointSet::add(std::size_t place, PointCloud cloud, const PointLook& look, const std::string& path, bool listed,
                   Notes& notes) {
    m_look = look;
    m_rasters.try_emplace(
        place, std::move(cloud), look, path,
        [&](Severity severity, const std::string& text) { notes.emplace_back(severity, text); }, listed);
}

std::optional<std::pair<PointSet::Use, int>> PointSet::useOf(const std::vector<GridOffer>& offers,
                                                             const GridRequest& request) const {
    if (const auto choice = chooseGrid(offers, request)) {
        if (!m_rasters.contains(choice->grid)) return {};  // it is no grid of points
        return std::pair(Use{choice->grid, "", false, callName(offers, choice->grid)}, 0);
    }
    const bool isPart = request.part != GridPart::whole;
    for (const auto& [place, raster] : m_rasters)
        for (const PointAttribute& attribute : raster.cloud().attributes) {
            const auto isMeant = [&](const std::string& name) {
                return name == attribute.name || name == offers[place].name + "." + attribute.name;
            };
            const auto [base, component] = withoutComponent(request.grid);
            Use use{place, attribute.name, isPart && m_look.open < m_look.close, request.grid};
            if (isMeant(request.grid)) {
                if (attribute.width == 1 && (request.component == GridRequest::kScalar || !isPart))
                    return std::pair(use, 0);
                if (attribute.width == 3 && request.component != GridRequest::kScalar)
                    return std::pair(use, request.component);
            }
            if (isMeant(base) && attribute.width == 3 && component != GridRequest::kScalar &&
                request.component == GridRequest::kScalar) {
                use.name = base;
                return std::pair(use, component);
            }
        }
    return {};
}

PointBlocks PointSet::blocksOf(const Use& use) const {
    const PointRaster& raster = m_rasters.at(use.place);
    if (!use.swept) return raster.blocks();
    const PointAttribute* const velocity = raster.cloud().attribute(use.attribute);
    return raster.blocksOnWay(velocity->width == 3 ? velocity : nullptr);
}

/// A list; empty where the request means no points.
SparseField PointSet::list(const std::vector<GridOffer>& offers, const GridRequest& request,
                           BlockMemory& memory) const {
    const bool places = request.part == GridPart::places;
    SparseField none;
    none.name = request.grid;
    const auto use = useOf(offers, withoutList(request));
    if (!use || (places && !use->first.attribute.empty())) return none;
    const PointRaster& raster = m_rasters.at(use->first.place);
    return raster.list({request.grid, request.part, places ? request.component : use->second,
                        raster.cloud().attribute(use->first.attribute)},
                       memory);
}

std::map<GridRequest, SparseField> PointSet::fields(const std::vector<GridOffer>& offers,
                                                    const std::set<GridRequest>& requests, BlockMemory& memory) const {
    struct Asked {
        std::vector<GridRequest> requests;
        std::vector<PointRaster::Wanted> wanted;
    };
    std::map<Use, Asked> uses;
    std::map<GridRequest, SparseField> out;
    for (const GridRequest& request : requests)
        if (isList(request.part)) {
            out.emplace(request, list(offers, request, memory));
        } else if (const auto use = useOf(offers, request)) {
            Asked& asked = uses[use->first];
            asked.requests.push_back(request);
            asked.wanted.push_back({request.grid.empty() ? use->first.name : request.grid, use->second, request.part});
        }
    for (const auto& [use, asked] : uses) {
        const PointRaster& raster = m_rasters.at(use.place);
        std::vector<SparseField> fields =
            raster.fields(blocksOf(use), raster.cloud().attribute(use.attribute), asked.wanted, memory);
        for (std::size_t i = 0; i < fields.size(); ++i) out.emplace(asked.requests[i], std::move(fields[i]));
    }
    return out;
}

std::vector<PointSet::Made> PointSet::grids(const std::vector<GridOffer>& offers,
                                            const std::set<GridRequest>& requests) const {
    std::set<Use> uses;
    for (const GridRequest& request : requests)
        if (const auto use = useOf(offers, request)) uses.insert(use->first);
    std::vector<Made> out;
    for (const Use& use : uses) {
        // A velocity that is known on its way serves all else.
        Use wider = use;
        wider.swept = true;
        if (!use.swept && uses.contains(wider)) continue;
        const PointRaster& raster = m_rasters.at(use.place);
        const PointAttribute* const attribute = raster.cloud().attribute(use.attribute);
        out.push_back(
            {attribute == nullptr ? std::optional(use.place) : std::nullopt,
             gridOf(raster, blocksOf(use), attribute, attribute == nullptr ? offers[use.place].name : use.name)});
    }
    return out;
}

}  // namespace scrim
