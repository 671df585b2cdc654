// SPDX-License-Identifier: Apache-2.0
#include <scrim/guard/load_job.h>

#include <scrim/base/child_process.h>
#include <scrim/base/error.h>
#include <scrim/base/installed.h>
#include <scrim/base/parallel.h>
#include <scrim/base/system_error.h>
#include <scrim/image/picture_module.h>
#include <scrim/guard/load_protocol.h>

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <span>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#ifndef SCRIM_LIBEXEC_FROM_LIB
#error "define SCRIM_LIBEXEC_FROM_LIB as the folder of programs, relative to that of the library, as a string"
#endif

namespace scrim {
namespace {

[[noreturn]] void cannotStart(int error) {
    throw Error(kindOfSystemError(error, ErrorKind::memory),
                fmt::format("cannot start a process to read files: {}", systemErrorText(error)));
}

std::pair<Descriptor, Descriptor> socketPair() {
    int ends[2] = {-1, -1};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) cannotStart(errno);
    Descriptor first(aboveStandardStreams(ends[0]));
    int error = errno;
    Descriptor second(aboveStandardStreams(ends[1]));
    if (first.fd() >= 0) error = errno;
    if (first.fd() < 0 || second.fd() < 0) cannotStart(error);
    return {std::move(first), std::move(second)};
}

const char* readsText(LoadedFiles files) {
    return files == LoadedFiles::volumes ? "volumes" : "pictures";
}

/// The program's arguments. Only the one for pictures loads the module that reads pictures.
std::vector<std::string> argumentsFor(LoadedFiles files) {
    if (files == LoadedFiles::volumes) return {"scrim-load", "--serve"};
    return {"scrim-load", "--serve-pictures", pictureModulePath()};
}

/// Identifies a program: its path and the kind of files.
using ServerKey = std::pair<std::string, LoadedFiles>;

/// Starts a loader program with that end of its socket. Throws an Error that names the program.
ChildProcess startLoader(const ServerKey& key, const Descriptor& socket) {
    const auto& [program, files] = key;
    constexpr int kNothing = ProgramStart::kNothing;
    ProgramStart start{argumentsFor(files), program, {{0, kNothing}, {1, kNothing}, {2, kNothing}}};
    start.descriptors.emplace_back(kLoadSocket, socket.fd());
    // Trees consist of many small pieces of memory, and mapping it page by page takes a fifth of
    // the time of reading them.
    if (std::getenv("GLIBC_TUNABLES") == nullptr) start.variables = {"GLIBC_TUNABLES=glibc.malloc.hugetlb=1"};
    try {
        return ChildProcess(start, 0);
    } catch (const std::system_error& error) {
        const int number = error.code().value();
        if (number == ENOMEM || number == EAGAIN)
            throw Error(ErrorKind::memory,
                        fmt::format("cannot start a process to read {}: {}", readsText(files), std::strerror(number)));
        throw Error(ErrorKind::render, fmt::format("cannot start '{}' to read {}: {}", shortened(program),
                                                   readsText(files), std::strerror(number)));
    }
}

/// A running loader program, which ends when the socket is closed.
class Server {
  public:
    explicit Server(const ServerKey& key) : Server(key, socketPair()) {}

    /// Returns false where the program has ended.
    bool send(LoadMessage message, std::span<const int> descriptors) const {
        message.descriptors = static_cast<std::uint32_t>(descriptors.size());
        iovec part{&message, sizeof message};
        alignas(cmsghdr) char space[CMSG_SPACE(kMostDescriptors * sizeof(int))] = {};
        msghdr head{};
        head.msg_iov = &part;
        head.msg_iovlen = 1;
        head.msg_control = space;
        head.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
        cmsghdr* rights = CMSG_FIRSTHDR(&head);
        rights->cmsg_level = SOL_SOCKET;
        rights->cmsg_type = SCM_RIGHTS;
        rights->cmsg_len = CMSG_LEN(descriptors.size_bytes());
        std::memcpy(CMSG_DATA(rights), descriptors.data(), descriptors.size_bytes());
        ssize_t sent = 0;
        do sent = ::sendmsg(m_socket.fd(), &head, MSG_NOSIGNAL);
        while (sent < 0 && errno == EINTR);
        return sent == static_cast<ssize_t>(sizeof message);
    }

