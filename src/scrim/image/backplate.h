// SPDX-License-Identifier: Apache-2.0
// A picture in front of another one, for viewing.
#pragma once

#include <scrim/image/image.h>
#include <scrim/image/texture.h>

namespace scrim {

/// `image` (premultiplied) over `plate`, which is stretched to `window`: that window, opaque where the plate is.
Image overPlate(const Image& image, const Texture& plate, const PixelWindow& window);

}  // namespace scrim
