// SPDX-License-Identifier: Apache-2.0
// A picture that can be looked up anywhere: a slide in front of a light. It holds the pixels and
// their averages over ever larger squares (a mip pyramid); interpolation is done by the code that
// looks them up (engine/light/sheet_light.h).
#pragma once

#include <scrim/base/messages.h>
#include <scrim/image/colour.h>
#include <scrim/image/image.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace scrim {

/// Immutable once built: may be read from any number of threads.
class Texture {
  public:
    /// `width` x `height` pixels of 4 floats (premultiplied RGBA in the working space), rows from top to bottom.
    struct Level {
        int width = 0, height = 0;
        std::vector<float> rgba;

        const float* pixel(int x, int y) const {
            return rgba.data() + 4 * (std::size_t(y) * std::size_t(width) + std::size_t(x));
        }
    };

    /// `image` is premultiplied, in the working space, and not empty. `pixelAspect` is a pixel's width over its height.
    explicit Texture(const Image& image, double pixelAspect = 1);

    int width() const { return m_levels.front().width; }
    int height() const { return m_levels.front().height; }
    /// Width over height of the picture as it is displayed.
    double aspect() const { return m_aspect; }

    /// Level 0 is the picture; each further level has half the pixels along each side, rounded up, down to one pixel. A
    /// pixel is the mean of the part of the preceding level that it covers, so every level has the picture's mean.
    const std::vector<Level>& levels() const { return m_levels; }
    std::size_t bytes() const;

  private:
    std::vector<Level> m_levels;
    double m_aspect;
};

/// Reads a picture in any format that OpenImageIO knows, rotated as its orientation tag says, over its full (display)
/// window. Grey becomes RGB, and colour is multiplied by alpha, so transparent pixels are black. `colorspace` is that
/// of the file; "": sRGB for integer pixels, the working space for floats. Values that are not finite or less than 0
/// become 0, with a warning. Throws Error(input) where the file is missing, damaged, not a picture, or too large.
std::shared_ptr<const Texture> readTexture(const std::string& path, const std::string& colorspace,
                                           const ColourConfig& colour, const MessageSink& messages);

}  // namespace scrim
