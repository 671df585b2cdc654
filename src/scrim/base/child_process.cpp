// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/child_process.h>

#include <cerrno>
#include <csignal>
#include <system_error>

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace scrim {
namespace {

[[noreturn]] void fail(int error) {
    throw std::system_error(error, std::generic_category());
}

/// What the program's descriptors are made of.
class SpawnActions {
  public:
    explicit SpawnActions(const std::vector<std::pair<int, int>>& descriptors) {
        ::posix_spawn_file_actions_init(&m_actions);
        for (const auto& [theirs, ours] : descriptors) {
            const int error = ours == ProgramStart::kNothing
                                  ? ::posix_spawn_file_actions_addopen(&m_actions, theirs, "/dev/null",
                                                                       theirs == STDIN_FILENO ? O_RDONLY : O_WRONLY, 0)
                                  : ::posix_spawn_file_actions_adddup2(&m_actions, ours, theirs);
            if (m_problem == 0) m_problem = error;
        }
    }
    ~SpawnActions() { ::posix_spawn_file_actions_destroy(&m_actions); }
    SpawnActions(const SpawnActions&) = delete;
    SpawnActions& operator=(const SpawnActions&) = delete;

    const posix_spawn_file_actions_t* get() const { return &m_actions; }
    int problem() const { return m_problem; }

  private:
    posix_spawn_file_actions_t m_actions{};
    int m_problem = 0;
};

/// Pointers to `words`, with a null at the end.
std::vector<char*> pointersTo(std::vector<std::string>& words) {
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    return pointers;
}

std::vector<std::string> environmentWith(const std::vector<std::string>& more) {
    std::vector<std::string> all;
    for (char** variable = environ; *variable != nullptr; ++variable) all.emplace_back(*variable);
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

}  // namespace

ChildProcess::ChildProcess(const ProgramStart& start, int endSignal) : m_endSignal(endSignal) {
    const SpawnActions actions(start.descriptors);
    if (actions.problem() != 0) fail(actions.problem());
    std::vector<std::string> words = start.arguments, variables = environmentWith(start.variables);
    const auto arguments = pointersTo(words), environment = pointersTo(variables);
    const int error =
        start.path.empty()
            ? ::posix_spawnp(&m_pid, arguments[0], actions.get(), nullptr, arguments.data(), environment.data())
            : ::posix_spawn(&m_pid, start.path.c_str(), actions.get(), nullptr, arguments.data(), environment.data());
    if (error == 0) return;
    m_pid = -1;
    fail(error);
}

ChildProcess::~ChildProcess() {
    if (m_pid < 0 || m_end) return;
    if (m_endSignal != 0) signal(m_endSignal);
    reap(0);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : m_pid(std::exchange(other.m_pid, -1)), m_endSignal(other.m_endSignal), m_end(other.m_end) {}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
    std::swap(m_pid, other.m_pid);
    std::swap(m_endSignal, other.m_endSignal);
    std::swap(m_end, other.m_end);
    return *this;
}

void ChildProcess::signal(int number) const {
    if (m_pid > 0 && !m_end) ::kill(m_pid, number);
}

ChildProcess::End ChildProcess::wait() {
    reap(0);
    return m_end.value_or(End{});
}

std::optional<ChildProcess::End> ChildProcess::ended() {
    reap(WNOHANG);
    return m_end;
}

/// Learns of the end, if it is there. An application that ignores SIGCHLD lets no end be known.
void ChildProcess::reap(int options) {
    if (m_pid < 0 || m_end) return;
    int status = 0;
    rusage used{};
    pid_t ended = 0;
    do ended = ::wait4(m_pid, &status, options, &used);
    while (ended < 0 && errno == EINTR);
    if (ended == 0) return;
    const auto time = [](const timeval& t) {
        return std::chrono::seconds(t.tv_sec) + std::chrono::microseconds(t.tv_usec);
    };
    m_end = ended < 0 ? End{} : End{status, time(used.ru_utime) + time(used.ru_stime)};
}

}  // namespace scrim
