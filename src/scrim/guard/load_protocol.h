// SPDX-License-Identifier: Apache-2.0
// Internal: the protocol between this process and the program `scrim-load`. The program starts with one socket
// (SOCK_SEQPACKET), descriptor kLoadSocket, and ends when that closes. Each message on the socket is one LoadMessage
// with descriptors; for each, the program forks a child, which reads one file (or two that belong together) and ends.
// The program reports the end of the child through the descriptor `control`; if the other end of `control` closes, the
// child is killed. All other data is in the transfer (field_transfer.h): first the request, then the result.
#pragma once

#include <cstdint>

namespace scrim {

constexpr int kLoadSocket = 3;  // the first behind stdin, stdout and stderr

struct LoadMessage {
    std::uint64_t memory = 0;   ///< address space that the child may add to what it starts with, bytes
    std::uint64_t seconds = 0;  ///< processor time, for each thread
    std::uint32_t threads = 1;  ///< threads that reading a volume, or a volume source, may use
    /// Number of descriptors with the message, in the order below.
    std::uint32_t descriptors = 0;
    std::uint32_t showsStderr = 0;  ///< 1: the child writes to kStderr what libraries print
};

/// `kBeside` is a second file to read, or the input again where there is none; so is `kStderr` where it is not used.
/// The descriptors from `kMore` on are the other files of a volume that is put together from several.
enum LoadDescriptor : std::uint32_t {
    kControl,
    kTransfer,
    kInput,
    kBeside,
    kStderr,
    kMore,
    kMostDescriptors = kMore + 31
};

/// The answer through `control`.
struct LoadAnswer {
    std::int32_t status = 0;        ///< status as waitpid reports it
    std::int32_t problem = 0;       ///< errno of the failure to start a child; 0: none
    std::int64_t microseconds = 0;  ///< processor time of the child
};

/// Exit status of a child that the system refused to confine.
constexpr int kNotConfined = 3;
/// Exit status of a child that did not have enough memory to confine itself.
constexpr int kNoMemoryToConfine = 5;
/// Exit status of a child that has fewer descriptors than it needs.
constexpr int kNoDescriptors = 4;
/// Exit status of a child that needs OpenVDB where the program has not loaded it. The program then
/// does so, and starts another child in its place.
constexpr int kNeedsOpenVdb = 6;

}  // namespace scrim
