// SPDX-License-Identifier: Apache-2.0
#include <scrim/render/renderer.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/base/simd.h>
#include <scrim/render/sweep.h>

#include <algorithm>

namespace scrim {
namespace {

// Adds a sweep's radiance to the picture, and its share in how much is left of what lies behind. Every pixel is the
// mean of its n x n rays.
void gather(const ImageTiles& tiles, int n, const EyePart& part, double primary, Image& image) {
    const PixelWindow& window = part.window;
    const auto inverse = 1.0 / (n * n);
    parallelFor(static_cast<std::size_t>(window.height()), [&](std::size_t row) {
        const int y = window.y0 + static_cast<int>(row);
        for (int x = window.x0; x < window.x1; ++x) {
            float sum[4] = {0, 0, 0, 0};
            for (int j = 0; j < n; ++j)
                for (int i = 0; i < n; ++i) {
                    const float* state = tiles.state(x * n + i, y * n + j);
                    for (int c = 0; c < 3; ++c) sum[c] += state[c];
                    sum[3] -= state[3];
                }
            const double weight = inverse * part.weight(x + 0.5, y + 0.5);
            float* pixel = image.rgba.data() + image.indexOf(x, y);
            // Interpolation between texels rounds: what is nothing may come out a hair below, and opaque above.
            for (int c = 0; c < 3; ++c) pixel[c] += static_cast<float>(weight) * std::max(sum[c], 0.0f);
            pixel[3] = std::clamp(pixel[3] + static_cast<float>(weight * primary) * sum[3], 0.0f, 1.0f);
        }
    });
}

}  // namespace

Frame render(const ViewScene& scene, const Plan& plan, const ProgressSink& progress) {
    Frame frame;
    frame.image = emptyImage(scene.region);
    if (plan.groups.empty()) return frame;

    limitSimd(scene.dials.simd);
    const int n = scene.dials.antialias;
    const Camera camera = supersampled(scene.camera, n);
    for (std::size_t g = 0; g < plan.groups.size(); ++g) {
        const GroupPlan& group = plan.groups[g];
        const EyePart& part = plan.eyeParts[group.eyePart];
        ImageTiles tiles(supersampled(part.window, n));
        runSweep(scene, camera, plan, group, tiles, frame.work, frame.times, [&](double done) {
            const double all = (static_cast<double>(g) + done) / static_cast<double>(plan.groups.size());
            if (progress && !progress(all)) throw Error(ErrorKind::interrupted, "the render was interrupted");
        });
        gather(tiles, n, part, group.primary, frame.image);
    }
    return frame;
}

}  // namespace scrim
