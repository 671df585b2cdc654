// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/grid_request.h>

#include <array>
#include <string_view>

#include <fmt/format.h>

namespace scrim {

namespace {

constexpr const char* kScalarPrefix = "scalar:";
constexpr std::array<std::string_view, 7> kSigns{"", "+", "-", "*", "@", "*+", "*-"};  // in the order of GridPart

}  // namespace

GridRequest withoutList(GridRequest request) {
    if (request.part == GridPart::places) request.component = GridRequest::kScalar;
    if (isList(request.part)) request.part = GridPart::whole;
    return request;
}

std::string toText(const GridRequest& request) {
    const std::size_t part = static_cast<std::size_t>(request.part);
    return std::string(kSigns.at(part)) + (request.component == GridRequest::kScalar
                                               ? kScalarPrefix + request.grid
                                               : fmt::format("{}:{}", request.component, request.grid));
}

GridRequest gridRequestFrom(const std::string& text) {
    const std::size_t prefix = std::string(kScalarPrefix).size();
    std::size_t sign = kSigns.size() - 1;
    while (!text.starts_with(kSigns[sign])) --sign;  // the first is empty
    const auto part = static_cast<GridPart>(sign);
    const std::string grid = text.substr(kSigns[sign].size());
    if (grid.starts_with(kScalarPrefix)) return {grid.substr(prefix), GridRequest::kScalar, part};
    if (grid.size() >= 2 && grid[0] >= '0' && grid[0] <= '2' && grid[1] == ':')
        return {grid.substr(2), grid[0] - '0', part};
    throw Error(ErrorKind::usage, fmt::format("'{}' requests no grid; expected scalar:NAME, 0:NAME, 1:NAME or 2:NAME",
                                              shortened(text, 80)));
}

GridError::GridError(const std::string& message, GridRequest request)
    : Error(ErrorKind::input, message), m_request(std::move(request)) {}

}  // namespace scrim
