// SPDX-License-Identifier: Apache-2.0
// Records what a render would share among the threads of a larger machine (see base/loop_recorder.h), for
// scaling.py predict: reading, planning, rendering and writing, in one process and on one thread.
//
//     scrim_loops SCENE THREADS RECORD FOLDER [FIRST LAST]      pictures go to FOLDER
#include <scrim/base/error.h>
#include <scrim/base/loop_recorder.h>
#include <scrim/shot/shot.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include <fmt/format.h>

namespace {

void renderFrames(const std::string& scene, int first, int last, int threads, const std::string& folder) {
    scrim::RenderOptions rendering;
    rendering.threads = threads;
    scrim::Shot shot = scrim::Shot::open(scene);  // which reads in this process
    for (int frame = first; frame <= last; ++frame)
        shot.render(frame, rendering).write(fmt::format("{}/{:04}.exr", folder, frame));
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 5 && argc != 7) {
        fmt::print(stderr, "usage: scrim_loops SCENE THREADS RECORD FOLDER [FIRST LAST]\n");
        return 2;
    }
    const int threads = std::atoi(argv[2]), first = argc > 5 ? std::atoi(argv[5]) : 1;
    std::ofstream record(argv[3]);
    try {
        const scrim::LoopRecorder recorder(record, threads);
        renderFrames(argv[1], first, argc > 6 ? std::atoi(argv[6]) : first, threads, argv[4]);
    } catch (const scrim::Error& error) {
        fmt::print(stderr, "scrim_loops: {}\n", error.what());
        return 1;
    }
    return record.flush() ? 0 : 1;
}
