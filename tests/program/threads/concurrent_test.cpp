// SPDX-License-Identifier: Apache-2.0
// Renders side by side in one process, as a host application has them: unequal scenes, instruction sets and numbers of
// threads. Each must come out as it does alone. Also built with the thread sanitizer (tests/run.sh --threads).
#include "support/fields.h"

#include <scrim/base/parallel.h>
#include <scrim/verify/verify.h>

#include <tbb/global_control.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

namespace scrim::test {
namespace {

struct Job {
    ViewScene scene;
    int threads;
};

// A medium with two sweeps; a surface with gradients and a slide's look-ups; per-view splatting. All instruction sets.
std::vector<Job> jobs() {
    ViewScene smoke = orthographicScene(smokeField(14), {0.2, Rgb(0.9), {}}, 36, 48);
    smoke.lights = {distantLight({1, -0.5, -0.6}, 3), distantLight({-0.4, 0.2, 1}, 2)};
    ViewScene surface = orthographicScene(smokeField(10), {0.2, Rgb(0.9), {}}, 26, 40);
    surface.lights = {distantLight({-1, -0.7, -0.5}, 3)};
    Classified look;
    look.transfer = {{0.05, Rgb(0.3, 0.5, 1), 0}, {0.6, Rgb(1, 0.8, 0.4), 1}, {1, Rgb(1), 1}};
    surface.volumes[0].classified = std::make_shared<const Classified>(look);
    ViewScene perView = smoke;
    perView.dials.splat = SplatMode::perView;
    std::vector<Job> all{{smoke, 2}, {surface, 3}, {perView, 1}, {smoke, 1}};
    const char* simd[] = {"sse4", "auto", "avx2", "auto"};
    for (std::size_t i = 0; i < all.size(); ++i) all[i].scene.dials.simd = simd[i];
    return all;
}

std::vector<float> rendered(const Job& job) {
    return render(job.scene, makePlan(job.scene, job.threads)).image.rgba;
}

// As many threads as a test asks for, on however few processors.
class SideBySide : public testing::Test {
    tbb::global_control m_threads{tbb::global_control::max_allowed_parallelism, 8};
};

TEST_F(SideBySide, RendersAreAsEachAlone) {
    const std::vector<Job> all = jobs();
    std::vector<std::vector<float>> alone;
    for (const Job& job : all) alone.push_back(rendered(job));
    EXPECT_NE(alone[0], alone[3]);  // other instructions are other roundings: mixing them up would show
    for (int round = 0; round < 3; ++round) {
        std::vector<std::vector<float>> together(all.size());
        std::atomic<int> waiting{static_cast<int>(all.size())};
        std::vector<std::thread> hosts;
        for (std::size_t i = 0; i < all.size(); ++i)
            hosts.emplace_back([&, i] {
                for (--waiting; waiting > 0;) std::this_thread::yield();  // so that they really overlap
                together[i] = rendered(all[i]);
            });
        for (std::thread& host : hosts) host.join();
        for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(together[i], alone[i]) << "render " << i;
    }
}

TEST_F(SideBySide, RendersWithinTasksOfALoopAreAsEachAlone) {
    const std::vector<Job> all = jobs();
    std::vector<std::vector<float>> alone;
    for (const Job& job : all) alone.push_back(rendered(job));
    constexpr std::size_t kTimes = 3;
    std::vector<std::vector<float>> nested(kTimes * all.size());
    TaskArena(4).run(
        [&] { parallelFor(nested.size(), [&](std::size_t i) { nested[i] = rendered(all[i % all.size()]); }); });
    for (std::size_t i = 0; i < nested.size(); ++i) EXPECT_EQ(nested[i], alone[i % all.size()]) << "render " << i;
}

TEST_F(SideBySide, AVerificationBesideARenderIsAsAlone) {
    const std::vector<Job> all = jobs();
    const Image image = render(all[0].scene, makePlan(all[0].scene, 2)).image;
    const Verification alone = summarise(samplePixels(all[0].scene, image, 20, 1));
    Verification beside;
    std::thread host([&] { beside = summarise(samplePixels(all[0].scene, image, 20, 1)); });
    rendered(all[1]);
    host.join();
    EXPECT_EQ(beside.error, alone.error);
    EXPECT_EQ(beside.upper, alone.upper);
}

TEST_F(SideBySide, AStoppedRenderStopsNoOther) {
    const std::vector<Job> all = jobs();
    const std::vector<float> alone = rendered(all[0]);
    std::vector<float> other;
    std::thread host([&] { other = rendered(all[0]); });
    EXPECT_ANY_THROW(render(all[2].scene, makePlan(all[2].scene, 2), [](double) { return false; }));
    host.join();
    EXPECT_EQ(other, alone);
}

}  // namespace
}  // namespace scrim::test
