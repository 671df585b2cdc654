// SPDX-License-Identifier: Apache-2.0
// For benchmarks: what a process would share among the threads of a larger machine.
#pragma once

#include <iosfwd>

namespace scrim {

/// While it lives, loops of its thread run their tasks one after the other, and threadCount() there
/// is `threads`: what is done is what so many threads would share. One at a time in a process.
///
/// Writes a line for each part, with processor time of the thread in nanoseconds: "S 1200", what is done between loops;
/// "L 8", a loop of 8 tasks begins; "T 450", one of its tasks ends, or the part of the task after its last inner loop.
/// The lines of inner loops, and S before each of them, come before the T of their task.
class LoopRecorder {
  public:
    LoopRecorder(std::ostream& to, int threads);
    ~LoopRecorder();
    LoopRecorder(const LoopRecorder&) = delete;
    LoopRecorder& operator=(const LoopRecorder&) = delete;
};

}  // namespace scrim
