// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/parallel.h>
#include <scrim/engine/light/solid_shadow.h>
#include <scrim/geometry/even_points.h>
#include <scrim/verify/reference.h>
#include <scrim/verify/verify.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

// What arrives of a light at the solids of a pixel, as a mean over its rays, of which some may show none.
Rgb caughtInPixel(const ViewScene& scene, const Reference& reference, std::size_t light, int x, int y) {
    const int n = scene.dials.antialias;
    const RayFamily rays = wsRays(supersampled(scene.camera, n));
    Rgb sum(0);
    for (int i = 0; i < n * n; ++i) {
        const auto ws = caughtAt(*scene.solids, rays, x * n + i % n + 0.5, y * n + i / n + 0.5);
        sum += ws ? reference.arriving(light, *ws) : Rgb(1);
    }
    return sum / double(n * n);
}

}  // namespace

CaughtDifference differenceOfCaught(const ViewScene& truth, const Frame& frame, int pixels) {
    CaughtDifference out;
    std::vector<const FrameLayer*> layers;
    for (const FrameLayer& layer : frame.layers)
        if (layer.layer == Layer::shadow) layers.push_back(&layer);
    if (layers.empty() || !truth.solids || !truth.solids->any(SolidRole::catcher)) return out;
    const Reference reference(truth);
    const RayFamily rays = wsRays(truth.camera);
    const PixelWindow& region = truth.region;
    constexpr int kMost = 2000, kTries = 20;  // tries for each pixel, since most may show no such solid
    const int wanted = std::min(pixels, kMost);
    std::vector<Int2> found;
    for (int i = 0; i < kTries * wanted && static_cast<int>(found.size()) < wanted; ++i) {
        // M. Roberts' R2 sequence
        const Vec2 at = evenPoint(i);
        const Int2 pixel(region.x0 + static_cast<int>(at.x * region.width()),
                         region.y0 + static_cast<int>(at.y * region.height()));
        if (caughtAt(*truth.solids, rays, pixel.x + 0.5, pixel.y + 0.5)) found.push_back(pixel);
    }
    std::vector<Rgb> off(found.size() * layers.size());
    parallelFor(off.size(), [&](std::size_t i) {
        const FrameLayer& layer = *layers[i % layers.size()];
        const Int2 pixel = found[i / layers.size()], at = pixel - Int2(region.x0, region.y0);
        const float* value =
            layer.data.data() + 3 * (std::size_t(at.y) * std::size_t(region.width()) + std::size_t(at.x));
        off[i] = Rgb(value[0], value[1], value[2]) -
                 caughtInPixel(truth, reference, static_cast<std::size_t>(layer.light), pixel.x, pixel.y);
    });
    double squares = 0;
    for (const Rgb& difference : off) {
        squares += glm::dot(difference, difference);
        out.worst = std::max(out.worst, largest(glm::abs(difference)));
    }
    out.values = 3 * static_cast<int>(off.size());
    if (out.values > 0) out.rms = std::sqrt(squares / out.values);
    return out;
}

}  // namespace scrim
