// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/atomic_file.h>

#include <scrim/base/error.h>

#include "support/file_size_limit.h"
#include "support/temp_folder.h"

#include <gtest/gtest.h>
#include <grp.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <vector>

namespace scrim {
namespace {

void put(const std::string& path, const std::string& text) {
    std::ofstream(path) << text;
}

std::string content(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
}

std::string errorOfOpening(const std::string& path) {
    try {
        AtomicFile file(path);
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::output);
        return error.what();
    }
    return "no error";
}

TEST(AtomicFile, AppearsWholeOnCommit) {
    const test::TempFolder folder;
    const std::string path = folder.file("a.exr");
    {
        AtomicFile file(path);
        put(file.tempPath(), "new");
        EXPECT_FALSE(std::filesystem::exists(path));
        file.commit();
    }
    EXPECT_EQ(content(path), "new");
    EXPECT_EQ(folder.entryCount(), 1u);
}

TEST(AtomicFile, LeavesTheOldFileWithoutCommit) {
    const test::TempFolder folder;
    const std::string path = folder.file("a.exr");
    put(path, "old");
    {
        AtomicFile file(path);
        put(file.tempPath(), "half of the n");
    }
    EXPECT_EQ(content(path), "old");
    EXPECT_EQ(folder.entryCount(), 1u);
}

TEST(AtomicFile, ReplacesTheOldFileOnCommit) {
    const test::TempFolder folder;
    const std::string path = folder.file("a.exr");
    put(path, "old");
    AtomicFile file(path);
    put(file.tempPath(), "new");
    file.commit();
    EXPECT_EQ(content(path), "new");
}

TEST(AtomicFile, TempNameIsHiddenInTheSameFolderAndKeepsTheExtension) {
    const test::TempFolder folder;
    AtomicFile one(folder.file("a.0001.exr"));
    AtomicFile two(folder.file("a.0001.exr"));
    const std::filesystem::path temp = one.tempPath();
    EXPECT_EQ(temp.parent_path(), folder.path());
    EXPECT_EQ(temp.extension(), ".exr");
    EXPECT_EQ(temp.filename().string().front(), '.');
    EXPECT_NE(one.tempPath(), two.tempPath());
}

TEST(AtomicFile, StepsAsideForTheLeftoverOfAKilledProcess) {
    const test::TempFolder folder;
    std::string taken;
    {
        AtomicFile probe(folder.file("a.exr"));
        taken = probe.tempPath();
    }
    // The next name this process will try: the same with the count raised by one.
    const std::size_t dash = taken.rfind('-');
    const unsigned long count = std::stoul(taken.substr(dash + 1));
    put(taken.substr(0, dash + 1) + std::to_string(count + 1) + ".exr", "leftover");
    AtomicFile file(folder.file("a.exr"));
    EXPECT_EQ(content(file.tempPath()), "");
    EXPECT_EQ(folder.entryCount(), 2u);
}

TEST(AtomicFile, MakesMissingFolders) {
    const test::TempFolder folder;
    writeWholeFile(folder.file("a/b/c.exr"), "new");
    EXPECT_EQ(content(folder.file("a/b/c.exr")), "new");
    {
        const AtomicFile pending(folder.file("a/d/e/f.exr"));
        EXPECT_TRUE(std::filesystem::exists(folder.file("a/d/e")));
    }
    EXPECT_FALSE(std::filesystem::exists(folder.file("a/d"))) << "nothing was committed";
    EXPECT_TRUE(std::filesystem::exists(folder.file("a/b")));
}

TEST(AtomicFile, LeavesFoldersThatItMadeToOthersThatUseThem) {
    const test::TempFolder folder;
    auto first = std::make_unique<AtomicFile>(folder.file("a/first.exr"));
    AtomicFile second(folder.file("a/second.exr"));
    first.reset();
    second.commit();
    EXPECT_TRUE(std::filesystem::exists(folder.file("a/second.exr")));
}

TEST(AtomicFile, SaysWhichFolderCannotBeMade) {
    EXPECT_EQ(errorOfOpening("/proc/no/such/a.exr"),
              "cannot write '/proc/no/such/a.exr': cannot make the folder '/proc/no': No such file or directory");
}

TEST(AtomicFile, SaysThatTheFolderIsNone) {
    const test::TempFolder folder;
    put(folder.file("b"), "a file");
    EXPECT_EQ(errorOfOpening(folder.file("b/a.exr")),
              "cannot write '" + folder.file("b/a.exr") + "': '" + folder.file("b") + "' is not a folder");
}

TEST(AtomicFile, SaysThatTheFolderIsNotWritable) {
    if (::geteuid() == 0) {  // root may write anywhere but into the kernel's own trees
        EXPECT_EQ(errorOfOpening("/proc/self/a.exr"), "cannot write '/proc/self/a.exr': No such file or directory");
        return;
    }
    const test::TempFolder folder;
    ::chmod(folder.path().c_str(), 0500);
    EXPECT_EQ(errorOfOpening(folder.file("a.exr")), "cannot write '" + folder.file("a.exr") + "': Permission denied");
    ::chmod(folder.path().c_str(), 0700);
}

TEST(AtomicFile, RefusesToReplaceWhatIsNoRegularFile) {
    const test::TempFolder folder;
    EXPECT_EQ(errorOfOpening(folder.path()), "cannot write '" + folder.path() + "': it is a folder");
    EXPECT_EQ(errorOfOpening("/dev/null"), "cannot write '/dev/null': it is not a regular file");
    EXPECT_EQ(errorOfOpening(""), "cannot write '': the name is empty");
}

struct stat statusOf(const std::string& path) {
    struct stat status {};
    EXPECT_EQ(::stat(path.c_str(), &status), 0) << path;
    return status;
}

/// The permissions of the file at `path`, in octal digits.
std::string modeOf(const std::string& path) {
    std::ostringstream digits;
    digits << std::oct << (statusOf(path).st_mode & 07777);
    return digits.str();
}

TEST(AtomicFile, HandsOnPermissions) {
    const test::TempFolder folder;
    const std::string path = folder.file("a.exr");
    put(path, "old");
    for (const mode_t mode : {0600, 0640, 0664, 0777, 0444}) {
        ::chmod(path.c_str(), mode);
        const std::string before = modeOf(path);
        AtomicFile file(path);
        EXPECT_EQ(modeOf(file.tempPath()), "600") << "nobody else reads it meanwhile";
        put(file.tempPath(), "new");
        file.commit();
        EXPECT_EQ(modeOf(path), before);
    }
    EXPECT_EQ(content(path), "new");
}

TEST(AtomicFile, GivesNewFilesThePermissionsOfTheUsersMask) {
    const test::TempFolder folder;
    const mode_t mask = ::umask(027);
    writeWholeFile(folder.file("a.exr"), "new");
    ::umask(mask);
    EXPECT_EQ(modeOf(folder.file("a.exr")), "640");
}

TEST(AtomicFile, HandsOnOwners) {
    if (::geteuid() != 0) GTEST_SKIP() << "only root gives files away";
    const test::TempFolder folder;
    const std::string path = folder.file("a.exr");
    put(path, "old");
    ASSERT_EQ(::chown(path.c_str(), 4321, 1234), 0);
    ::chmod(path.c_str(), 0640);
    writeWholeFile(path, "new");
    EXPECT_EQ(statusOf(path).st_uid, 4321u);
    EXPECT_EQ(statusOf(path).st_gid, 1234u);
    EXPECT_EQ(modeOf(path), "640");
}

TEST(AtomicFile, OpensToNoGroupWhatAnotherGroupMayRead) {
    if (::geteuid() != 0) GTEST_SKIP() << "only root can play two users";
    const test::TempFolder folder;
    const std::string path = folder.file("a.exr");
    put(path, "old");
    ::chmod(path.c_str(), 0660);
    ::chmod(folder.path().c_str(), 0777);
    const pid_t child = ::fork();
    if (child == 0) {
        const bool dropped = ::setgroups(0, nullptr) == 0 && ::setgid(65534) == 0 && ::setuid(65534) == 0;
        if (dropped) writeWholeFile(path, "new");
        ::_exit(dropped ? 0 : 1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_EQ(status, 0);
    EXPECT_EQ(content(path), "new");
    EXPECT_EQ(statusOf(path).st_gid, 65534u);
    EXPECT_EQ(modeOf(path), "600");
}

TEST(AtomicFile, WritesThroughSymbolicLinks) {
    const test::TempFolder folder;
    std::filesystem::create_directory(folder.file("real"));
    put(folder.file("real/a.exr"), "old");
    std::filesystem::create_symlink("real/a.exr", folder.file("one.exr"));
    std::filesystem::create_symlink(folder.file("one.exr"), folder.file("two.exr"));
    {
        AtomicFile file(folder.file("two.exr"));
        EXPECT_EQ(std::filesystem::path(file.tempPath()).parent_path(), folder.file("real")) << "it is renamed there";
        put(file.tempPath(), "new");
        file.commit();
    }
    EXPECT_TRUE(std::filesystem::is_symlink(folder.file("one.exr")));
    EXPECT_TRUE(std::filesystem::is_symlink(folder.file("two.exr")));
    EXPECT_FALSE(std::filesystem::is_symlink(folder.file("real/a.exr")));
    EXPECT_EQ(content(folder.file("real/a.exr")), "new");
}

TEST(AtomicFile, MakesTheFileToWhichALinkLeads) {
    const test::TempFolder folder;
    std::filesystem::create_symlink("no/such/b.exr", folder.file("a.exr"));
    { const AtomicFile pending(folder.file("a.exr")); }
    EXPECT_EQ(folder.entryCount(), 1u) << "the link alone";
    writeWholeFile(folder.file("a.exr"), "new");
    EXPECT_TRUE(std::filesystem::is_symlink(folder.file("a.exr")));
    EXPECT_EQ(content(folder.file("no/such/b.exr")), "new");
}

TEST(AtomicFile, RefusesLinksThatLeadInACircle) {
    const test::TempFolder folder;
    std::filesystem::create_symlink("b.exr", folder.file("a.exr"));
    std::filesystem::create_symlink("a.exr", folder.file("b.exr"));
    EXPECT_EQ(errorOfOpening(folder.file("a.exr")),
              "cannot write '" + folder.file("a.exr") + "': Too many levels of symbolic links");
    EXPECT_TRUE(std::filesystem::is_symlink(folder.file("a.exr")));
}

TEST(AtomicFile, CommitSaysWhyItFailed) {
    const test::TempFolder folder;
    AtomicFile file(folder.file("a.exr"));
    std::filesystem::remove(file.tempPath());
    try {
        file.commit();
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::output);
        EXPECT_EQ(std::string(error.what()), "cannot write '" + folder.file("a.exr") + "': No such file or directory");
    }
}

TEST(AtomicFile, WritesWholeFiles) {
    const test::TempFolder folder;
    const std::string path = folder.file("a.csv");
    writeWholeFile(path, std::string_view("a\0b", 3));
    EXPECT_EQ(content(path), std::string("a\0b", 3));
    const test::FileSizeLimit full(1000);
    try {
        writeWholeFile(path, std::string(5000, 'x'));
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()),
                  "cannot write '" + path + "': File too large; raise the limit (ulimit -f)");
    }
    EXPECT_EQ(content(path).size(), 3u);
    EXPECT_EQ(folder.entryCount(), 1u);
}

