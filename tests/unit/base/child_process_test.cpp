// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/child_process.h>

#include <scrim/base/descriptor.h>
#include <scrim/base/process_limits.h>

#include <gtest/gtest.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace scrim {
namespace {

/// What /bin/sh writes on standard output, and how it ends.
std::pair<std::string, ChildProcess::End> shell(const std::string& script, std::vector<std::string> variables = {}) {
    int ends[2];
    EXPECT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    const Descriptor ours(ends[0]);
    Descriptor theirs(ends[1]);
    ChildProcess child({{"sh", "-c", script}, "", {{0, ProgramStart::kNothing}, {1, theirs.fd()}}, variables}, 0);
    theirs = Descriptor();
    std::string text;
    char part[256];
    for (ssize_t count; (count = ::read(ours.fd(), part, sizeof part)) > 0;) text.append(part, std::size_t(count));
    return {text, child.wait()};
}

TEST(ChildProcess, GetsItsArgumentsDescriptorsAndVariables) {
    const auto [text, end] = shell("read line; echo \"$? $NAME\"; exit 7", {"NAME=a value"});
    EXPECT_EQ(text, "1 a value\n");
    EXPECT_TRUE(WIFEXITED(end.status));
    EXPECT_EQ(WEXITSTATUS(end.status), 7);
}

TEST(ChildProcess, ThatCannotBeStartedSaysWhy) {
    for (const std::string path : {"/no/such/program", ""}) {
        try {
            const ChildProcess child({{"no-such-program"}, path, {}}, SIGTERM);
            ADD_FAILURE() << "started";
        } catch (const std::system_error& error) {
            EXPECT_EQ(error.code().value(), ENOENT);
        }
    }
}

TEST(ChildProcess, ToldItsEndKeepsIt) {
    ChildProcess child({{"sh", "-c", "exit 5"}, "", {}}, 0);
    EXPECT_EQ(WEXITSTATUS(child.wait().status), 5);
    EXPECT_EQ(WEXITSTATUS(child.wait().status), 5);
    EXPECT_TRUE(child.ended());
    child.signal(SIGKILL);  // reaches nobody
}

TEST(ChildProcess, EndsWithItsObject) {
    int ends[2];
    ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    const Descriptor ours(ends[0]);
    {
        Descriptor theirs(ends[1]);
        ChildProcess child({{"sleep", "600"}, "", {{1, theirs.fd()}}}, SIGTERM);
        theirs = Descriptor();
        EXPECT_FALSE(child.ended());
        ChildProcess moved = std::move(child);
        EXPECT_FALSE(moved.ended());
    }
    char byte = 0;
    EXPECT_EQ(::read(ours.fd(), &byte, 1), 0) << "a child that still runs keeps the pipe open";
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a child was not waited for";
}

TEST(ChildProcess, TellsTheTimeThatItUsed) {
    ChildProcess child({{"sh", "-c", "i=0; while [ $i -lt 100000 ]; do i=$((i+1)); done"}, "", {}}, SIGKILL);
    while (!child.ended()) std::this_thread::yield();
    EXPECT_GE(child.wait().used, std::chrono::milliseconds(1));
}

TEST(ProcessLimits, AreLoweredForGood) {
    const pid_t child = ::fork();
    if (child == 0) {
        const bool lowered = lowerLimit(RLIMIT_CPU, 100, 2) == 0 && lowerLimit(RLIMIT_CPU, 200) == 0;
        rlimit both{};
        ::getrlimit(RLIMIT_CPU, &both);
        ::_exit(lowered && limitOf(RLIMIT_CPU) == 100 && both.rlim_max == 100 ? 0 : 1);
    }
    EXPECT_EQ(ChildProcess(child, 0).wait().status, 0);
}

}  // namespace
}  // namespace scrim
