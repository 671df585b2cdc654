// SPDX-License-Identifier: Apache-2.0
// Internal: one file being read by a child of the program `scrim-load`. The program is started by the first job that
// needs it, serves all jobs of this process, and ends with it; one runs for volumes (files of volume sources are among
// them) and one for pictures.
#pragma once

#include <scrim/base/error.h>
#include <scrim/base/messages.h>

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

namespace scrim {

/// An open file; closed at the end of this.
class Descriptor {
  public:
    explicit Descriptor(int fd = -1) : m_fd(fd) {}
    ~Descriptor();
    Descriptor(Descriptor&& other) noexcept : m_fd(other.release()) {}
    Descriptor& operator=(Descriptor&& other) noexcept;
    int fd() const { return m_fd; }
    int release() {
        const int fd = m_fd;
        m_fd = -1;
        return fd;
    }

  private:
    int m_fd;
};

/// Path of the program that belongs to this library.
std::string ownLoader();

/// What files a running program reads: it makes itself ready for them before any comes.
enum class LoadedFiles { volumes, pictures };

/// Starts the program at the path `loader` ("": `ownLoader`) for such files, unless it runs already, so that it is
/// ready when the first job comes. Says nothing where that fails: the job will.
void warmLoader(const std::string& loader, LoadedFiles files = LoadedFiles::volumes) noexcept;

struct LoadLimits {
    std::size_t memory = 0;              ///< bytes of address space of the child, beyond what it starts with
    std::chrono::seconds patience{600};  ///< that the child may compute, and that one waits
};

/// The program ended before it told how its child did.
class LoaderLost : public Error {
    using Error::Error;
};

class LoadJob {
  public:
    /// Lets a child of `loader` read `input`, one of such files, as the request in `transfer` says. Both stay open
    /// here, as does `beside`, which belongs to the input; -1: nothing does. Throws Error(render, memory) where the
    /// program cannot be started.
    LoadJob(const std::string& loader, LoadedFiles files, const std::string& path, int transfer, int input,
            const LoadLimits& limits, bool showStderr, int beside = -1);

    /// Waits until the child has ended as it should; calls `checkpoint` every few milliseconds. Throws what that
    /// throws, LoaderLost, and an Error where the child crashed, or takes longer than one has patience from now on.
    /// Where a job ends without that, so does its child.
    void wait(const Checkpoint& checkpoint);

  private:
    std::string m_path;
    LoadLimits m_limits;
    Descriptor m_control;
};

}  // namespace scrim
