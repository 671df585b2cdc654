// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/passes/sharpen.h>

#include <array>
#include <vector>

#include <glm/common.hpp>

namespace scrim {

void sharpenAround(const Vec3& wsSource, bool steep, CellField& light) {
    constexpr std::array<int, 3> kStep{1, kPaddedEdge, kPaddedEdge * kPaddedEdge};
    const CellGrid& grid = light.grid();
    const std::size_t colours = light.colours();
    const Vec3 source = grid.csFromWs(wsSource) - 0.5;
    parallelFor(grid.storedBlocks().size(), [&](std::size_t b) {
        const Int3& own = grid.storedBlocks()[b];
        Real* values = light.block(b);
        const std::vector<Real> before(values, values + kPaddedCells * colours);
        for (int i = 0; i < static_cast<int>(kPaddedCells); ++i) {
            const Int3 place = paddedCell(i), cell = own * kCellEdge - 1 + place;
            if (cell >> 3 != own && grid.stored(cell >> 3) >= 0) continue;
            const Vec3 way = glm::abs(Vec3(cell) - source);
            const int main = axisOfLargest(way);
            for (std::size_t c = 0; c < colours; ++c) {
                const auto at = [&](int k) { return before[std::size_t(k) * colours + c]; };
                Sharpened sharp(at(i), steep);
                for (int axis = 0; axis < 3; ++axis) {
                    if (place[axis] == 0 || place[axis] == kPaddedEdge - 1) continue;
                    const int step = kStep[std::size_t(axis)];
                    sharp.along(axis == main ? kBendAlong : kBendAcross, at(i - step), at(i + step));
                }
                values[std::size_t(i) * colours + c] = sharp.light();
            }
        }
    });
    light.fillAround();
}

}  // namespace scrim
