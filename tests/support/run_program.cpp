// SPDX-License-Identifier: Apache-2.0
#include "support/run_program.h"

#include <cerrno>
#include <csignal>
#include <stdexcept>
#include <thread>

#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace scrim::test {
namespace {

std::vector<char*> pointersTo(std::vector<std::string>& texts) {
    std::vector<char*> pointers;
    for (std::string& text : texts) pointers.push_back(text.data());
    pointers.push_back(nullptr);
    return pointers;
}

std::vector<std::string> environmentWith(const ProgramOptions& options) {
    std::vector<std::string> all;
    const auto isSet = [&](const std::string& entry) {
        for (const auto& [name, value] : options.environment)
            if (entry.rfind(name + "=", 0) == 0) return true;
        return entry.rfind("OCIO=", 0) == 0;
    };
    for (char** entry = environ; *entry != nullptr; ++entry)
        if (!isSet(*entry)) all.emplace_back(*entry);
    for (const auto& [name, value] : options.environment) all.push_back(name + "=" + value);
    return all;
}

std::string contentOf(int fd) {
    struct stat status {};
    ::fstat(fd, &status);
    std::string text(static_cast<std::size_t>(status.st_size), '\0');
    const ssize_t got = ::pread(fd, text.data(), text.size(), 0);
    text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return text;
}

}  // namespace

std::string ProgramResult::lastErrorLine() const {
    std::string text = err;
    while (!text.empty() && text.back() == '\n') text.pop_back();
    const std::size_t newline = text.rfind('\n');
    return newline == std::string::npos ? text : text.substr(newline + 1);
}

RunningProgram::RunningProgram(const std::string& folder, const std::vector<std::string>& arguments,
                               const ProgramOptions& options)
    : m_deadline(std::chrono::steady_clock::now() + options.timeout),
      m_out(::memfd_create("stdout", MFD_CLOEXEC)),
      m_err(::memfd_create("stderr", MFD_CLOEXEC)) {
    std::vector<std::string> argv;
    if (!options.shell.empty()) argv = {"/bin/sh", "-c", options.shell};
    argv.emplace_back(SCRIM_PROGRAM);
    argv.insert(argv.end(), arguments.begin(), arguments.end());
    std::vector<std::string> environment = environmentWith(options);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", 0, 0);
    posix_spawn_file_actions_adddup2(&actions, m_out, 1);
    posix_spawn_file_actions_adddup2(&actions, m_err, 2);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setpgroup(&attributes, 0);  // its own, where the flag says that there is one
    if (options.ownGroup) posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    const int error = ::posix_spawn(&m_pid, argv.front().c_str(), &actions, &attributes, pointersTo(argv).data(),
                                    pointersTo(environment).data());
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw std::runtime_error("cannot start " SCRIM_PROGRAM);
    m_id = m_pid;
}

RunningProgram::~RunningProgram() {
    if (m_pid > 0) {
        ::kill(m_pid, SIGKILL);
        ::waitpid(m_pid, nullptr, 0);
    }
    ::close(m_out);
    ::close(m_err);
}

bool RunningProgram::ended() {
    if (m_pid > 0 && ::waitpid(m_pid, &m_waitStatus, WNOHANG) == m_pid) m_pid = -1;
    return m_pid <= 0;
}

void RunningProgram::sendSignal(int signal) const {
    ::kill(m_pid, signal);
}

bool RunningProgram::waitForOutput(const std::string& text) {
    while (std::chrono::steady_clock::now() < m_deadline) {
        const bool over = ended();
        if (contentOf(m_out).find(text) != std::string::npos) return true;
        if (over) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
}

ProgramResult RunningProgram::wait() {
    ProgramResult result;
    result.pid = m_id;
    while (!ended()) {
        if (!result.timedOut && std::chrono::steady_clock::now() > m_deadline) {
            result.timedOut = true;
            sendSignal(SIGKILL);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    if (WIFEXITED(m_waitStatus)) result.status = WEXITSTATUS(m_waitStatus);
    if (WIFSIGNALED(m_waitStatus)) result.signal = WTERMSIG(m_waitStatus);
    result.out = contentOf(m_out);
    result.err = contentOf(m_err);
    return result;
}

ProgramResult runProgram(const std::string& folder, const std::vector<std::string>& arguments,
                         const ProgramOptions& options) {
    return RunningProgram(folder, arguments, options).wait();
}

}  // namespace scrim::test
