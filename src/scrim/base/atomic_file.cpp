// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/atomic_file.h>

#include <scrim/base/file_identity.h>
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

// The registry is global because a signal handler cannot receive an argument. A slot is written by
// its owner while `claimed`, and read by a handler only while `active`.
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

/// A hidden file name in `folder`, different at each call. Host, process and count distinguish
/// machines that share the folder.
std::string tempPathIn(const std::filesystem::path& folder, const std::string& extension) {
    static std::atomic<unsigned> count{0};
    const std::string name =
        fmt::format("{}{}-{}-{}{}", kTempPrefix, hostName(), ::getpid(), count.fetch_add(1), extension);
    return (folder / name).string();
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

/// True if the writer of the temporary file `path`, open as `file`, is gone. It held a lock while it was alive, but
/// some file systems know no locks, or not those of other machines; then the file's age decides.
bool isAbandoned(int file, const TempWriter& writer) {
    constexpr std::time_t kDay = 24 * 60 * 60;
    struct stat status {};
    const int lockError = ::flock(file, LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
    if (lockError == EWOULDBLOCK || ::fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) return false;
    if (std::time(nullptr) - status.st_mtime > kDay) return true;
    if (writer.host != hostName()) return false;
    // A file of this process's number is this process's own, unless a lock would show that it is and does not.
    return writer.process == ::getpid() ? lockError == 0 : ::kill(writer.process, 0) != 0 && errno == ESRCH;
}

void removeIfAbandoned(const std::string& path, const TempWriter& writer) {
    const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (file < 0) return;
    // It is removed while this process holds its lock: whoever gets the lock next sees that the file is gone.
    if (isAbandoned(file, writer)) ::unlink(path.c_str());
    ::close(file);
}

/// Locks a file that was just made, to show others that its writer is alive. False if it was taken
/// for abandoned and removed before.
bool lockNew(int file) {
    while (::flock(file, LOCK_EX) != 0 && errno == EINTR) {
    }
    struct stat status {};
    return ::fstat(file, &status) != 0 || status.st_nlink > 0;
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

AtomicFile::AtomicFile(std::string path) : m_path(std::move(path)), m_target(linkTarget(m_path)) {
    checkPlace();
    try {
        open();
    } catch (const Error&) {
        removeMadeFolders();
        throw;
    }
    m_slot = remember(m_tempPath);
}

void AtomicFile::checkPlace() {
    if (m_path.empty()) throw cannotWrite(m_path, "the name is empty");
    struct stat status {};
    if (::stat(m_path.c_str(), &status) != 0) {
        // The system refuses links that lead in a circle, and those of strangers in folders that all may write to.
        if (errno == ELOOP || errno == EACCES) throw cannotWrite(m_path, errno);
        return;
    }
    if (!S_ISREG(status.st_mode))
        throw cannotWrite(m_path, S_ISDIR(status.st_mode) ? "it is a folder" : "it is not a regular file");
    m_replaced = {status.st_mode, status.st_uid, status.st_gid};
}

void AtomicFile::open() {
    // The name may exist, as the leftover of a killed process whose id was reused. And the folder
    // may have vanished, together with the process that had made it and then wrote nothing.
    constexpr int kAttempts = 1000;
    const mode_t mode = m_replaced ? 0600 : 0666;  // what few may read is shown to nobody else meanwhile
    const std::filesystem::path folder = std::filesystem::path(m_target).parent_path();
    const std::string extension = std::filesystem::path(m_path).extension().string();
    int error = EEXIST;
    for (int attempt = 0; attempt < kAttempts && (error == EEXIST || error == ENOENT); ++attempt) {
        makeFolders();
        m_tempPath = tempPathIn(folder, extension);
        m_file = aboveStandardStreams(::open(m_tempPath.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode));
        error = m_file < 0 ? errno : 0;
        if (error != 0 || lockNew(m_file)) continue;
        ::close(m_file);
        error = ENOENT;
    }
    if (error != 0) throw cannotWrite(m_path, error);
}

/// Makes the file's folder, and the folders above it that are missing.
void AtomicFile::makeFolders() {
    std::filesystem::path place;
    for (const std::filesystem::path& part : std::filesystem::path(m_target).parent_path()) {
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

/// Some file systems have no owners or permissions; a file on them is complete all the same.
void AtomicFile::handOnOwnership() const {
    if (!m_replaced) return;
    const auto keep = uid_t(-1);
    mode_t mode = m_replaced->mode & (S_IRWXU | S_IRWXG | S_IRWXO);
    if (::fchown(m_file, m_replaced->user, m_replaced->group) != 0 && ::fchown(m_file, keep, m_replaced->group) != 0)
        // The file's group is another one now. Its members get what all others got.
        mode = (mode & ~S_IRWXG) | (mode & S_IRWXO) << 3;
    (void)::fchmod(m_file, mode);
}

void AtomicFile::commit() {
    assert(!m_committed);
    if (const int error = syncFile(m_tempPath, O_RDONLY)) throw cannotWrite(m_path, error);
    handOnOwnership();
    if (::rename(m_tempPath.c_str(), m_target.c_str()) != 0) throw cannotWrite(m_path, errno);
    m_committed = true;
    // The new name is on disk only after its folder has been flushed; if that fails, the file is still complete.
    const std::string folder = std::filesystem::path(m_target).parent_path().string();
    syncFile(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY);
}

void removeAbandonedFiles(const std::string& folder) noexcept {
    try {
        std::error_code error;
        std::filesystem::directory_iterator entry(folder.empty() ? "." : folder, error), end;
        for (; !error && entry != end; entry.increment(error)) {
            const std::string name = entry->path().filename().string();
            const auto writer = writerIn(name);
            if (writer) removeIfAbandoned(entry->path().string(), *writer);
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
