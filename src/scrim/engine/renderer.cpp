// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/renderer.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/engine/composite/resolve.h>
#include <scrim/engine/sweep.h>

namespace scrim {
namespace {

Frame renderHere(const ViewScene& scene, const Plan& plan, const ProgressSink& progress) {
    Frame frame = emptyFrame(scene);
    const int n = scene.dials.antialias;
    const Camera camera = supersampled(scene.camera, n);
    for (std::size_t g = 0; g < plan.groups.size(); ++g) {
        const GroupPlan& group = plan.groups[g];
        const EyePart& part = plan.eyeParts[group.eyePart];
        ImageTiles tiles(supersampled(part.window, n), group.layout, group.targets.depth > 0);
        runSweep(scene, camera, plan, group, tiles, frame.work, frame.times, [&](double done) {
            const double all = (static_cast<double>(g) + done) / static_cast<double>(plan.groups.size());
            if (progress && !progress(all)) throw Error(ErrorKind::interrupted, "the render was interrupted");
        });
        gather(scene, plan, group, tiles, frame);
    }
    finishLayers(frame);
    return frame;
}

}  // namespace

Frame render(const ViewScene& scene, const Plan& plan, const ProgressSink& progress) {
    Frame frame;
    TaskArena(plan.threads).run([&] { frame = renderHere(scene, plan, progress); });
    return frame;
}

}  // namespace scrim
