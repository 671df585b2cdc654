// SPDX-License-Identifier: Apache-2.0
// The program that reads volumes or pictures for others (scrim/guard/load_protocol.h): one process, started once, that
// forks for each file. It has no active threads, so a fork finds everything in a consistent state. The fork reads the
// files it was passed, behind a filter of system calls, and ends. A file that crashes its reader crashes nothing else.
// Volume sources that read files are loaded by the fork before the filter is installed.
//   scrim-load --serve                    serves the socket at descriptor 3: volumes, and files of sources
//   scrim-load --serve-pictures MODULE    serves pictures, which that module (picture_module.h) reads
//   scrim-load --check                    tests whether children are confined (check.h)
#include "check.h"
#include "confine.h"
#include "edit_volume.h"
#include "fork.h"
#include "read_mesh.h"
#include "read_picture.h"
#include "read_profile.h"
#include "read_source.h"
#include "read_volume.h"
#include "vdb_library.h"

#include <scrim/base/child_process.h>
#include <scrim/base/descriptor.h>
#include <scrim/base/system_error.h>
#include <scrim/guard/load_protocol.h>
#include <scrim/guard/load_request.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace scrim::load {
namespace {

constexpr int kUsage = 2;
// Descriptors of a child.
constexpr int kChildTransfer = 3, kChildInput = 4, kChildBeside = 5, kChildMore = 6;

/// One message as received, with its descriptors, which this object closes.
struct Request {
    LoadMessage message;
    std::array<int, kMostDescriptors> descriptors;
    std::optional<LoadRequest> wanted = {};  ///< none: the transfer holds no request, which the child reports
    Request() { descriptors.fill(-1); }
    ~Request() {
        for (const int descriptor : descriptors)
            if (descriptor >= 0) ::close(descriptor);
    }
    Request(const Request&) = delete;
    Request& operator=(const Request&) = delete;

    bool complete() const {
        const auto count = std::min<std::uint32_t>(message.descriptors, kMostDescriptors);
        return count > kStderr && descriptors[count - 1] >= 0;
    }
    Descriptor takeControl() { return Descriptor(std::exchange(descriptors[kControl], -1)); }
    /// Fields are first read without OpenVDB. All else that reads volumes needs it, and so may a source.
    bool mayDoWithoutOpenVdb() const {
        return !wanted || std::holds_alternative<MeshTask>(wanted->task) ||
               std::holds_alternative<PhotometryTask>(wanted->task) || isForFields();
    }
    bool isForFields() const {
        return wanted && std::holds_alternative<FieldsTask>(wanted->task) && editOf(wanted->task) == nullptr;
    }
    /// Reads the request, once: a child that a file has taken over may change the transfer.
    void readTransfer() {
        try {
            wanted = receiveRequest(descriptors[kTransfer]);
        } catch (const Error&) {
            wanted.reset();
        }
    }
};

/// A child, and the control descriptor of the process that waits for it.
struct Job {
    ChildProcess child;
    Descriptor control;
    std::unique_ptr<Request> again;  ///< for another child, where this one may need OpenVDB
    bool ended = false;
};

/// Returns false where no client is left.
bool receive(Request& request) {
    iovec part{&request.message, sizeof request.message};
    alignas(cmsghdr) char space[CMSG_SPACE(sizeof(int) * kMostDescriptors)];
    msghdr head{};
    head.msg_iov = &part;
    head.msg_iovlen = 1;
    head.msg_control = space;
    head.msg_controllen = sizeof space;
    ssize_t size = 0;
    do size = ::recvmsg(kLoadSocket, &head, MSG_CMSG_CLOEXEC);
    while (size < 0 && errno == EINTR);
    if (size <= 0) return false;
    for (cmsghdr* c = CMSG_FIRSTHDR(&head); c != nullptr; c = CMSG_NXTHDR(&head, c)) {
        if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_RIGHTS) continue;
        const auto* from = reinterpret_cast<const int*>(CMSG_DATA(c));
        const std::size_t count = (c->cmsg_len - CMSG_LEN(0)) / sizeof(int);
        for (std::size_t i = 0; i < count && i < kMostDescriptors; ++i) request.descriptors[i] = from[i];
    }
    return true;
}

template <typename Task>
void runConfined(const Task& task, const Limits& limits) {
    if (const int problem = confine(limits, Task::kRights); problem != 0)
        ::_exit(problem == ENOMEM ? kNoMemoryToConfine : kNotConfined);
    task.run();
}

