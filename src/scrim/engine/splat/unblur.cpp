// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/unblur.h>

#include <algorithm>
#include <vector>

namespace scrim {
namespace {

constexpr float kTwelfth = 1.0f / 12;

// One tile's part of a row. `above` and `here` are the rows as they were, `below` is not yet changed.
void unblurSpan(const float* above, const float* here, const float* below, float* out) {
    for (int x = 0; x < kTileEdge; ++x) {
        const float around = here[x - 1] + here[x + 1] + above[x] + below[x];
        out[x] = std::max(0.0f, here[x] - kTwelfth * (around - 4 * here[x]));
    }
}

}  // namespace

void unblur(PlaneStack& planes, int p) {
    const int width = planes.width(), height = planes.height();
    // Rows as they were, with a zero on either side. The plane's own border is zeros and needs no treatment.
    const auto padded = static_cast<std::size_t>(width) + 2;
    std::vector<float> above(padded, 0.0f), here(padded, 0.0f);
    const std::vector<float> zeros(padded, 0.0f);
    for (int y = 0; y < height; ++y) {
        float* row = planes.plane(p) + static_cast<std::ptrdiff_t>(y) * planes.rowStride();
        std::copy_n(row, width, here.begin() + 1);
        const float* below = y + 1 < height ? row + planes.rowStride() : zeros.data();
        for (int tx = 0; tx < planes.tilesX(); ++tx) {
            if (!planes.active(p, tx, y / kTileEdge)) continue;
            const int x = tx * kTileEdge;
            unblurSpan(above.data() + 1 + x, here.data() + 1 + x, below + x, row + x);
        }
        std::swap(above, here);
    }
}

}  // namespace scrim
