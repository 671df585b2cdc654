// SPDX-License-Identifier: Apache-2.0
// Whoever stops the program waits for it, and a farm kills what does not go. SIGTERM is sent at moments drawn by lot to
// scenes that are heavy in different ways: to read, to make, to plan, to prepare, to render and to verify.
// SCRIM_INTERRUPT_MOMENTS=N asks for N moments a scene.
#include "support/program_test.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace scrim::test {
namespace {

using Clock = std::chrono::steady_clock;

class Interrupt : public ProgramTest {
  protected:
    // Each takes half a minute at least where nothing stops it.
    std::vector<std::pair<std::string, std::vector<std::string>>> heavyScenes() const {
        makeVdb(file("huge.vdb"), {{.tiles = {{{0, 0, 0}, 4096, 0.001}}}});
        makeVdb(file("mad.vdb"), {{.voxels = box({-12, -12, -12}, {11, 11, 11}, 0.2)},
                                  {.name = "vx", .gridClass = "", .voxels = {{{0, 0, 0}, 1e9}}},
                                  {.name = "vy", .gridClass = "", .voxels = {{{0, 0, 0}, 1e9}}},
                                  {.name = "vz", .gridClass = "", .voxels = {{{0, 0, 0}, 1e9}}}});
        const std::string noise =
            "[[volume]]\nsource = \"noise\"\nparameters = {{ resolution = \"{}\" }}\ndensity = {{ scale = 0.1 }}\n";
        std::string lamps = kCamera + kVolume, suns = kCamera + kVolume;
        std::mt19937 random(5);
        std::uniform_real_distribution<double> place(-30, 30);
        for (int i = 0; i < 20'000; ++i) {
            lamps += fmt::format("[[light]]\ntype = \"point\"\nposition = [{:.3f}, {:.3f}, {:.3f}]\n", place(random),
                                 place(random), place(random));
            suns += fmt::format("[[light]]\ntype = \"distant\"\ndirection = [{:.3f}, {:.3f}, {:.3f}]\n", place(random),
                                place(random), place(random));
        }
        write("lamps.toml", lamps);
        write("suns.toml", suns);
        write("sky.toml", kCamera + kVolume + "[[light]]\ntype = \"dome\"\nsamples = 4096\nshadow = \"buffers\"\n");
        write("cells.toml", kCamera + fmt::format(fmt::runtime(noise), 128) +
                                "[[light]]\ntype = \"dome\"\nsamples = 4096\nshadow = \"cells\"\n");
        write("made.toml", kCamera + fmt::format(fmt::runtime(noise), 900) + kLight);
        write("scattered.toml", kCamera + fmt::format(fmt::runtime(noise), 128) +
                                    "[volume.medium]\nscattering = \"full\"\nalbedo = [0.99, 0.99, 0.99]\n" + kLight);
        write("moved.toml", kCamera +
                                "[[volume]]\nfile = \"mad.vdb\"\nvelocity = { grid = [\"vx\", "
                                "\"vy\", \"vz\"] }\n" +
                                kLight);
        return {{"tile", {"render", "huge.vdb", "--set", "render.texel=0.2"}},
                {"lamps", {"render", "lamps.toml"}},
                {"suns", {"render", "suns.toml", "--res", "1024x1024"}},
                {"sky", {"render", "sky.toml", "--res", "1024x1024"}},
                {"cells", {"render", "cells.toml", "--set", "render.light_cell=0.5"}},
                {"made", {"render", "made.toml"}},
                {"scattered", {"render", "scattered.toml", "--set", "render.scatter_cell=0.5"}},
                {"moved",
                 {"render", "moved.toml", "--set", "camera.shutter=[-0.25,0.25]", "--set",
                  "render.shutter_samples=1024", "--res", "2048x2048"}},
                {"verified", {"render", "scene.toml", "--res", "1024x1024", "--verify", "1000000"}},
                {"studied", {"study", "scene.toml", "--res", "1024x1024", "-o", "studied"}},
                {"fine", {"render", "scene.toml", "--res", "8192x8192", "--quality", "ultra"}}};
    }
};

TEST_F(Interrupt, IsAnsweredWithinASecondAtAnyMoment) {
    const char* const asked = std::getenv("SCRIM_INTERRUPT_MOMENTS");
    const int moments = asked != nullptr ? std::atoi(asked) : 3;
    const auto scenes = heavyScenes();
    const std::set<std::string> before = listing();
    std::mt19937 random(11);
    for (const auto& [name, arguments] : scenes) {
        double slowest = 0;
        int late = 0;
        for (int i = 0; i < moments; ++i) {
            // Early moments are in reading and planning.
            const double part = std::uniform_real_distribution<double>(0, 1)(random);
            const auto delay = std::chrono::duration<double>(1.5 * part * part);
            RunningProgram program(m_folder.path(), arguments);
            std::this_thread::sleep_for(delay);
            program.sendSignal(SIGTERM);
            const auto sent = Clock::now();
            const ProgramResult result = program.wait();
            slowest = std::max(slowest, std::chrono::duration<double>(Clock::now() - sent).count());
            late += result.err.find("scrim: interrupted by") != std::string::npos;
            // Before main has begun, the signal ends it as any program.
            EXPECT_TRUE(result.status == 143 || result.signal == SIGTERM)
                << name << " after " << delay.count() << " s: status " << result.status << "\n"
                << result.err;
            EXPECT_EQ(listing(), before) << name << " after " << delay.count() << " s";
        }
        // A second, and what a busy machine adds. Without an answer it would be half a minute.
        EXPECT_LT(slowest, 5) << name;
        RecordProperty(name, fmt::format("slowest {:.2f} s, {} of {} by the clock", slowest, late, moments));
        if (asked != nullptr)
            fmt::print("{:10} slowest {:.2f} s, {} of {} by the clock\n", name, slowest, late, moments);
    }
}

}  // namespace
}  // namespace scrim::test
