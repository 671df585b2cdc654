// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/grid_request.h>

#include <fmt/format.h>

namespace scrim {

namespace {

constexpr const char* kScalarPrefix = "scalar:";

}  // namespace

std::string toText(const GridRequest& request) {
    return request.component == GridRequest::kScalar ? kScalarPrefix + request.grid
                                                     : fmt::format("{}:{}", request.component, request.grid);
}

GridRequest gridRequestFrom(const std::string& text) {
    const std::size_t prefix = std::string(kScalarPrefix).size();
    if (text.starts_with(kScalarPrefix)) return {text.substr(prefix)};
    if (text.size() >= 2 && text[0] >= '0' && text[0] <= '2' && text[1] == ':') return {text.substr(2), text[0] - '0'};
    throw Error(ErrorKind::usage, fmt::format("'{}' requests no grid; expected scalar:NAME, 0:NAME, 1:NAME or 2:NAME",
                                              shortened(text, 80)));
}

GridError::GridError(const std::string& message, GridRequest request)
    : Error(ErrorKind::input, message), m_request(std::move(request)) {}

}  // namespace scrim
