// SPDX-License-Identifier: Apache-2.0
// The picture in memory and the windows that place it. It is independent of any file format or
// colour library, so that renderers, tests and writers can share it without including those.
#pragma once

#include <scrim/geometry/box2.h>

#include <cstddef>
#include <functional>
#include <vector>

namespace scrim {

/// A half-open box of pixels. The display window starts at (0, 0); a data window may begin at
/// negative coordinates (overscan).
using PixelWindow = Box2<int>;

/// Premultiplied scene-linear RGBA: 4 floats per pixel, rows from top to bottom. `rgba` holds
/// exactly 4 * window.pixelCount() floats.
struct Image {
    PixelWindow window;
    std::vector<float> rgba;

    /// Index into `rgba` of the red of pixel (x, y), which must lie in the window.
    std::size_t indexOf(int x, int y) const {
        return 4 * (std::size_t(y - window.y0) * std::size_t(window.width()) + std::size_t(x - window.x0));
    }
};

/// Called now and then during a render with a function that returns the picture so far; calling
/// that function takes time. It is called from a thread of the render, never from two at once.
using PictureSink = std::function<void(const std::function<Image()>& soFar)>;

/// An image of `window` with 0 in all channels.
Image emptyImage(const PixelWindow& window);

/// The part of `image` inside of `window`, with 0 where `window` extends beyond it.
Image reframed(const Image& image, const PixelWindow& window);

/// The smallest window around all pixels with any channel other than 0 (a NaN is not 0). If there are none, it is the
/// one pixel at the corner (x0, y0) of the image's own window, since EXR cannot express "nothing".
PixelWindow nonEmptyWindow(const Image& image);

}  // namespace scrim
