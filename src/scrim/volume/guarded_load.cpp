// SPDX-License-Identifier: Apache-2.0
// The parent's side of a guarded load; the child's is in internal_load.cpp.
#include <scrim/volume/guarded_load.h>

#include <scrim/base/error.h>
#include <scrim/volume/field_transfer.h>

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace scrim {
namespace {

constexpr int kChildDescriptor = 3;  // the first behind stdin, stdout and stderr
constexpr std::size_t kLeastMemory = std::size_t{4} << 30;
/// OpenVDB's trees take some 35 times what they can be compressed to in a file, and the field made of them
/// comes on top.
constexpr std::size_t kMemoryPerByte = 64;
/// Below this the reader itself would take an honest small file for a damaged one.
constexpr std::size_t kLeastGivenMemory = std::size_t{1} << 30;
constexpr std::chrono::minutes kPatience{10};
constexpr double kSlowestBytesPerSecond = 1 << 20;  // a busy network drive
constexpr int kMostThreads = 8;  // each costs the child address space, and reading hardly gains from more

class Descriptor {
  public:
    explicit Descriptor(int fd) : m_fd(fd) {}
    ~Descriptor() { ::close(m_fd); }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int fd() const { return m_fd; }

  private:
    int m_fd;
};

void check(const Checkpoint& checkpoint) {
    if (checkpoint) checkpoint();
}

std::size_t sizeOf(const std::string& path) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path, error);
    return error ? 0 : std::size_t(size);
}

/// Address space that the child may add to what it starts with.
std::size_t memoryFor(const std::string& path, const LoadOptions& options) {
    if (options.memory > 0) return std::max(options.memory, kLeastGivenMemory);
    return std::max(kLeastMemory, kMemoryPerByte * sizeOf(path));
}

/// A running child; ends it where nobody waited for it. Not Boost.Process: it handles SIGCHLD for the whole process,
/// which belongs to whoever links the library.
class Child {
  public:
    Child(const std::string& program, const std::vector<std::string>& arguments, int transfer, bool showStderr) {
        std::vector<char*> argv;
        for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
        argv.push_back(nullptr);

        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
        if (!showStderr) posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
        posix_spawn_file_actions_adddup2(&actions, transfer, kChildDescriptor);
        const int error = ::posix_spawn(&m_pid, program.c_str(), &actions, nullptr, argv.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        if (error == ENOMEM || error == EAGAIN)
            throw Error(ErrorKind::memory,
                        fmt::format("cannot start a process to read volumes: {}", std::strerror(error)));
        if (error != 0)
            throw Error(ErrorKind::render,
                        fmt::format("cannot start '{}' to read volumes: {}", shortened(program), std::strerror(error)));
    }
    ~Child() {
        if (m_pid <= 0) return;
        ::kill(m_pid, SIGKILL);
        while (::waitpid(m_pid, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    /// Waits and returns what waitpid says; throws where `checkpoint` does or `patience` is over.
    int wait(std::chrono::duration<double> patience, const std::string& path, const Checkpoint& checkpoint) {
        const auto start = std::chrono::steady_clock::now();
        std::chrono::microseconds pause(200);
        for (int status = 0;;) {
            const pid_t ended = ::waitpid(m_pid, &status, WNOHANG);
            if (ended == m_pid) {
                m_pid = -1;
                // A child in the same terminal gets the signals of this process; that is not the file's fault.
                check(checkpoint);
                return status;
            }
            if (ended < 0 && errno != EINTR)
                throw Error(ErrorKind::render,
                            fmt::format("{}: lost the process that reads it: {}", path, std::strerror(errno)));
            check(checkpoint);
            if (std::chrono::steady_clock::now() - start > patience)
                throw Error(ErrorKind::input,
                            fmt::format("{}: reading it took more than {:.0f} minutes", path, patience.count() / 60));
            std::this_thread::sleep_for(pause);
            pause = std::min(pause * 2, std::chrono::microseconds(5000));
        }
    }

  private:
    pid_t m_pid = -1;
};

std::string signalName(int signal) {
    const char* name = ::sigabbrev_np(signal);
    return name == nullptr ? fmt::format("signal {}", signal) : fmt::format("signal SIG{}", name);
}

void checkStatus(int status, const std::string& path) {
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
    if (WIFEXITED(status))
        throw Error(ErrorKind::input,
                    fmt::format("{}: damaged: reading it failed (exit status {})", path, WEXITSTATUS(status)));
    // Nobody but the system's guard against running out of memory kills a child like that.
    if (WTERMSIG(status) == SIGKILL)
        throw Error(ErrorKind::memory,
                    fmt::format("{}: reading it was killed (signal SIGKILL), probably for want of memory", path));
    throw Error(ErrorKind::input,
                fmt::format("{}: damaged: reading it crashed ({})", path, signalName(WTERMSIG(status))));
}

/// Runs a child that sends `what` of `path` into `transfer`.
void run(const std::string& what, const std::string& path, const std::vector<GridRequest>& requests,
         const LoadOptions& options, int transfer, const Checkpoint& checkpoint) {
    if (options.loader.empty())
        throw Error(ErrorKind::usage, "guarded loading of volumes: expected the path of a loader, the program scrim");
    check(checkpoint);
    const int threads = options.threads > 0 ? std::min(options.threads, kMostThreads) : kMostThreads;
    std::vector<std::string> arguments{"scrim",
                                       kInternalLoad,
                                       "--fd",
                                       std::to_string(kChildDescriptor),
                                       what,
                                       std::to_string(memoryFor(path, options)),
                                       std::to_string(threads),
                                       path};
    for (const GridRequest& request : requests) arguments.push_back(toText(request));
    Child child(options.loader, arguments, transfer, options.showStderr);
    const std::chrono::duration<double> slowest(static_cast<double>(sizeOf(path)) / kSlowestBytesPerSecond);
    checkStatus(child.wait(kPatience + slowest, path, checkpoint), path);
}

/// Runs `receive`; what it says of an incomplete transfer gets the path in front.
template <typename Receive>
auto received(const std::string& path, const Receive& receive) {
    try {
        return receive();
    } catch (const GridError&) {
        throw;
    } catch (const Error& error) {
        const std::string text = error.what();
        if (text.rfind("what was read is incomplete", 0) == 0)
            throw Error(error.kind(), fmt::format("{}: damaged: {}", path, text));
        throw;
    }
}

}  // namespace

std::vector<SparseField> guardedFields(const std::string& path, const std::vector<GridRequest>& requests,
                                       const LoadOptions& options, const MessageSink& messages,
                                       const Checkpoint& checkpoint) {
    const Descriptor transfer(createTransfer());
    run("fields", path, requests, options, transfer.fd(), checkpoint);
    ReceivedFields result = received(path, [&] { return receiveFields(transfer.fd()); });
    if (result.fields.size() != requests.size())
        throw Error(ErrorKind::input, fmt::format("{}: damaged: {} grids were read, expected {}", path,
                                                  result.fields.size(), requests.size()));
    for (const TransferMessage& message : result.messages) notify(messages, message.severity, message.text);
    return std::move(result.fields);
}

VdbFileInfo guardedInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint) {
    const Descriptor transfer(createTransfer());
    run("info", path, {}, options, transfer.fd(), checkpoint);
    return received(path, [&] { return receiveInfo(transfer.fd()); });
}

}  // namespace scrim
