// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/grid_choice.h>

#include <array>
#include <charconv>
#include <string_view>

#include <fmt/format.h>

namespace scrim {

namespace {

constexpr std::size_t kNameLimit = 80;  ///< bytes of a name in a message

/// The number of grids that share the name of grid i: those before `i`, and all.
std::pair<std::size_t, std::size_t> placeAmongEqual(const std::vector<GridOffer>& offers, std::size_t i) {
    std::size_t before = 0;
    std::size_t all = 0;
    for (std::size_t j = 0; j < offers.size(); ++j) {
        if (offers[j].name != offers[i].name) continue;
        ++all;
        if (j < i) ++before;
    }
    return {before, all};
}

/// Splits "name[i]" into name and i; returns false for text of another form.
bool splitIndex(const std::string& text, std::string& name, std::size_t& index) {
    const std::size_t open = text.rfind('[');
    if (open == std::string::npos || text.back() != ']') return false;
    const char* begin = text.data() + open + 1;
    const char* end = text.data() + text.size() - 1;
    const auto [stop, error] = std::from_chars(begin, end, index);
    if (error != std::errc() || stop != end) return false;
    name = text.substr(0, open);
    return true;
}

/// The grid called `wanted`, or "name[i]", for which `fits` holds.
template <typename Fits>
std::optional<std::size_t> named(const std::vector<GridOffer>& offers, const std::string& wanted, const Fits& fits) {
    for (std::size_t i = 0; i < offers.size(); ++i)
        if (offers[i].name == wanted && fits(offers[i])) return i;
    std::string name;
    std::size_t index = 0;
    if (!splitIndex(wanted, name, index)) return {};
    for (std::size_t i = 0; i < offers.size(); ++i)
        if (offers[i].name == name && placeAmongEqual(offers, i).first == index && fits(offers[i])) return i;
    return {};
}

bool anyGrid(const GridOffer&) {
    return true;
}
bool real(const GridOffer& offer) {
    return offer.isReal();
}
bool vector(const GridOffer& offer) {
    return offer.isVector();
}

std::optional<std::size_t> defaultGrid(const std::vector<GridOffer>& offers) {
    const auto first = [&](auto&& wanted) -> std::optional<std::size_t> {
        for (std::size_t i = 0; i < offers.size(); ++i)
            if (offers[i].isScalar() && wanted(offers[i])) return i;
        return {};
    };
    if (const auto i = first([](const GridOffer& g) { return g.name == "density"; })) return i;
    if (const auto i = first([](const GridOffer& g) { return g.isReal() && g.gridClass == "fog volume"; })) return i;
    if (const auto i = first([](const GridOffer& g) { return g.isReal() && g.gridClass != "level set"; })) return i;
    if (const auto i = first([](const GridOffer& g) { return g.isReal(); })) return i;
    if (const auto i = first(anyGrid)) return i;
    for (std::size_t i = 0; i < offers.size(); ++i)
        if (offers[i].isPoints()) return i;
    return {};
}

/// The component that a name such as "Cd.r" means, where no grid has that name.
std::optional<GridChoice> componentNamed(const std::vector<GridOffer>& offers, const std::string& name) {
    constexpr std::string_view kLetters = "xyzrgb";
    const std::size_t dot = name.rfind('.');
    if (dot == std::string::npos || dot + 2 != name.size()) return {};
    const std::size_t letter = kLetters.find(name[dot + 1]);
    const auto i = named(offers, name.substr(0, dot), vector);
    if (!i || letter == kLetters.npos) return {};
    return GridChoice{*i, static_cast<int>(letter % 3)};
}

std::optional<GridChoice> chooseColour(const std::vector<GridOffer>& offers, const GridRequest& request) {
    if (const auto i = named(offers, request.grid, vector)) return GridChoice{*i, request.component};
    for (const std::string_view letters : {"xyz", "rgb"}) {
        std::array<std::optional<std::size_t>, 3> parts;
        for (std::size_t c = 0; c < 3; ++c) parts[c] = named(offers, request.grid + "." + letters[c], real);
        if (parts[0] && parts[1] && parts[2]) return GridChoice{*parts[request.component]};
    }
    const bool mayBeGrey = request.part == GridPart::whole;
    if (const auto i = named(offers, request.grid, real); i && mayBeGrey) return GridChoice{*i};
    return {};
}

}  // namespace

bool GridOffer::isReal() const {
    return type == kFloat || type == "Tree_double_5_4_3";
}

bool GridOffer::isScalar() const {
    return isReal() || type == "Tree_int32_5_4_3" || type == "Tree_int64_5_4_3" || type == "Tree_bool_5_4_3" ||
           type == "Tree_mask_5_4_3";
}

bool GridOffer::isVector() const {
    return type == "Tree_vec3s_5_4_3" || type == "Tree_vec3d_5_4_3";
}

bool GridOffer::isPoints() const {
    return type == kPoints;
}

std::string GridOffer::valueType() const {
    // The word stands between "Tree_" and the logarithms of the node sizes.
    constexpr std::string_view kPrefix = "Tree_";
    if (!type.starts_with(kPrefix)) return type;
    std::string word = type.substr(kPrefix.size());
    const std::size_t end = word.find_last_not_of("_0123456789");
    // The word's own digits stand before the first separator.
    if (end != std::string::npos) word.resize(std::min(word.size(), word.find('_', end)));
    return word;
}

std::vector<GridOffer> offersOf(const VdbLayout& layout) {
    std::vector<GridOffer> offers;
    for (const VdbLayout::Grid& grid : layout.grids) offers.push_back({grid.name, grid.type, grid.gridClass});
    return offers;
}

std::optional<GridChoice> chooseGrid(const std::vector<GridOffer>& offers, const GridRequest& request) {
    if (request.component != GridRequest::kScalar) return chooseColour(offers, request);
    const auto i = request.grid.empty() ? defaultGrid(offers) : named(offers, request.grid, anyGrid);
    if (!i) return componentNamed(offers, request.grid);
    const bool isDensity = offers[*i].isPoints() && request.part == GridPart::whole;
    if (!offers[*i].isScalar() && !isDensity) return {};
    return GridChoice{*i};
}

std::string callName(const std::vector<GridOffer>& offers, std::size_t i) {
    const std::string& name = offers[i].name;
    const auto [before, all] = placeAmongEqual(offers, i);
    return all == 1 && !name.empty() ? name : fmt::format("{}[{}]", name, before);
}

std::optional<std::size_t> chooseNamed(const std::vector<GridOffer>& offers, const std::string& name) {
    return named(offers, name, anyGrid);
}

namespace {

/// OpenVDB 13 can keep trees of halves. What earlier versions call half is a float grid that is saved as half.
const char* adviceOnHalf(const GridOffer& offer) {
    return offer.valueType() == "half" ? "; half grids of OpenVDB 13 are not read, save it as a float grid (in half "
                                         "precision, if you like)"
                                       : "";
}

}  // namespace

std::string whyNoGrid(const std::vector<GridOffer>& offers, const GridRequest& request) {
    const bool colour = request.component != GridRequest::kScalar;
    const std::string name = shortened(request.grid, kNameLimit);
    if (!colour && request.grid.empty())
        return offers.empty() ? "holds no grids"
                              : "holds no scalar grid, only " + listOf(offers) + adviceOnHalf(offers[0]);
    const auto found = named(offers, request.grid, anyGrid);
    if (!found) return fmt::format("no grid '{}'; it holds {}", name, listOf(offers));
    const std::string held = shortened(offers[*found].valueType(), kNameLimit);
    if (colour && request.part != GridPart::whole)
        return fmt::format(
            "grid '{0}' holds {1} values, where a velocity is expected: a vec3 grid, or three scalar ones called "
            "'{0}.x', '{0}.y', '{0}.z'; there is {2}",
            name, held, listOf(offers));
    if (colour)
        return fmt::format(
            "grid '{0}' holds {1} values, where a colour is expected: a vec3 grid, three scalar ones "
            "called '{0}.x', '{0}.y', '{0}.z' or '{0}.r', '{0}.g', '{0}.b', or a scalar one, which is grey; "
            "there is {2}",
            name, held, listOf(offers));
    if (offers[*found].isVector())
        return fmt::format(
            "grid '{0}' holds {1} values, where a scalar grid is expected: '{0}.x', '{0}.y' and '{0}.z' "
            "are its components; there is {2}",
            name, held, listOf(offers));
    return fmt::format("grid '{}' holds {} values, where a scalar grid is expected; of those there is {}{}", name, held,
                       choices(scalarNames(offers)), adviceOnHalf(offers[*found]));
}

std::string listOf(const std::vector<GridOffer>& offers) {
    std::string list;
    for (std::size_t i = 0; i < offers.size(); ++i)
        list += fmt::format("{}'{}' ({})", i == 0 ? "" : ", ", shortened(callName(offers, i), kNameLimit),
                            shortened(offers[i].valueType(), kNameLimit));
    return offers.empty() ? "none" : list;
}

std::vector<std::string> scalarNames(const std::vector<GridOffer>& offers) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < offers.size(); ++i)
        if (offers[i].isScalar() || offers[i].isPoints()) names.push_back(callName(offers, i));
    return names;
}

}  // namespace scrim
