// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/atomic_file.h>

#include <scrim/base/system_error.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <charconv>
#include <climits>
#include <csignal>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>

namespace scrim {

namespace {

// The registry is the only global of this folder, because a signal handler cannot receive an argument. A slot is
// written by its owner while `claimed`, and read by a handler only while `active`.
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

/// Returns the slot that now holds `path`; negative where there is no room.
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

Error cannotWrite(const std::string& path, const std::string& why) {
    return Error(ErrorKind::output, fmt::format("cannot write '{}': {}", path, why));
}

Error cannotWrite(const std::string& path, int errorNumber) {
    return Error(kindOfSystemError(errorNumber, ErrorKind::output),
                 fmt::format("cannot write '{}': {}", path, systemErrorText(errorNumber)));
}

std::string hostName() {
    std::array<char, 65> name{};
    if (::gethostname(name.data(), name.size() - 1) != 0) return "host";
    return name.data();
}

constexpr std::string_view kTempPrefix = ".scrim-";

/// A hidden file name in the folder of `path`, different at each call. Host, process and count distinguish machines
/// that share the folder.
std::string tempPathFor(const std::filesystem::path& path) {
    static std::atomic<unsigned> count{0};
    const std::string name =
        fmt::format("{}{}-{}-{}{}", kTempPrefix, hostName(), ::getpid(), count.fetch_add(1), path.extension().string());
    return (path.parent_path() / name).string();
}

/// The writer of a temporary file, parsed from the file's name.
struct TempWriter {
    std::string_view host;
    pid_t process = 0;
};

std::optional<TempWriter> writerIn(std::string_view name) {
    if (!name.starts_with(kTempPrefix)) return std::nullopt;
    name.remove_prefix(kTempPrefix.size());
    const std::size_t count = name.rfind('-');  // host names may contain further ones
    if (count == std::string_view::npos || count == 0) return std::nullopt;
    const std::size_t process = name.rfind('-', count - 1);
    if (process == std::string_view::npos) return std::nullopt;
    TempWriter writer{name.substr(0, process), 0};
    const char* const end = name.data() + count;
    const auto [stop, error] = std::from_chars(name.data() + process + 1, end, writer.process);
    if (error != std::errc() || stop != end || writer.process <= 0) return std::nullopt;
    return writer;
}

/// True if the writer of a temporary file is gone. It held a lock while it was alive, but some file systems know no
/// locks, or not those of other machines; then the file's age decides.
bool isAbandoned(const std::string& path, const TempWriter& writer) {
    constexpr std::time_t kDay = 24 * 60 * 60;
    struct stat status {};
    const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (file < 0) return false;
    const bool locked = ::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    const bool known = ::fstat(file, &status) == 0 && S_ISREG(status.st_mode);
    ::close(file);
    if (locked || !known) return false;
    if (std::time(nullptr) - status.st_mtime > kDay) return true;
    const bool gone = writer.process == ::getpid() || (::kill(writer.process, 0) != 0 && errno == ESRCH);
    return writer.host == hostName() && gone;
}

void checkPlace(const std::string& path) {
    if (path.empty()) throw cannotWrite(path, "the name is empty");
    struct stat status {};
    if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
        throw cannotWrite(path, S_ISDIR(status.st_mode) ? "it is a folder" : "it is not a regular file");
}

/// Flushes `path` to disk. It is not an error if the file system cannot do that (EINVAL, ENOTSUP).
int syncFile(const std::string& path, int flags) {
    const int file = ::open(path.c_str(), flags | O_CLOEXEC);
    if (file < 0) return errno;
    const int error = ::fsync(file) == 0 ? 0 : errno;
    ::close(file);
    return error == EINVAL || error == ENOTSUP ? 0 : error;
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : m_path(std::move(path)) {
    checkPlace(m_path);
    try {
        open();
    } catch (const Error&) {
        removeMadeFolders();
        throw;
    }
    (void)::flock(m_file, LOCK_EX | LOCK_NB);  // shows others that this writer is alive
    m_slot = remember(m_tempPath);
}

void AtomicFile::open() {
    // The name may exist, as the leftover of a killed process whose id was reused. And the folder may have vanished,
    // together with the process that had made it and then wrote nothing.
    constexpr int kAttempts = 1000;
    int error = EEXIST;
    for (int attempt = 0; attempt < kAttempts && (error == EEXIST || error == ENOENT); ++attempt) {
        makeFolders();
        m_tempPath = tempPathFor(m_path);
        m_file = aboveStandardStreams(::open(m_tempPath.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
        error = m_file < 0 ? errno : 0;
    }
    if (error != 0) throw cannotWrite(m_path, error);
}

/// Makes the file's folder, and the folders above it that are missing.
void AtomicFile::makeFolders() {
    std::filesystem::path place;
    for (const std::filesystem::path& part : std::filesystem::path(m_path).parent_path()) {
        place /= part;
        struct stat status {};
        if (::stat(place.c_str(), &status) == 0) {
            if (!S_ISDIR(status.st_mode))
                throw cannotWrite(m_path, fmt::format("'{}' is not a folder", place.string()));
        } else if (::mkdir(place.c_str(), 0777) == 0) {
            m_madeFolders.push_back(place.string());
        } else if (errno != EEXIST) {  // EEXIST: another process has just made it
            throw cannotWrite(m_path,
                              fmt::format("cannot make the folder '{}': {}", place.string(), systemErrorText(errno)));
        }
    }
}

AtomicFile::~AtomicFile() {
    ::close(m_file);
    if (!m_committed) {
        ::unlink(m_tempPath.c_str());
        removeMadeFolders();
    }
    forget(m_slot);
}

void AtomicFile::removeMadeFolders() noexcept {
    // Folders that are no longer empty stay.
    for (auto folder = m_madeFolders.rbegin(); folder != m_madeFolders.rend(); ++folder) ::rmdir(folder->c_str());
}

void AtomicFile::commit() {
    assert(!m_committed);
    if (const int error = syncFile(m_tempPath, O_RDONLY)) throw cannotWrite(m_path, error);
    if (::rename(m_tempPath.c_str(), m_path.c_str()) != 0) throw cannotWrite(m_path, errno);
    m_committed = true;
    // The new name is on disk only after its folder has been flushed; if that fails, the file is still complete.
    const std::string folder = std::filesystem::path(m_path).parent_path().string();
    syncFile(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY);
}

void removeAbandonedFiles(const std::string& folder) noexcept {
    try {
        std::error_code error;
        std::filesystem::directory_iterator entry(folder.empty() ? "." : folder, error), end;
        for (; !error && entry != end; entry.increment(error)) {
            const std::string name = entry->path().filename().string();
            const auto writer = writerIn(name);
            if (writer && isAbandoned(entry->path().string(), *writer)) ::unlink(entry->path().c_str());
        }
    } catch (const std::exception&) {  // removing leftovers is optional
    }
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
    if (error != 0) throw cannotWrite(path, error);
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
