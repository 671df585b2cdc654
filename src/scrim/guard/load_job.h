// SPDX-License-Identifier: Apache-2.0
// Internal: one file that a child of the program `scrim-load` reads. The first job that needs the
// program starts it; it serves all jobs of this process and ends with it. There is one program for
// volumes (including files of volume sources) and one for pictures.
#pragma once

#include <scrim/base/descriptor.h>
#include <scrim/base/error.h>
#include <scrim/base/messages.h>

#include <chrono>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>

namespace scrim {

/// Path of the loader program that belongs to this library.
std::string ownLoader();

/// The kind of files that a loader program reads. It prepares itself for them before the first one comes.
enum class LoadedFiles { volumes, pictures };

/// Starts the program at `loader` ("": `ownLoader`) for such files unless it runs already, so that
/// it is ready for the first job. A failure is not reported here; the job will report it.
void warmLoader(const std::string& loader, LoadedFiles files = LoadedFiles::volumes) noexcept;

struct LoadLimits {
    std::size_t memory = 0;              ///< address space that the child may add to what it starts with, bytes
    std::chrono::seconds patience{600};  ///< processor time of the child, and the longest wait for it
};

/// The program ended before it reported how its child had ended.
class LoaderLost : public Error {
    using Error::Error;
};

/// A child crashed, probably because its file is damaged. The text says so: "PATH: damaged: ...".
class ReaderCrash : public Error {
  public:
    ReaderCrash(const std::string& text, std::string signal)
        : Error(ErrorKind::input, text), m_signal(std::move(signal)) {}
    const std::string& signal() const noexcept { return m_signal; }  ///< "signal SIGABRT"

  private:
    std::string m_signal;
};

class LoadJob {
  public:
    /// Descriptors that a child gets a copy of. They stay open here.
    struct Descriptors {
        int transfer;                      ///< the request, and then what the child hands over
        int input;                         ///< the file that it reads
        int beside = -1;                   ///< a second file that belongs to the input; -1: none
        std::span<const int> others = {};  ///< of a volume; at most kMostDescriptors - kMore (load_protocol.h)
    };
    /// Starts a child of `loader` that reads a file of the kind `files`, which messages call
    /// `path`. Throws Error(render, memory) where the program cannot be started.
    LoadJob(const std::string& loader, LoadedFiles files, const std::string& path, const Descriptors& descriptors,
            const LoadLimits& limits, bool showStderr);

    /// Waits until the child has ended properly; calls `checkpoint` every few milliseconds. Throws whatever that
    /// throws, LoaderLost, ReaderCrash, and an Error where the child ended otherwise or takes longer than the limits
    /// allow from now on. If the job is destroyed before that, the child ends, too.
    void wait(const Checkpoint& checkpoint);

    std::size_t memory() const { return m_limits.memory; }

  private:
    std::string m_path;
    LoadLimits m_limits;
    Descriptor m_control;
};

}  // namespace scrim
