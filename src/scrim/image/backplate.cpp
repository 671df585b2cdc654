// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/backplate.h>

#include <algorithm>
#include <cmath>

namespace scrim {
namespace {

// Two neighbouring pixels along an axis and the weight of the second, at the middle of pixel `i` of `count`.
struct Between {
    int first, second;
    float part;
};
Between between(int i, int count, int pixels) {
    const double at = (i + 0.5) * pixels / count - 0.5, whole = std::floor(at);
    const auto inside = [&](double x) { return std::clamp(static_cast<int>(x), 0, pixels - 1); };
    return {inside(whole), inside(whole + 1), static_cast<float>(at - whole)};
}

}  // namespace

Image overPlate(const Image& image, const Texture& plate, const PixelWindow& window) {
    Image out = reframed(image, window);
    // The largest level that is no finer than the window's pixels.
    std::size_t level = 0;
    while (level + 1 < plate.levels().size() && plate.levels()[level + 1].width >= window.width()) ++level;
    const Texture::Level& from = plate.levels()[level];
    float* rgba = out.rgba.data();
    for (int y = 0; y < window.height(); ++y) {
        const Between v = between(y, window.height(), from.height);
        for (int x = 0; x < window.width(); ++x, rgba += 4) {
            const Between u = between(x, window.width(), from.width);
            const float through = 1 - rgba[3];
            for (int c = 0; c < 4; ++c) {
                const float top =
                    (1 - u.part) * from.pixel(u.first, v.first)[c] + u.part * from.pixel(u.second, v.first)[c];
                const float bottom =
                    (1 - u.part) * from.pixel(u.first, v.second)[c] + u.part * from.pixel(u.second, v.second)[c];
                rgba[c] += through * ((1 - v.part) * top + v.part * bottom);
            }
        }
    }
    return out;
}

}  // namespace scrim