TEST(AtomicFile, UncommittedFilesCanBeRemovedAtOnce) {
    const test::TempFolder folder;
    AtomicFile committed(folder.file("done.exr"));
    committed.commit();
    AtomicFile pending(folder.file("pending.exr"));
    removeUncommittedFiles();
    EXPECT_TRUE(std::filesystem::exists(folder.file("done.exr")));
    EXPECT_FALSE(std::filesystem::exists(pending.tempPath()));
    EXPECT_EQ(folder.entryCount(), 1u);
}

TEST(AtomicFile, WorksBeyondTheRegistrysSize) {
    const test::TempFolder folder;
    std::vector<std::unique_ptr<AtomicFile>> files;
    for (int i = 0; i < 70; ++i) files.push_back(std::make_unique<AtomicFile>(folder.file(std::to_string(i) + ".exr")));
    EXPECT_EQ(folder.entryCount(), 70u);
    files.clear();
    EXPECT_EQ(folder.entryCount(), 0u);
}

TEST(AtomicFile, AForkedChildLeavesItsParentsFilesAlone) {
    const test::TempFolder folder;
    AtomicFile pending(folder.file("pending.exr"));
    const pid_t child = ::fork();
    if (child == 0) {
        removeUncommittedFiles();
        ::_exit(0);
    }
    ASSERT_GT(child, 0);
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    EXPECT_TRUE(std::filesystem::exists(pending.tempPath()));
}

}  // namespace
}  // namespace scrim
