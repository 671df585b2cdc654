// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/atomic_file.h>

#include <scrim/base/error.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <climits>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace scrim {

namespace {

// The registry is the one global of this folder: a signal handler has nothing else it could be handed. A slot
// is written by its owner while `claimed`, and read by a handler only while `active`.
enum SlotState : int { kFree, kClaimed, kActive };

struct Slot {
    std::atomic<int> state{kFree};
    pid_t owner = 0;
    std::array<char, PATH_MAX> path{};
};

static_assert(std::atomic<int>::is_always_lock_free, "signal handlers read the slots' states");

constexpr int kSlotCount = 64;
std::array<Slot, kSlotCount> g_uncommitted;

Slot& slotAt(int index) {
    return g_uncommitted[index];
}

/// The slot that now holds `path`; negative where there is no room.
int remember(const std::string& path) {
    if (path.size() >= PATH_MAX) return -1;
    for (int i = 0; i < kSlotCount; ++i) {
        int expected = kFree;
        if (!slotAt(i).state.compare_exchange_strong(expected, kClaimed)) continue;
        std::memcpy(slotAt(i).path.data(), path.c_str(), path.size() + 1);
        slotAt(i).owner = ::getpid();
        slotAt(i).state.store(kActive);
        return i;
    }
    return -1;
}

void forget(int slot) {
    if (slot >= 0) slotAt(slot).state.store(kFree);
}

std::string reason(int errorNumber) {
    return std::generic_category().message(errorNumber);
}

Error cannotWrite(const std::string& path, const std::string& why) {
    return Error(ErrorKind::output, fmt::format("cannot write '{}': {}", path, why));
}

std::string hostName() {
    std::array<char, 65> name{};
    if (::gethostname(name.data(), name.size() - 1) != 0) return "host";
    return name.data();
}

/// A hidden name in the folder of `path`, another one at each call. Host, process and count keep machines
/// that share the folder apart.
std::string tempPathFor(const std::filesystem::path& path) {
    static std::atomic<unsigned> count{0};
    const std::string name =
        fmt::format(".scrim-{}-{}-{}{}", hostName(), ::getpid(), count.fetch_add(1), path.extension().string());
    return (path.parent_path() / name).string();
}

void checkPlace(const std::string& path) {
    if (path.empty()) throw cannotWrite(path, "the name is empty");
    const std::string folder = std::filesystem::path(path).parent_path().string();
    struct stat status {};
    if (!folder.empty() && ::stat(folder.c_str(), &status) != 0) {
        const int error = errno;
        throw cannotWrite(path, error == ENOENT ? fmt::format("the folder '{}' does not exist", folder)
                                                : fmt::format("the folder '{}': {}", folder, reason(error)));
    }
    if (!folder.empty() && !S_ISDIR(status.st_mode))
        throw cannotWrite(path, fmt::format("'{}' is not a folder", folder));
    if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
        throw cannotWrite(path, S_ISDIR(status.st_mode) ? "it is a folder" : "it is not a regular file");
}

/// Flushes `path` to the disk. File systems that cannot do that (EINVAL, ENOTSUP) are not an error.
int syncFile(const std::string& path, int flags) {
    const int file = ::open(path.c_str(), flags | O_CLOEXEC);
    if (file < 0) return errno;
    const int error = ::fsync(file) == 0 ? 0 : errno;
    ::close(file);
    return error == EINVAL || error == ENOTSUP ? 0 : error;
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : m_path(std::move(path)), m_slot(-1) {
    checkPlace(m_path);
    // A name can be taken: by the leftover of a killed process whose id was given out again.
    constexpr int kAttempts = 1000;
    int error = EEXIST;
    for (int attempt = 0; attempt < kAttempts && error == EEXIST; ++attempt) {
        m_tempPath = tempPathFor(m_path);
        const int file = ::open(m_tempPath.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        error = file < 0 ? errno : 0;
        if (file >= 0) ::close(file);
    }
    if (error != 0) throw cannotWrite(m_path, reason(error));
    m_slot = remember(m_tempPath);
}

AtomicFile::~AtomicFile() {
    if (!m_committed) ::unlink(m_tempPath.c_str());
    forget(m_slot);
}

void AtomicFile::commit() {
    assert(!m_committed);
    if (const int error = syncFile(m_tempPath, O_RDONLY)) throw cannotWrite(m_path, reason(error));
    if (::rename(m_tempPath.c_str(), m_path.c_str()) != 0) throw cannotWrite(m_path, reason(errno));
    m_committed = true;
    // The name is on the disk only once its folder is; where that fails the file is still whole.
    const std::string folder = std::filesystem::path(m_path).parent_path().string();
    syncFile(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY);
}

void writeWholeFile(const std::string& path, std::string_view bytes) {
    AtomicFile file(path);
    const int out = ::open(file.tempPath().c_str(), O_WRONLY | O_CLOEXEC);
    int error = out < 0 ? errno : 0;
    while (error == 0 && !bytes.empty()) {
        const ssize_t written = ::write(out, bytes.data(), bytes.size());
        if (written >= 0)
            bytes.remove_prefix(std::size_t(written));
        else if (errno != EINTR)
            error = errno;
    }
    if (out >= 0 && ::close(out) != 0 && error == 0) error = errno;
    if (error != 0) throw cannotWrite(path, reason(error));
    file.commit();
}

void removeUncommittedFiles() noexcept {
    const int error = errno;
    const pid_t self = ::getpid();
    for (Slot& slot : g_uncommitted)
        if (slot.state.load() == kActive && slot.owner == self) ::unlink(slot.path.data());
    errno = error;
}

}  // namespace scrim
