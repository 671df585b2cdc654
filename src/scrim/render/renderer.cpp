// SPDX-License-Identifier: Apache-2.0
#include <scrim/render/renderer.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/base/simd.h>
#include <scrim/render/sweep.h>

namespace scrim {
namespace {

// Adds a sweep's radiance to the picture; the primary one also states how much is left of what lies behind.
// Every pixel is the mean of its n x n rays.
void gather(const ImageTiles& tiles, int n, bool primary, Image& image) {
    const PixelWindow& window = image.window;
    const float weight = 1.0f / static_cast<float>(n * n);
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
            float* pixel = image.rgba.data() + image.indexOf(x, y);
            for (int c = 0; c < 3; ++c) pixel[c] += weight * sum[c];
            if (primary) pixel[3] = weight * sum[3];
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
    ImageTiles tiles(plan.region);
    for (std::size_t g = 0; g < plan.groups.size(); ++g) {
        const GroupPlan& group = plan.groups[g];
        if (g > 0) tiles.reset();
        runSweep(scene, camera, plan, group, tiles, frame.work, frame.times, [&](double part) {
            const double done = (static_cast<double>(g) + part) / static_cast<double>(plan.groups.size());
            if (progress && !progress(done)) throw Error(ErrorKind::interrupted, "the render was interrupted");
        });
        gather(tiles, n, group.primary, frame.image);
    }
    return frame;
}

}  // namespace scrim
