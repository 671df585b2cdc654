// SPDX-License-Identifier: Apache-2.0
// Limits for work on data nobody can trust, in a process that was made for that work alone: where a library would hang
// or eat all memory there, it ends.
#pragma once

#include <sys/resource.h>

#include <cstdint>

namespace mesh {

/// A limit of this process that ends with this object.
class LimitForNow {
  public:
    LimitForNow(decltype(RLIMIT_AS) resource, rlim_t value);
    ~LimitForNow();
    LimitForNow(const LimitForNow&) = delete;
    LimitForNow& operator=(const LimitForNow&) = delete;

    /// Had this process less than `value` before?
    bool wasLess(rlim_t value) const { return m_known && m_before.rlim_cur < value; }

  private:
    decltype(RLIMIT_AS) m_resource;
    rlimit m_before{};
    bool m_known = false;
};

/// While it lives, this process has so many bytes beside what such a process begins with, beyond which there is
/// std::bad_alloc, and so many seconds of processor time, beyond which SIGXCPU ends it.
class AloneLimits {
  public:
    AloneLimits(std::uint64_t moreMemory, unsigned seconds);

    /// Has this process less memory than that anyway? Then a lack of it says nothing about the work.
    bool lackMemory() const { return m_lackMemory; }

  private:
    LimitForNow m_time;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they reserve terabytes
    LimitForNow m_memory;
#endif
    bool m_lackMemory = false;
};

}  // namespace mesh
