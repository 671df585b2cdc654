// SPDX-License-Identifier: Apache-2.0
// Slides made in code, and lights that shine through them.
#pragma once

#include <scrim/scene/slide_map.h>

#include <functional>
#include <memory>

#include <glm/geometric.hpp>

namespace scrim::test {

/// A picture of `width` x `height` pixels with colour(x, y), x to the right and y down.
inline std::shared_ptr<const Texture> makeTexture(int width, int height,
                                                  const std::function<Rgb(int x, int y)>& colour) {
    Image image = emptyImage({0, 0, width, height});
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Rgb rgb = colour(x, y);
            float* pixel = image.rgba.data() + image.indexOf(x, y);
            for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(rgb[c]);
            pixel[3] = 1;
        }
    return std::make_shared<Texture>(image);
}

/// Four quarters: red and green above, blue and white below.
inline std::shared_ptr<const Texture> quarters(int edge = 64) {
    return makeTexture(edge, edge, [edge](int x, int y) {
        const bool right = 2 * x >= edge, below = 2 * y >= edge;
        return below ? (right ? Rgb(1) : Rgb(0, 0, 1)) : (right ? Rgb(0, 1, 0) : Rgb(1, 0, 0));
    });
}

/// A distant light through a slide of `width` world units whose centre is the origin.
inline Light distantSlide(const Vec3& direction, double width, std::shared_ptr<const Texture> image) {
    Light light;
    light.name = "slide";
    light.wsDirection = glm::normalize(direction);
    light.slide.emplace();
    light.slide->width = width;
    light.slide->image = std::move(image);
    return light;
}

/// A projector at `position` that looks at the origin, without decay.
inline Light projector(const Vec3& position, double fov, std::shared_ptr<const Texture> image) {
    Light light = distantSlide(-position, 1, std::move(image));
    light.kind = Light::Point{};
    light.wsPosition = position;
    light.point().decay = false;
    light.slide->fov = fov;
    return light;
}

}  // namespace scrim::test
