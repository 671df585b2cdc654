// SPDX-License-Identifier: Apache-2.0
// Internal: how this process and the program `scrim-load` speak. The program has one socket (SOCK_SEQPACKET) from its
// start as descriptor kLoadSocket, and ends when that closes. Each message on it is one LoadMessage with descriptors;
// for each the program forks a child, which reads one file (or two that belong together) and ends. Through the
// descriptor `control` the program says how the child ended; where its other end closes, the child is killed. All else
// stands in the transfer (field_transfer.h): first the request, then what was read.
#pragma once

#include <cstdint>

namespace scrim {

constexpr int kLoadSocket = 3;  // the first behind stdin, stdout and stderr

struct LoadMessage {
    std::uint64_t memory = 0;       ///< bytes of address space that the child may add to what it starts with
    std::uint64_t seconds = 0;      ///< of computing, on each thread
    std::uint32_t threads = 1;      ///< that a volume source may use; files are read by one
    std::uint32_t descriptors = 0;  ///< that come with it, in the order below; the last may be missing
};

/// `kBeside` is a second file to read, or the input once more where there is none.
enum LoadDescriptor : std::uint32_t { kControl, kTransfer, kInput, kBeside, kStderr, kMostDescriptors };

/// What goes back through `control`.
struct LoadAnswer {
    std::int32_t status = 0;        ///< what waitpid says
    std::int32_t problem = 0;       ///< the error number of what kept a child from being started; 0: nothing did
    std::int64_t microseconds = 0;  ///< of processor time that the child took
};

/// Exit status of a child that cannot do without what it must not have.
constexpr int kNotConfined = 3;
/// And of one that has not as many descriptors as it needs.
constexpr int kNoDescriptors = 4;

}  // namespace scrim
