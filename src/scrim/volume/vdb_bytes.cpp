// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_bytes.h>

#include <scrim/base/system_error.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace scrim {

namespace {

constexpr std::uint32_t kLongestText = 1 << 20;  ///< bytes; a longer text is no name and not worth its memory

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
    throw Error(ErrorKind::input, shortened(path + ": " + reason, 1000));
}

[[noreturn]] void failToOpen(const std::string& path, int error) {
    throw Error(kindOfSystemError(error, ErrorKind::input),
                shortened(path + ": " + (error == ENOENT ? "no such file" : systemErrorText(error)), 1000));
}

std::uint64_t sizeOfRegularFile(int file, const std::string& path) {
    if (file < 0) failToOpen(path, errno);
    struct stat status {};
    if (::fstat(file, &status) != 0) fail(path, std::strerror(errno));
    if (S_ISDIR(status.st_mode)) fail(path, "is a folder, not a VDB file");
    if (!S_ISREG(status.st_mode)) fail(path, "is not a regular file");
    return static_cast<std::uint64_t>(status.st_size);
}

}  // namespace

VdbBytes::VdbBytes(const std::string& path)
    // Without O_NONBLOCK, opening a FIFO would wait for a writer.
    : VdbBytes(path, aboveStandardStreams(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK))) {}

VdbBytes::VdbBytes(const std::string& path, int file) : m_path(path), m_file(file) {
    try {
        m_size = sizeOfRegularFile(m_file, path);
    } catch (...) {
        if (m_file >= 0) ::close(m_file);
        throw;
    }
}

VdbBytes::VdbBytes(const std::string& path, std::span<const char> bytes)
    : m_path(path), m_memory(bytes.data()), m_size(bytes.size()) {}

VdbBytes::~VdbBytes() {
    if (m_file >= 0) ::close(m_file);
}

void VdbBytes::copy(std::uint64_t at, std::uint64_t count, char* to) const {
    if (count == 0) return;
    if (m_file < 0) {
        std::memcpy(to, m_memory + at, count);
        return;
    }
    if (count > m_window.size()) return read(at, count, to);
    if (at < m_windowAt || at + count > m_windowAt + m_windowSize) {
        m_windowSize = 0;  // in case the next line throws
        const std::uint64_t size = std::min<std::uint64_t>(m_window.size(), m_size - at);
        read(at, size, m_window.data());
        m_windowAt = at;
        m_windowSize = size;
    }
    std::memcpy(to, m_window.data() + (at - m_windowAt), count);
}

void VdbBytes::read(std::uint64_t at, std::uint64_t count, char* to) const {
    while (count > 0) {
        const ssize_t got = ::pread(m_file, to, count, static_cast<off_t>(at));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail(m_path, std::strerror(errno));
        if (got == 0) fail(m_path, "truncated or damaged: it shrank while it was read");
        at += static_cast<std::uint64_t>(got);
        to += got;
        count -= static_cast<std::uint64_t>(got);
    }
}

std::string VdbWalker::text(const char* what) {
    const auto size = number<std::uint32_t>(what);
    need(size, what);
    if (size > kLongestText) damaged(fmt::format("{} at byte {} claims {} bytes", what, m_at, size));
    std::string value(size, '\0');
    m_bytes.copy(m_at, size, value.data());
    m_at += size;
    return value;
}

void VdbWalker::skip(std::uint64_t size, const char* what) {
    need(size, what);
    m_at += size;
}

std::uint32_t VdbWalker::metadataCount() {
    const auto count = number<std::uint32_t>("the metadata");
    // An entry takes at least three lengths.
    if (count > left() / 12) damaged(fmt::format("it claims {} entries of metadata", count));
    return count;
}

void VdbWalker::damaged(const std::string& reason) const {
    throw Error(ErrorKind::input, shortened(m_bytes.path() + ": truncated or damaged: " + reason, 1000));
}

void VdbWalker::need(std::uint64_t size, const char* what) const {
    if (size > left())
        damaged(fmt::format("{} at byte {} needs {} bytes, the file ends after {}", what, m_at, size, left()));
}

VdbFiles openFiles(const std::string& path, std::span<const std::string> others) {
    VdbFiles files;
    files.push_back(std::make_unique<VdbBytes>(path));
    for (std::size_t i = 1; i < others.size(); ++i) files.push_back(std::make_unique<VdbBytes>(others[i]));
    return files;
}

}  // namespace scrim
