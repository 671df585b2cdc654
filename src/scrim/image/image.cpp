// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/image.h>

#include <algorithm>

namespace scrim {

Image emptyImage(const PixelWindow& window) {
    return {window, std::vector<float>(4 * window.pixelCount(), 0.0f)};
}

Image reframed(const Image& image, const PixelWindow& window) {
    Image out = emptyImage(window);
    const PixelWindow common = intersection(image.window, window);
    if (common.empty()) return out;
    const std::size_t rowFloats = 4 * std::size_t(common.width());
    for (int y = common.y0; y < common.y1; ++y)
        std::copy_n(image.rgba.data() + image.indexOf(common.x0, y), rowFloats,
                    out.rgba.data() + out.indexOf(common.x0, y));
    return out;
}

PixelWindow nonEmptyWindow(const Image& image) {
    const PixelWindow& window = image.window;
    PixelWindow found{window.x1, window.y1, window.x0, window.y0};
    for (int y = window.y0; y < window.y1; ++y) {
        const float* row = image.rgba.data() + image.indexOf(window.x0, y);
        const auto used = [row, &window](int x) {
            const float* p = row + 4 * std::size_t(x - window.x0);
            return p[0] != 0 || p[1] != 0 || p[2] != 0 || p[3] != 0;
        };
        int left = window.x0;
        while (left < window.x1 && !used(left)) ++left;
        if (left == window.x1) continue;
        int right = window.x1;
        while (!used(right - 1)) --right;
        found.x0 = std::min(found.x0, left);
        found.x1 = std::max(found.x1, right);
        found.y0 = std::min(found.y0, y);
        found.y1 = y + 1;
    }
    if (found.empty()) return {window.x0, window.y0, window.x0 + 1, window.y0 + 1};
    return found;
}

}  // namespace scrim
