// SPDX-License-Identifier: Apache-2.0
// A full disk, without filling one: the kernel refuses to let files grow beyond a limit.
#pragma once

#include <sys/resource.h>

#include <csignal>
#include <cstddef>

namespace scrim::test {

/// While it lives, writing a file beyond `bytes` fails with EFBIG ("File too large") in the whole process.
class FileSizeLimit {
  public:
    explicit FileSizeLimit(std::size_t bytes) : m_oldHandler(std::signal(SIGXFSZ, SIG_IGN)) {
        ::getrlimit(RLIMIT_FSIZE, &m_old);
        rlimit limited = m_old;
        limited.rlim_cur = bytes;
        ::setrlimit(RLIMIT_FSIZE, &limited);
    }
    ~FileSizeLimit() {
        ::setrlimit(RLIMIT_FSIZE, &m_old);
        std::signal(SIGXFSZ, m_oldHandler);
    }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;

  private:
    void (*m_oldHandler)(int);
    rlimit m_old{};
};

}  // namespace scrim::test