  private:
    Server(const ServerKey& key, std::pair<Descriptor, Descriptor> ends)
        : m_program(startLoader(key, ends.second)), m_socket(std::move(ends.first)) {}

    ChildProcess m_program;
    Descriptor m_socket;  // below the program, so that it is closed before the program is waited for
};

/// The loader programs of this process.
class Servers {
  public:
    void start(const ServerKey& program) {
        const std::scoped_lock lock(m_mutex);
        serverOf(program);
    }
    void send(const ServerKey& program, const LoadMessage& message, std::span<const int> descriptors) {
        const std::scoped_lock lock(m_mutex);
        // A program that was killed in the meantime is started again, once.
        for (int i = 0; i < 2; ++i) {
            if (serverOf(program).send(message, descriptors)) return;
            m_servers.erase(program);
        }
        // With less memory the program may not even load its libraries.
        constexpr std::size_t kLoaderBytes = std::size_t{1} << 30;
        const bool limited = limitsMemory(kLoaderBytes);
        throw Error(
            limited ? ErrorKind::memory : ErrorKind::render,
            fmt::format("'{}', which reads {}, exits at once{}", shortened(program.first), readsText(program.second),
                        limited ? "; raise the limit of memory (ulimit -v, ulimit -d)" : ""));
    }

  private:
    Server& serverOf(const ServerKey& program) {
        std::unique_ptr<Server>& server = m_servers[program];
        if (!server) server = std::make_unique<Server>(program);
        return *server;
    }

    std::mutex m_mutex;
    std::map<ServerKey, std::unique_ptr<Server>> m_servers;
};

ServerKey keyOf(const std::string& loader, LoadedFiles files) {
    return {loader.empty() ? ownLoader() : loader, files};
}

/// The programs are shared by the whole process, so that each is started once. The object is never
/// destroyed: the end of the process closes the sockets.
Servers& servers() {
    static Servers* const all = new Servers;
    return *all;
}

bool isOpen(int fd) {
    return ::fcntl(fd, F_GETFD) >= 0;
}

std::string signalName(int signal) {
    const char* name = ::sigabbrev_np(signal);
    return name == nullptr ? fmt::format("signal {}", signal) : fmt::format("signal SIG{}", name);
}

std::string secondsText(long long seconds) {
    return seconds == 1 ? "1 second" : fmt::format("{} seconds", seconds);
}

[[noreturn]] void tookTooLong(const std::string& path, std::chrono::seconds patience) {
    const auto seconds = patience.count();
    throw Error(ErrorKind::input,
                fmt::format("{}: reading it took more than {}", path,
                            seconds < 120 || seconds % 60 != 0 ? secondsText(seconds)
                                                               : fmt::format("{} minutes", seconds / 60)));
}

void checkStatus(const LoadAnswer& answer, const std::string& path, const LoadLimits& limits) {
    const int status = answer.status;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
    if (WIFEXITED(status) && WEXITSTATUS(status) == kNotConfined)
        throw Error(ErrorKind::render,
                    fmt::format("{}: the process that reads it cannot be confined: this system has no seccomp", path));
    if (WIFEXITED(status) && WEXITSTATUS(status) == kNoMemoryToConfine)
        throw Error(ErrorKind::memory,
                    fmt::format("{}: not enough memory to confine the process that reads it (ulimit -v)", path));
    if (WIFEXITED(status) && WEXITSTATUS(status) == kNoDescriptors)
        throw Error(ErrorKind::render, fmt::format("{}: cannot be read: {}", path, systemErrorText(EMFILE)));
    if (WIFEXITED(status))
        throw Error(ErrorKind::input,
                    fmt::format("{}: damaged: reading it failed (exit status {})", path, WEXITSTATUS(status)));
    // A child that used up its time ends by SIGXCPU, or by SIGKILL where no time is left after that.
    const std::chrono::microseconds used(answer.microseconds);
    if ((WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL) && limitsTime(used))
        throw Error(ErrorKind::render,
                    fmt::format("{}: reading it exceeded the limit on CPU time; raise it (ulimit -t)", path));
    if (WTERMSIG(status) == SIGXCPU)
        throw Error(ErrorKind::input,
                    fmt::format("{}: reading it did not finish within {} of CPU time", path,
                                secondsText(std::llround(std::chrono::duration<double>(used).count()))));
    // Only the system's out-of-memory killer ends a child like this.
    if (WTERMSIG(status) == SIGKILL)
        throw Error(ErrorKind::memory,
                    fmt::format("{}: reading it was killed (signal SIGKILL), probably because memory ran out", path));
    if (limitsMemory(limits.memory))
        throw Error(
            ErrorKind::memory,
            fmt::format("{}: reading it crashed ({}), probably because memory ran out; raise the limit (ulimit -v)",
                        path, signalName(WTERMSIG(status))));
    const std::string signal = signalName(WTERMSIG(status));
    throw ReaderCrash(fmt::format("{}: damaged: reading it crashed ({})", path, signal), signal);
}

}  // namespace

