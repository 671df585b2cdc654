// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/atomic_file.h>

#include "support/temp_folder.h"

#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>

namespace {
bool knowsLocks = true;
}

/// The whole program's flock, by which a test plays a file system without locks.
extern "C" int flock(int file, int operation) noexcept {
    if (knowsLocks) return static_cast<int>(::syscall(SYS_flock, file, operation));
    errno = ENOLCK;
    return -1;
}

namespace scrim {
namespace {

std::string host() {
    std::string name(65, '\0');
    ::gethostname(name.data(), name.size() - 1);
    return name.c_str();
}

/// A process that has been, and is no more.
pid_t deadProcess() {
    const pid_t child = ::fork();
    if (child == 0) ::_exit(0);
    ::waitpid(child, nullptr, 0);
    return child;
}

std::string tempName(const std::string& of, pid_t process) {
    return ".scrim-" + of + "-" + std::to_string(process) + "-999999.exr";
}

void put(const std::string& path, std::chrono::hours age = std::chrono::hours(0)) {
    std::ofstream(path) << "half";
    std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now() - age);
}

TEST(AbandonedFiles, GoWhereTheirWriterIsGone) {
    const test::TempFolder folder;
    put(folder.file(tempName(host(), deadProcess())));
    put(folder.file(tempName(host(), ::getpid())));  // the number was given out again: to this process
    removeAbandonedFiles(folder.path());
    EXPECT_EQ(folder.entryCount(), 0u);
}

TEST(AbandonedFiles, StayWhileTheirWriterHoldsThem) {
    const test::TempFolder folder;
    const AtomicFile pending(folder.file("a.exr"));
    put(pending.tempPath(), std::chrono::hours(100));
    removeAbandonedFiles(folder.path());
    EXPECT_TRUE(std::filesystem::exists(pending.tempPath()));
}

TEST(AbandonedFiles, OfThisProcessStayWhereThereAreNoLocks) {
    const test::TempFolder folder;
    knowsLocks = false;
    const AtomicFile pending(folder.file("a.exr"));
    removeAbandonedFiles(folder.path());
    knowsLocks = true;
    EXPECT_TRUE(std::filesystem::exists(pending.tempPath()));
}

TEST(AbandonedFiles, StayForADayWhereTheirWriterMayBeThere) {
    const test::TempFolder folder;
    for (const std::string& name : {tempName(host(), ::getppid()), tempName("another-host", deadProcess())}) {
        put(folder.file(name), std::chrono::hours(23));
        removeAbandonedFiles(folder.path());
        EXPECT_TRUE(std::filesystem::exists(folder.file(name))) << name;
        put(folder.file(name), std::chrono::hours(25));
        removeAbandonedFiles(folder.path());
        EXPECT_FALSE(std::filesystem::exists(folder.file(name))) << name;
    }
}

TEST(AbandonedFiles, HaveNamesOfThisProgram) {
    const test::TempFolder folder;
    for (const char* name : {".scrim-", ".scrim-notes.txt", ".scrim-host-x1-0.exr", ".scrim-host-12.exr",
                             "scrim-host-12-0.exr", ".scrim-host-0-0.exr", "a.exr"})
        put(folder.file(name), std::chrono::hours(100));
    removeAbandonedFiles(folder.path());
    EXPECT_EQ(folder.entryCount(), 7u);
    removeAbandonedFiles(folder.file("no"));
}

}  // namespace
}  // namespace scrim