/// The threads that `memory` suffices for, each of which takes `bytes` of address space.
int threadsFor(const LoadMessage& message, std::uint64_t bytes) {
    const auto most = std::max<std::uint64_t>(message.memory / bytes / 2, 1);
    return static_cast<int>(std::min<std::uint64_t>(message.threads, most));
}

/// Runs a task in a child, whose limits of time are those of one thread.
class TaskRun {
  public:
    TaskRun(LoadRequest request, const LoadMessage& message)
        : m_request(std::move(request)), m_message(message), m_limits{message.memory, message.seconds} {}

    void run(const PictureModule* pictures) {
        if (pictures != nullptr) {
            runConfined(ReadPicture(*pictures, kChildTransfer, std::move(m_request), kChildInput), m_limits);
        } else if (const auto* const mesh = std::get_if<MeshTask>(&m_request.task)) {
            runConfined(ReadMesh(kChildTransfer, m_request.path, mesh->module, kChildInput), m_limits);
        } else if (std::holds_alternative<PhotometryTask>(m_request.task)) {
            runConfined(ReadProfile(kChildTransfer, m_request.path, kChildInput), m_limits);
        } else if (const auto* const source = std::get_if<SourceTask>(&m_request.task)) {
            const int threads = takeThreads(kThreadBytes);
            runConfined(ReadSource(kChildTransfer, m_request.path, *source, kChildInput, kChildBeside, threads),
                        m_limits);
        } else if (editOf(m_request.task) != nullptr) {
            const int threads = takeThreads(kThreadBytes);
            runConfined(EditVolume(kChildTransfer, std::move(m_request), filesOfEdit(), threads), m_limits);
        } else {
            const int threads = takeThreads(kStackBytes);
            runConfined(ReadVolume(kChildTransfer, std::move(m_request), kChildInput, threads), m_limits);
        }
    }

  private:
    // A thread takes address space for its stack and, where it has an arena, its memory, which a small limit must
    // provide.
    static constexpr std::uint64_t kStackBytes = std::uint64_t{16} << 20, kThreadBytes = std::uint64_t{128} << 20;

    int takeThreads(std::uint64_t bytes) {
        const int threads = threadsFor(m_message, bytes);
        m_limits.seconds *= static_cast<std::size_t>(threads);
        return threads;
    }
    std::vector<int> filesOfEdit() const {
        std::vector<int> files{kChildInput};
        for (std::uint32_t i = kMore; i < m_message.descriptors; ++i)
            files.push_back(kChildMore + static_cast<int>(i - kMore));
        return files;
    }

    LoadRequest m_request;
    LoadMessage m_message;
    Limits m_limits;
};

/// The child: keeps its own descriptors and nothing else. Never returns.
[[noreturn]] void runChild(Request& request, const PictureModule* pictures, pid_t parent) {
    // All descriptors are first moved above their final numbers, so that none is overwritten before it has been moved.
    const int end = kChildMore + static_cast<int>(std::max<std::uint32_t>(request.message.descriptors, kMore) - kMore);
    for (int& descriptor : request.descriptors)
        if (descriptor >= 0 && (descriptor = ::fcntl(descriptor, F_DUPFD, end)) < 0) ::_exit(kNoDescriptors);
    ::dup2(request.descriptors[kTransfer], kChildTransfer);
    ::dup2(request.descriptors[kInput], kChildInput);
    ::dup2(request.descriptors[kBeside], kChildBeside);
    if (request.message.showsStderr != 0) ::dup2(request.descriptors[kStderr], STDERR_FILENO);
    for (std::uint32_t i = kMore; i < kMostDescriptors; ++i)
        if (request.descriptors[i] >= 0) ::dup2(request.descriptors[i], kChildMore + static_cast<int>(i - kMore));
    ::close_range(static_cast<unsigned>(end), ~0U, 0);
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);

    // The child must not outlive this program, which may already have ended.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(0);
    TaskRun(request.wanted ? std::move(*request.wanted) : receiveRequest(kChildTransfer), request.message)
        .run(pictures);
    // The heap may be corrupted by a damaged file, so it is not cleaned up.
    ::_exit(0);
}

class Server {
  public:
    /// Its children read with `pictures`; null: they read volumes.
    explicit Server(const PictureModule* pictures) : m_pictures(pictures) {
        sigset_t ended;
        sigemptyset(&ended);
        sigaddset(&ended, SIGCHLD);
        ::sigprocmask(SIG_BLOCK, &ended, nullptr);
        m_ended = ::signalfd(-1, &ended, SFD_NONBLOCK | SFD_CLOEXEC);
    }