std::string ownLoader() {
    const std::filesystem::path folder = std::filesystem::path(libraryFolder()) / SCRIM_LIBEXEC_FROM_LIB;
    return (folder / "scrim/scrim-load").lexically_normal().string();
}

void warmLoader(const std::string& loader, LoadedFiles files) noexcept {
    try {
        servers().start(keyOf(loader, files));
    } catch (const std::exception&) {
    }
}

LoadJob::LoadJob(const std::string& loader, LoadedFiles files, const std::string& path, const Descriptors& own,
                 const LoadLimits& limits, bool showStderr)
    : m_path(path), m_limits(limits) {
    auto [ours, theirs] = socketPair();
    LoadMessage message;
    message.memory = limits.memory;
    message.seconds = static_cast<std::uint64_t>(limits.patience.count());
    message.threads = static_cast<std::uint32_t>(threadCount());
    message.showsStderr = showStderr && isOpen(STDERR_FILENO) ? 1 : 0;
    std::vector<int> descriptors{theirs.fd(), own.transfer, own.input, own.beside >= 0 ? own.beside : own.input,
                                 message.showsStderr != 0 ? STDERR_FILENO : own.input};
    descriptors.insert(descriptors.end(), own.others.begin(), own.others.end());
    servers().send(keyOf(loader, files), message, descriptors);
    m_control = std::move(ours);
}

void LoadJob::wait(const Checkpoint& checkpoint) {
    constexpr int kPause = 5;  // milliseconds
    const auto start = std::chrono::steady_clock::now();
    for (;;) {
        if (checkpoint) checkpoint();
        pollfd event{m_control.fd(), POLLIN, 0};
        if (::poll(&event, 1, kPause) > 0) break;
        if (std::chrono::steady_clock::now() - start > m_limits.patience) tookTooLong(m_path, m_limits.patience);
    }
    LoadAnswer answer;
    const bool answered = ::recv(m_control.fd(), &answer, sizeof answer, 0) == static_cast<ssize_t>(sizeof answer);
    m_control = Descriptor();
    // Processes in the same terminal receive this process's signals, which are not the file's fault.
    if (checkpoint) checkpoint();
    if (!answered && limitsMemory(m_limits.memory))
        throw LoaderLost(ErrorKind::memory, fmt::format("{}: the process that reads it ended unexpectedly, probably "
                                                        "because memory ran out; raise the limit (ulimit -v)",
                                                        m_path));
    if (!answered)
        throw LoaderLost(ErrorKind::render, fmt::format("{}: the process that reads it ended unexpectedly", m_path));
    if (answer.problem != 0)
        throw Error(kindOfSystemError(answer.problem, ErrorKind::render),
                    fmt::format("{}: cannot start a process to read it: {}", m_path, systemErrorText(answer.problem)));
    checkStatus(answer, m_path, m_limits);
}

}  // namespace scrim
