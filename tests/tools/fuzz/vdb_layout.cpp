// SPDX-License-Identifier: Apache-2.0
// Fuzz target: the outer structure of a .vdb, and where its grids are, is told for any bytes, or refused in one line.
// What is behind it belongs to OpenVDB, which is not safe on damaged files and is therefore kept in a process of its
// own: damaged_vdb_test.cpp.
#include "require.h"

#include <scrim/base/error.h>
#include <scrim/volume/vdb_bounds.h>
#include <scrim/volume/vdb_layout.h>

#include <cmath>
#include <cstdint>
#include <span>

namespace {

/// A box of numbers, or none.
void checkBounds(const std::uint8_t* data, std::size_t size, const scrim::GridRequest& request) {
    const scrim::VdbBytes bytes("fuzz.vdb", {reinterpret_cast<const char*>(data), size});
    const auto bounds = scrim::vdbBounds(bytes, {request});
    if (!bounds || bounds->empty()) return;
    for (int i = 0; i < 3; ++i)
        scrim::fuzz::require(std::isfinite(bounds->lower[i]) && std::isfinite(bounds->upper[i]), "bounds from {} to {}",
                             bounds->lower[i], bounds->upper[i]);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace scrim;
    using namespace scrim::fuzz;
    try {
        const VdbLayout layout = checkVdbLayout("fuzz.vdb", {reinterpret_cast<const char*>(data), size});
        std::size_t bytes = 0;
        for (const VdbLayout::Grid& grid : layout.grids) bytes += 1 + grid.name.size() + grid.type.size();
        for (const VdbLayout::Grid& grid : layout.grids) {
            require(grid.begin < grid.end && grid.end <= size, "a grid from {} to {}", grid.begin, grid.end);
            for (const int component : {GridRequest::kScalar, 1}) checkBounds(data, size, {grid.name, component});
        }
        require(bytes <= size, "{} grids with names of {} bytes in a file of {}", layout.grids.size(), bytes, size);
    } catch (const Error& error) {
        const std::string message = error.what();
        require(error.kind() == ErrorKind::input, "an error of kind {}: {}", int(error.kind()), message);
        require(message.starts_with("fuzz.vdb: "), "no place: {}", message);
        require(message.find('\n') == std::string::npos, "more than one line: {}", message);
        require(message.size() <= 1100, "a message of {} bytes", message.size());
    }
    return 0;
}
