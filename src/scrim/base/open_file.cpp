// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/open_file.h>

#include <scrim/base/error.h>
#include <scrim/base/system_error.h>

#include <array>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace scrim {

// Without O_NONBLOCK, opening a FIFO would wait for a writer.
OpenFile::OpenFile(const std::string& path)
    : m_file(aboveStandardStreams(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK))) {
    const int error = errno;
    if (const ErrorKind kind = kindOfSystemError(error, ErrorKind::input); m_file.fd() < 0 && kind != ErrorKind::input)
        throw Error(kind, fmt::format("{}: {}", path, systemErrorText(error)));
    struct stat status {};
    if (m_file.fd() < 0 || ::fstat(m_file.fd(), &status) != 0)
        m_problem = errno == ENOENT ? "there is no such file" : std::strerror(errno);
    else if (!S_ISREG(status.st_mode))
        m_problem = "is not a file";
    else
        m_size = static_cast<std::uint64_t>(status.st_size);
}

std::string bytesOf(const std::string& path) {
    const Descriptor file(aboveStandardStreams(::open(path.c_str(), O_RDONLY | O_CLOEXEC)));
    std::string bytes;
    std::array<char, 65536> part;
    ssize_t got = file.fd() < 0 ? -1 : 1;
    while (got > 0 || (got < 0 && errno == EINTR)) {
        got = ::read(file.fd(), part.data(), part.size());
        if (got > 0) bytes.append(part.data(), std::size_t(got));
    }
    if (got < 0)
        throw Error(kindOfSystemError(errno, ErrorKind::input),
                    fmt::format("{}: cannot be read: {}", shortened(path), systemErrorText(errno)));
    return bytes;
}

}  // namespace scrim
