// SPDX-License-Identifier: Apache-2.0
// An open file descriptor that belongs to one object.
#pragma once

#include <unistd.h>

namespace scrim {

/// Owns an open file descriptor and closes it.
class Descriptor {
  public:
    explicit Descriptor(int fd = -1) : m_fd(fd) {}
    ~Descriptor() {
        if (m_fd >= 0) ::close(m_fd);
    }
    Descriptor(Descriptor&& other) noexcept : m_fd(other.release()) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        const Descriptor before(m_fd);
        m_fd = other.release();
        return *this;
    }
    int fd() const { return m_fd; }
    int release() {
        const int fd = m_fd;
        m_fd = -1;
        return fd;
    }

  private:
    int m_fd;
};

}  // namespace scrim
