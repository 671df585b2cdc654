// SPDX-License-Identifier: Apache-2.0
// Square blocks of eye rays, of which the even parts are interpolated: what arrives at solids is
// expensive, and mostly as smooth as the volumes.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/base/parallel.h>
#include <scrim/geometry/spaces.h>
#include <scrim/image/image.h>

#include <algorithm>
#include <cstddef>

namespace scrim {

/// Calls visit(first ray) for blocks of `edge` x `edge` rays that cover `rays`, in parallel by rows
/// that are `row` rays high, a whole number of blocks. Blocks lie on one raster over the plane, so
/// that a crop has those of the whole picture. Calls `checkpoint` now and then.
template <class Visit>
void forRayBlocks(const PixelWindow& rays, int edge, int row, const Checkpoint& checkpoint, const Visit& visit) {
    const auto down = [](int a, int b) { return (a >= 0 ? a / b : -((b - 1 - a) / b)) * b; };
    const int top = down(rays.y0, row), left = down(rays.x0, edge);
    const auto rows = static_cast<std::size_t>((rays.y1 - top + row - 1) / row);
    const auto visitRow = [&](int from) {
        for (int y = from; y < std::min(from + row, rays.y1); y += edge)
            for (int x = left; x < rays.x1; x += edge) visit(Int2(x, y));
    };
    constexpr std::size_t kRows = 8;  // between two checkpoints
    for (std::size_t first = 0; first < rows; first += kRows) {
        checkpoint();
        parallelFor(std::min(kRows, rows - first),
                    [&](std::size_t r) { visitRow(top + row * static_cast<int>(first + r)); });
    }
}

/// A place in a square, of whose corners something is known.
struct InSquare {
    double u = 0, v = 0;

    Rgb between(const Rgb& a, const Rgb& b, const Rgb& c, const Rgb& d) const {
        return (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d);
    }
};

/// Calls set(ray, place, a, b, c, d) for the rays [0, edge)^2 of a block from `from` on: its place
/// in a square, and valueAt(ray) of the square's corners, which are rays in [0, edge]^2. Squares
/// for which isEven(from, edge) does not hold are divided, down to single rays, all of whose
/// corners are the ray itself. Rays that has(ray) does not hold for are left out.
template <class Has, class IsEven, class ValueAt, class Set>
void fillRays(const Int2& from, int edge, const Has& has, const IsEven& isEven, const ValueAt& valueAt,
              const Set& set) {
    if (edge == 1) {
        if (!has(from)) return;
        const auto& own = valueAt(from);
        return set(from, InSquare{}, own, own, own, own);
    }
    if (!isEven(from, edge)) {
        for (int i = 0; i < 4; ++i)
            fillRays(from + edge / 2 * Int2(i & 1, i >> 1), edge / 2, has, isEven, valueAt, set);
        return;
    }
    const auto &a = valueAt(from), &b = valueAt(from + Int2(edge, 0));
    const auto &c = valueAt(from + Int2(0, edge)), &d = valueAt(from + edge);
    for (int y = 0; y < edge; ++y)
        for (int x = 0; x < edge; ++x) set(from + Int2(x, y), InSquare{double(x) / edge, double(y) / edge}, a, b, c, d);
}

}  // namespace scrim