    int serve() {
        for (;;) {
            std::vector<pollfd> events{{kLoadSocket, POLLIN, 0}, {m_ended, POLLIN, 0}};
            for (const Job& job : m_jobs) events.push_back({job.control.fd(), 0, 0});  // a hang-up is always reported
            if (::poll(events.data(), events.size(), -1) < 0) {
                if (errno == EINTR) continue;
                return 1;
            }
            for (std::size_t i = 0; i < m_jobs.size(); ++i)
                if (events[i + 2].revents != 0) cancel(m_jobs[i]);
            if (events[1].revents != 0) reap();
            // Children die with this process.
            if (events[0].revents != 0 && !begin()) return 0;
        }
    }

  private:
    bool begin() {
        auto request = std::make_unique<Request>();
        if (!receive(*request)) return false;
        Descriptor control = request->takeControl();
        // Descriptors are missing where they exceed the limit of this process.
        int problem = request->complete() ? 0 : EMFILE;
        try {
            if (problem == 0) {
                request->readTransfer();
                m_jobs.push_back(started(std::move(request)));
            }
        } catch (const std::system_error& error) {
            problem = error.code().value();
        }
        if (problem != 0)
            refuse(control, problem);
        else
            m_jobs.back().control = std::move(control);
        return true;
    }
    /// Starts a child. Throws std::system_error.
    Job started(std::unique_ptr<Request> request) {
        if (m_pictures == nullptr && !request->mayDoWithoutOpenVdb()) loadOpenVdb();
        const pid_t self = ::getpid();
        Job job{forked([&]() -> int { runChild(*request, m_pictures, self); }), Descriptor(), nullptr};
        if (m_pictures == nullptr && request->isForFields() && !triedOpenVdb()) job.again = std::move(request);
        return job;
    }
    /// Reports the problem. Without a control descriptor, the waiting process will report that this program is lost.
    static void refuse(const Descriptor& control, int problem) {
        LoadAnswer answer;
        answer.problem = problem;
        tell(control, answer);
    }
    static void tell(const Descriptor& control, const LoadAnswer& answer) {
        if (control.fd() >= 0) (void)::send(control.fd(), &answer, sizeof answer, MSG_NOSIGNAL);
    }
    /// Ends a job for which nobody waits any more.
    static void cancel(Job& job) {
        job.child.signal(SIGKILL);
        job.control = Descriptor();
    }
    void reap() {
        signalfd_siginfo ignored;
        while (::read(m_ended, &ignored, sizeof ignored) > 0) {
        }
        for (Job& job : m_jobs)
            if (const auto end = job.child.ended()) finish(job, *end);
        std::erase_if(m_jobs, [](const Job& job) { return job.ended; });
    }
    void finish(Job& job, const ChildProcess::End& end) {
        LoadAnswer answer;
        answer.status = end.status;
        answer.microseconds = end.used.count();
        job.ended = true;
        if (job.again && WIFEXITED(end.status) && WEXITSTATUS(end.status) == kNeedsOpenVdb) try {
                loadOpenVdb();
                Descriptor control = std::move(job.control);
                if (control.fd() < 0) return;
                job = started(std::move(job.again));
                job.control = std::move(control);
                return;
            } catch (const std::system_error& error) {
                answer.problem = error.code().value();
            }
        tell(job.control, answer);
    }

    const PictureModule* m_pictures;
    int m_ended = -1;
    std::vector<Job> m_jobs;
};

}  // namespace
}  // namespace scrim::load

int main(int argc, char** argv) {
    using namespace scrim::load;
    const std::string_view mode = argc >= 2 ? argv[1] : "";
    scrim::openStandardStreams();
    ::clearenv();
    // Signals from a terminal are meant for the waiting process, which then closes the socket.
    for (const int signal : {SIGINT, SIGQUIT, SIGHUP}) std::signal(signal, SIG_IGN);
    if (mode == "--serve-pictures" && argc == 3) {
        const scrim::PictureModule* pictures = loadPictureModule(argv[2]);
        return pictures == nullptr ? 1 : Server(pictures).serve();
    }
    if (argc == 2 && (mode == "--check" || mode == "--serve")) {
        prepareToRead();
        // A sanitizer's copies of this process must wait for OpenVDB's threads.
        if (!hasFilter()) loadOpenVdb();
        if (mode == "--check") return checkConfinement() ? 0 : 1;
        return Server(nullptr).serve();
    }
    std::fputs(
        "scrim-load: reads volumes and pictures for the library scrim, which starts it; --check checks its "
        "confinement\n",
        stderr);
    return kUsage;
}
