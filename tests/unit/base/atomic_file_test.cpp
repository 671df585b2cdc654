// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/atomic_file.h>

#include <scrim/base/error.h>

#include "support/file_size_limit.h"
#include "support/temp_folder.h"

#include <gtest/gtest.h>
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
