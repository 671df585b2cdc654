// SPDX-License-Identifier: Apache-2.0
// Limits for work on untrusted data in a process that was made for that work alone. A library that would hang or use up
// all memory ends the process instead.
#pragma once

#include <sys/resource.h>

#include <cstdint>

namespace mesh {

/// A limit on this process that lasts as long as this object.
class LimitForNow {
  public:
    LimitForNow(decltype(RLIMIT_AS) resource, rlim_t value);
    ~LimitForNow();
    LimitForNow(const LimitForNow&) = delete;
    LimitForNow& operator=(const LimitForNow&) = delete;

    /// True if this process's limit was below `value` before.
    bool wasLess(rlim_t value) const { return m_known && m_before.rlim_cur < value; }

  private:
    decltype(RLIMIT_AS) m_resource;
    rlimit m_before{};
    bool m_known = false;
};

/// While this object lives, the process may take that many bytes beyond what such a process starts with (further
/// allocations throw std::bad_alloc), and that many seconds of processor time (after which SIGXCPU ends it).
class AloneLimits {
  public:
    AloneLimits(std::uint64_t moreMemory, unsigned seconds);

    /// True if this process has less memory than that anyway. A lack of memory then says nothing about the work.
    bool lackMemory() const { return m_lackMemory; }

  private:
    LimitForNow m_time;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // sanitizers reserve terabytes
    LimitForNow m_memory;
#endif
    bool m_lackMemory = false;
};

}  // namespace mesh
