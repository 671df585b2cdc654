// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/grid_request.h>

#include <fmt/format.h>

namespace scrim {

namespace {

constexpr const char* kScalarPrefix = "scalar:";

}  // namespace

std::string toText(const GridRequest& request) {
    const std::string sign = request.part == GridPart::whole ? "" : request.part == GridPart::positive ? "+" : "-";
    return sign + (request.component == GridRequest::kScalar ? kScalarPrefix + request.grid
                                                             : fmt::format("{}:{}", request.component, request.grid));
}

GridRequest gridRequestFrom(const std::string& text) {
    const std::size_t prefix = std::string(kScalarPrefix).size();
    const bool isSigned = text.starts_with('+') || text.starts_with('-');
    const GridPart part = !isSigned ? GridPart::whole : text[0] == '+' ? GridPart::positive : GridPart::negative;
    const std::string grid = isSigned ? text.substr(1) : text;
    if (grid.starts_with(kScalarPrefix)) return {grid.substr(prefix), GridRequest::kScalar, part};
    if (grid.size() >= 2 && grid[0] >= '0' && grid[0] <= '2' && grid[1] == ':')
        return {grid.substr(2), grid[0] - '0', part};
    throw Error(ErrorKind::usage, fmt::format("'{}' requests no grid; expected scalar:NAME, 0:NAME, 1:NAME or 2:NAME",
                                              shortened(text, 80)));
}

GridError::GridError(const std::string& message, GridRequest request)
    : Error(ErrorKind::input, message), m_request(std::move(request)) {}

}  // namespace scrim
